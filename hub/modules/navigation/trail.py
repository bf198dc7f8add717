"""The places where the robot has been, in `odom`: there is room for it on the way back; pure."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from hub.gcm.beam_scans import LARGEST_TILT
from hub.gcm.beams import Beams
from hub.pose import Pose, each_wrapped, wrapped

APART = 0.05
"""Distance between two places [m]."""
_TURNED = 0.1
"""A turn by this angle is another place too [rad]."""
_PLACES = 400
"""Places that are kept: 20 m."""
_NEXT = 0.5
"""A place of the way back is at most this far behind [m]."""
_ASIDE = 0.25
"""It is at most this far to a side [m]."""
_SLANTED = 0.5
"""The robot stood there with a heading that differs by less than this [rad]."""
_BEHIND = math.radians(45.0)
"""A sensor looks back if it looks within this angle of straight back [rad]."""


class Trail:
    """Says where the robot may back."""

    def __init__(self, beams: Beams) -> None:
        """Begin where the robot is.

        Args:
            beams: Its beams; with one that looks back it may back anywhere.
        """
        back = np.abs(each_wrapped(beams.bearing - math.pi)) < _BEHIND
        self._sees_back = bool((back & (np.abs(beams.elevation) <= LARGEST_TILT)).any())
        self._places: deque[Pose] = deque(maxlen=_PLACES)

    def moved(self, pose: Pose) -> None:
        """Take a pose of the robot."""
        if self._places:
            last = self._places[-1]
            way = math.hypot(pose.x - last.x, pose.y - last.y)
            if way < APART and abs(wrapped(pose.theta - last.theta)) < _TURNED:
                return
        self._places.append(pose)

    def way_back(self, pose: Pose, goal: tuple[float, float]) -> tuple[float, float] | None:
        """Where to back from a pose, in `base_link` [m]; None: it must not.

        With a sensor that looks back that is the goal. Else it is a place behind the robot where
        it has been.

        Args:
            pose: The robot's, in `odom`.
            goal: The point to head for, in `base_link` [m].
        """
        if self._sees_back:
            return goal
        places = (place.seen_from(pose) for place in self._places)
        behind = [
            (place.x, place.y)
            for place in places
            if -_NEXT <= place.x <= -APART
            and abs(place.y) <= _ASIDE
            and abs(place.theta) <= _SLANTED
        ]
        return min(behind, default=None)
