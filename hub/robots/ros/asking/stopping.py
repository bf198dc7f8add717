"""What stops a robot whose commands end: the time-outs in its parameters; pure."""

from __future__ import annotations

import math
import re
from typing import Final

from hub.robots.ros.asking.findings import RosFindings, number
from hub.robots.ros.line import RosTopic
from hub.robots.ros.own_nodes import foreign
from hub.values import dataclass

SAFE_S: Final = 1.0
"""A robot that drives on for longer than this is unsafe [s]."""
_TIME_OUT: Final = re.compile(
    r"(?P<node>.*?)[./](?:cmd_vel_timeout(?:_sec)?|cmd_timeout|command_timeout|"
    r"(?:base_)?watchdog_timeout)"
)
_FIRMWARE: Final = {"motion_control": 0.5}
"""Nodes that stop by themselves, without a parameter that says so, and after which time [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stopping:
    """What the robot does when commands end.

    Attributes:
        seconds: After which time it stops [s]; infinite: never; NaN: not known.
        source: The parameter or node that says so; empty: nothing does.
    """

    seconds: float = math.nan
    source: str = ""

    @property
    def safe(self) -> bool:
        """Whether it stops soon, as far as is known."""
        return self.seconds <= SAFE_S

    @property
    def words(self) -> str:
        """What stops it, in words."""
        if math.isnan(self.seconds):
            return "it is not known whether the robot stops by itself: no parameter has a time-out"
        if math.isinf(self.seconds):
            return f"the robot keeps the last command for ever: {self.source} is 0"
        return f"the robot stops {self.seconds:g} s after the last command: {self.source}"


def stopping(found: RosFindings, command: RosTopic | None) -> Stopping:
    """What stops a robot; of several time-outs, that of a node that takes the commands."""
    if command is None:
        return Stopping()
    takers = foreign(command.subscribers)
    known: list[tuple[bool, Stopping]] = []
    for name, value in found.parameters.items():
        matched = _TIME_OUT.fullmatch(name)
        after = number(value)
        if matched is None or not math.isfinite(after):
            continue
        each = Stopping(seconds=after if after > 0 else math.inf, source=name)
        known.append((_node(matched["node"]) in map(_node, takers), each))
    for taker in takers:
        if taker.rpartition("/")[2] in _FIRMWARE:
            after = _FIRMWARE[taker.rpartition("/")[2]]
            known.append((True, Stopping(seconds=after, source=taker)))
    of_takers = [each for takes, each in known if takes]
    return max(of_takers or [each for _, each in known], key=_seconds, default=Stopping())


def _seconds(each: Stopping) -> float:
    return each.seconds


def _node(name: str) -> str:
    return name.strip("/")
