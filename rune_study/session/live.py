"""What a running trial says of its robots now, for the experimenter; no part of the data."""

from __future__ import annotations

import contextlib
import json
import math
import time
from collections.abc import Sequence
from pathlib import Path

from hub import files
from rune_study.session.robots import WatchedRobot

LIVE = "now.json"
"""The file in the participant's folder."""
RobotSigns = dict[str, float]
"""Of a robot: `silent` [s], `speed` [m/s], `distance` [m], `collisions`, `victims`."""
_EVERY_S = 0.5
_MOST_BYTES = 16_384
_MOST_ROBOTS = 16


class LiveSigns:
    """Writes the state of a trial's robots, at most every half second."""

    def __init__(self, folder: Path) -> None:
        """Write into a participant's folder."""
        self._path = folder / LIVE
        self._next = 0.0

    def tell(self, robots: Sequence[WatchedRobot]) -> None:
        """Write the state; a disk that refuses changes nothing for the trial."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _EVERY_S
        signs = [signs_of(robot, now) for robot in robots]
        content = json.dumps({"at": time.time(), "robots": signs}).encode()
        with contextlib.suppress(OSError):
            files.replace(self._path, content, sync=False)


def signs_of(robot: WatchedRobot, now: float) -> RobotSigns:
    """The state of a robot at a moment [s]."""
    pose = robot.pose
    return {
        "silent": robot.silent_for(now),
        "speed": pose.linear if pose is not None else 0.0,
        "distance": robot.distance,
        "collisions": robot.collisions,
        "victims": robot.victims,
    }


def read_signs(folder: Path) -> tuple[float, list[RobotSigns]]:
    """When a session wrote last [s since 1970], and its robots; 0 and none without a sound file."""
    try:
        data = json.loads(files.read_regular(folder / LIVE, _MOST_BYTES))
        robots = [
            {name: float(value) for name, value in robot.items() if math.isfinite(value)}
            for robot in data["robots"][:_MOST_ROBOTS]
        ]
        return float(data["at"]), robots
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return 0.0, []
