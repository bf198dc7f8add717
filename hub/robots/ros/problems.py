"""What is wrong with the line to a robot with ROS and with its odometry; pure.

| problem | severity | when |
| --- | --- | --- |
| ros | ERROR | the line is away |
| odometry | ERROR | its place is not known |
| odometry | WARN | places come late |
| own map | WARN | no frames join its own map with its odometry |
| battery | WARN | its charge jumped; it counts to 100, and the robot file does not say so |
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.plain_text import plain
from hub.robots.ros.line import RosLine
from hub.robots.ros.odometry import FRESH_S
from hub.robots.ros.whereabouts import RosWhereabouts
from hub.ros.battery import BatteryReader

_LATE_S: Final = 0.2
"""Delay of places from which on the line is too slow to drive well [s]."""


def line_problems(
    line: RosLine, address: str, places: RosWhereabouts, now: float
) -> Iterator[DiagnosticStatus]:
    """All present problems.

    Args:
        line: The line.
        address: Of the robot.
        places: Where it is.
        now: Monotonic time [s].
    """
    state, odometry = line.state, places.odometry
    if not state.up:
        why = f": {plain(state.why)[:300]}" if state.why else ""
        text = f"the line to {address} is away{why}"
        yield DiagnosticStatus(level=Severity.ERROR, name="ros", message=text)
    elif not odometry.fresh(now):
        text = _unknown(line, places, now)
        yield DiagnosticStatus(level=Severity.ERROR, name="odometry", message=text)
    elif odometry.late > _LATE_S:
        text = f"places come {odometry.late:.1f} s late: the line, or a node before it, is too slow"
        yield DiagnosticStatus(level=Severity.WARN, name="odometry", message=text)
    if state.up and places.lacks_map(now):
        text = "the robot's own map is not used: its frames do not say where it is on it"
        yield DiagnosticStatus(level=Severity.WARN, name="own map", message=text)


def battery_problems(charge: BatteryReader, *, scaled: bool) -> Iterator[DiagnosticStatus]:
    """What is wrong with the charge of the battery.

    Args:
        charge: Its reader.
        scaled: Whether the robot file says that it counts to 100.
    """
    if charge.doubt:
        yield DiagnosticStatus(level=Severity.WARN, name="battery", message=charge.doubt)
    elif charge.percent and not scaled:
        text = (
            "its battery counts to 100: write battery_percent = true under [ros], "
            "else a hub that starts with an empty battery takes 1 % for a full one"
        )
        yield DiagnosticStatus(level=Severity.WARN, name="battery", message=text)


def _unknown(line: RosLine, places: RosWhereabouts, now: float) -> str:
    """Why the robot's place is not known."""
    name, odometry = places.source, places.odometry
    if name not in line.graph.topics:
        return f"its place is not known: nothing publishes {name}; see [ros], key 'odom'"
    if odometry.place is None:
        return f"its place is not known: nothing has come from {name}"
    if odometry.late >= FRESH_S:
        return f"its place is not known: {name} comes {odometry.late:.1f} s late"
    return f"its place is not known: {name} is silent for {now - odometry.place.measured:.0f} s"
