"""The file by which the dead reckoning of a robot with ROS outlives the driver process."""

from __future__ import annotations

import contextlib
import json
import logging
import math
from pathlib import Path
from typing import Final

from hub import files
from hub.pose import Pose
from hub.robots.ros.odometry import KeptReckoning

_logger = logging.getLogger(__name__)

_PERIOD_S: Final = 1.0
"""Least time between two saves [s]."""
_MOST_BYTES: Final = 1000
_MOST: Final = 2**32 - 1


class ReckoningFile:
    """Saves the last place of a robot, once per second while it changes."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._saved: KeptReckoning | None = None
        self._due = -math.inf

    def read(self) -> KeptReckoning | None:
        """What the process before has saved; None: nothing that can be used."""
        with contextlib.suppress(OSError, ValueError, TypeError, OverflowError, RecursionError):
            number, *numbers = json.loads(files.read_own(self._path, _MOST_BYTES))
            x, y, theta, measured, clock = map(float, numbers)
            finite = all(map(math.isfinite, (x, y, theta, measured, clock)))
            if type(number) is int and 0 < number <= _MOST and finite:
                pose = Pose(x=x, y=y, theta=theta)
                return KeptReckoning(number=number, pose=pose, measured=measured, clock=clock)
        return None

    def save(self, kept: KeptReckoning | None, now: float) -> None:
        """Save the last place, if it is due [s, monotonic]."""
        if kept is None or kept is self._saved or now < self._due:
            return
        self._saved, self._due = kept, now + _PERIOD_S
        pose = kept.pose
        values = [kept.number, pose.x, pose.y, pose.theta, kept.measured, kept.clock]
        try:
            files.replace(self._path, json.dumps(values).encode(), sync=False)
        except OSError as fault:
            self._due = math.inf  # once is enough to say it
            _logger.warning("%s cannot be written: %s", self._path, fault.strerror or fault)
