"""How far the pose may be off: grows with every turn and way, shrinks with every match; pure.

The errors of dead reckoning are those of the odometry motion model (Thrun, Burgard and Fox 2005,
table 5.6): a turn's and a way's errors are shares of themselves, drawn anew all the time, and each
has a constant share besides, because wheels slip and are not quite as large as they are said to be.
A straight way hardly changes the heading, and nothing that is seen may turn it there by much.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hub.pose import Pose, wrapped

STEP_S = 0.1
"""Errors are drawn anew after this time [s]."""
TURN_ERROR = 0.14
"""Error of the turn in that time, as a share of it."""
WAY_ERROR = 0.2
"""Error of the way in that time, as a share of it."""
SLIP = 0.02
"""Constant error of turns, as a share."""
LANDMARK_OFF = 0.05
"""How far off a place is that was just corrected by a landmark [m]."""

_LEAST_TURN = math.radians(0.6)
_LEAST_WAY = 0.01
_MOST_TURN = math.radians(6.0)
_MOST_WAY = 0.12
"""Further off, the pose is not looked for: too much of the map looks alike."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Standard deviations of a pose.

    Attributes:
        turn: Of the heading [rad].
        way: Of the place, along each axis [m].
    """

    turn: float
    way: float


class PoseUncertainty:
    """Follows how far the pose may be off."""

    def __init__(self) -> None:
        self._last = Pose()
        self._at = -math.inf
        self._turn_variance = 0.0
        self._way_variance = 0.0
        self._turned = 0.0
        self._gone = 0.0

    def moved(self, odom: Pose, now: float) -> None:
        """The wheels tell this pose in `odom`, at a monotonic time [s]."""
        if now - self._at < STEP_S:
            return
        if math.isfinite(self._at):
            turn = wrapped(odom.theta - self._last.theta)
            way = math.hypot(odom.x - self._last.x, odom.y - self._last.y)
            self._turn_variance += (TURN_ERROR * turn) ** 2
            self._way_variance += (WAY_ERROR * way) ** 2
            self._turned += turn
            self._gone += way
        self._last, self._at = odom, now

    @property
    def spread(self) -> Spread:
        """How far the pose may be off now, as far as it is worth looking for."""
        whole = self.whole
        return Spread(turn=min(whole.turn, _MOST_TURN), way=min(whole.way, _MOST_WAY))

    @property
    def whole(self) -> Spread:
        """How far the pose may be off now."""
        turn = self._turn_variance + (SLIP * self._turned) ** 2 + _LEAST_TURN**2
        # A heading that was off on the way, by a share that grew evenly, has led aside.
        way = self._way_variance + self._gone**2 * turn / 3.0 + _LEAST_WAY**2
        return Spread(turn=math.sqrt(turn), way=math.sqrt(way))

    def matched(self, spread: Spread) -> None:
        """The pose was corrected, and may be off by so much yet."""
        self._turn_variance, self._way_variance = spread.turn**2, spread.way**2
        self._turned = self._gone = 0.0

    def met_landmark(self) -> None:
        """The place was corrected by a landmark; the heading may be off as before."""
        self.matched(Spread(turn=self.spread.turn, way=LANDMARK_OFF))
