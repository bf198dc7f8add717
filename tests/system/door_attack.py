"""What attacks on doors have in common: who holds the robot, who is served, and what it costs."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hub.errors import HubError
from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import CONSOLE_HEARTBEAT, CONTROL_REQUEST, ConsoleHeartbeat, ControlRequest
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.client import Client
from tests.soak.rig import Started, Vitals
from tests.support.waiting import until
from tests.system.harness import Observer

TURN = 0.3
"""What the operator who has control commands [rad/s]."""
GROWTH_MB = 30.0
"""What a process may keep of an attack: buffers of its libraries, and no more for more inputs."""
MOST_LINES = 100
SERVED_S = 5.0
"""Longest gap in a stream of 20 Hz, and longest time for an answer, on a busy machine [s]."""


class TurningOperator:
    """Has control of the robot at its hub, and turns it all the time."""

    def __init__(self, endpoint: str) -> None:
        self.client = Client("alice", endpoint)
        self.client.wait_connected(20.0)
        self.client.define(VELOCITY_COMMAND, CONSOLE_HEARTBEAT)
        until(self._takes, 20.0, "there is no control")
        self._begin = time.monotonic() + 0.5
        self.client.every(0.2, self._beat)
        self.client.every(0.05, self._turn)

    def close(self) -> None:
        self.client.close()

    def _takes(self) -> bool:
        """Take control; a mirror's robot must know a new client first."""
        request = ControlRequest(operator="alice")
        with contextlib.suppress(HubError):
            return bool(
                self.client.query_response(
                    CONTROL_REQUEST, request, COMMON_RESULT, timeout=5.0
                ).done
            )
        return False

    def _beat(self) -> None:
        self.client.publish(CONSOLE_HEARTBEAT, ConsoleHeartbeat(holds=1))

    def _turn(self) -> None:
        wanted = TURN if time.monotonic() > self._begin else 0.0  # neutral first
        self.client.publish(VELOCITY_COMMAND, TwistStamped.planar(0.0, wanted))


class Served:
    """A client that a door must serve: a stream that goes on, and questions with answers.

    Attributes:
        gap_s: Longest time without anything new of the stream [s].
        answers: Number of answers.
        slowest_s: Longest time for an answer, even of one that is still missing [s].
    """

    def __init__(self, count: Callable[[], int], ask: Callable[[], object]) -> None:
        """Measure from now on.

        Args:
            count: How much of the stream has come.
            ask: Asks one question; call `answered` at its answer.
        """
        self._count, self._last, self._ask = count, count(), ask
        self._since = time.monotonic()
        self._asked: float | None = None
        self.gap_s = self.slowest_s = 0.0
        self.answers = 0

    def answered(self) -> None:
        """The answer has come."""
        self.answers += 1
        self._asked = None

    def look(self) -> None:
        """Look often."""
        now, count = time.monotonic(), self._count()
        self.gap_s = max(self.gap_s, now - self._since)
        if count != self._last:
            self._last, self._since = count, now
        if self._asked is None:
            self._asked = now
            self._ask()
        self.slowest_s = max(self.slowest_s, now - self._asked)


class Costs:
    """What an attack costs a process, and how many lines it logs."""

    def __init__(self, pid: int, *logs: Path) -> None:
        """Measure what it costs before."""
        self._pid, self._logs = pid, logs
        self._before, self._lines = Vitals.of(pid), self._logged()

    def figures(self, meanwhile: Callable[[], object]) -> dict[str, Any]:
        """What it cost, when it has had time to give memory and descriptors back."""
        end = time.monotonic() + 20.0
        until(lambda: self._back() or time.monotonic() > end, 30.0, meanwhile=meanwhile)
        lines = self._logged() - self._lines
        return {"before": self._before, "after": Vitals.of(self._pid), "lines": lines}

    def check(self) -> None:
        """Fail if it keeps more than it may."""
        assert self._back(), (self._before, Vitals.of(self._pid))
        assert self._logged() - self._lines <= MOST_LINES
        assert not any("Traceback" in each.read_text() for each in self._logs)

    def _back(self) -> bool:
        now = Vitals.of(self._pid)
        grown = now.memory_mb - self._before.memory_mb
        return grown <= GROWTH_MB and now.descriptors <= self._before.descriptors + 2

    def _logged(self) -> int:
        """Number of lines, without those that say who came and went."""
        lines = (line for each in self._logs for line in each.read_text().splitlines())
        return sum(" INFO " not in line for line in lines)


def attack(attacker: Started, meanwhile: Callable[[], object], longest_s: float) -> dict[str, Any]:
    """Wait for the end of an attack; what it did."""
    until(lambda: attacker.process.poll() is not None, longest_s, meanwhile=meanwhile)
    return attacker.line()


def driven(observer: Observer) -> list[float]:
    """The commanded speeds ahead that are not 0, of all that was seen."""
    return [truth.commanded_linear for _, truth in observer.history if truth.commanded_linear]


def turned(observer: Observer) -> bool:
    """Whether the wheels were commanded to turn as the operator says, and not otherwise."""
    said = {truth.commanded_angular for _, truth in observer.history}
    return all(each == 0.0 or math.isclose(each, TURN, rel_tol=1e-6) for each in said)
