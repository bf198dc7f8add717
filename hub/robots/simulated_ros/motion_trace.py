"""Writes each command and the motion of the robot into a file; tests read it while it grows.

Each line is JSON, with the monotonic time `at` [s]. A command has `twist`: forward [m/s], to the
left [m/s] and counter-clockwise [rad/s]. It has the stamp of its header [s], and `counts`: whether
the controller takes it. A motion has `motion`: forward and counter-clockwise. A call of a service
has its name, `service`. A change of the goal of the robot's own navigation has the goal's name,
`goal`, which is empty where there is none.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from hub.gcm.geometry import Twist


class MotionTrace:
    """The file."""

    def __init__(self, path: Path) -> None:
        """Open it, to add to what it has.

        Raises:
            OSError: It cannot be written.
        """
        self._file = path.open("a", buffering=1)

    def command(self, at: float, twist: Twist, stamp: float, *, counts: bool) -> None:
        """Write a command that came at a monotonic time [s]."""
        velocity = (twist.linear.x, twist.linear.y, twist.angular.z)
        self._write({"at": at, "twist": velocity, "stamp": stamp, "counts": counts})

    def motion(self, at: float, motion: Iterable[float]) -> None:
        """Write a motion at a monotonic time [s]."""
        self._write({"at": at, "motion": tuple(motion)})

    def call(self, at: float, service: str) -> None:
        """Write that a service was called at a monotonic time [s]."""
        self._write({"at": at, "service": service})

    def goal(self, at: float, name: str) -> None:
        """Write which goal the robot drives to from a monotonic time on [s]."""
        self._write({"at": at, "goal": name})

    def close(self) -> None:
        """Close it."""
        self._file.close()

    def _write(self, line: dict[str, object]) -> None:
        self._file.write(json.dumps(line) + "\n")
