"""The uncertainty of the pose: it grows with each motion and shrinks with each match; pure.

The errors of dead reckoning follow the odometry motion model (Thrun, Burgard and Fox 2005, table
5.6). A turn and a distance each have a random error, drawn at each step, and a constant one, both
proportional to it: wheels slip, and their diameter is not known exactly. A straight line almost
never changes the heading, so a match may not turn it much there.
"""

from __future__ import annotations

import math

from hub.pose import Pose, wrapped
from hub.values import dataclass

STEP_S = 0.1
"""Length of a step of the error model [s]."""
TURN_ERROR = 0.14
"""Random error of a turn in one step, as a share of it."""
WAY_ERROR = 0.2
"""Random error of a distance in one step, as a share of it."""
SLIP = 0.02
"""Constant error of turns, as a share."""
LAID_WAY, LAID_TURN = 0.01, math.radians(0.1)
"""Errors of the position [m] and of the heading [rad] after a metre on which laser scans corrected
the pose; they grow with the root of the distance."""
LANDMARK_OFF = 0.05
"""Error of the position right after a correction by a landmark [m]."""

_LEAST_TURN = math.radians(0.6)
_LEAST_WAY = 0.01
_MOST_TURN = math.radians(6.0)
_MOST_WAY = 0.12
"""Largest spread that a match searches; farther off, too many parts of the map are alike."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Standard deviations of a pose.

    Attributes:
        turn: Of the heading [rad].
        way: Of the position, along each axis [m].
    """

    turn: float
    way: float


class PoseUncertainty:
    """Tracks the uncertainty of the pose."""

    def __init__(self) -> None:
        self._last = Pose()
        self._at = -math.inf
        self._turn_variance = 0.0
        self._way_variance = 0.0
        self._turned = 0.0
        self._driven = 0.0
        self._known = (0.0, 0.0)

    def moved(self, odom: Pose, now: float) -> None:
        """Take a pose by dead reckoning in `odom`, at a monotonic time [s]."""
        if now - self._at < STEP_S:
            return
        if math.isfinite(self._at):
            turn = wrapped(odom.theta - self._last.theta)
            way = math.hypot(odom.x - self._last.x, odom.y - self._last.y)
            self._turn_variance += (TURN_ERROR * turn) ** 2
            self._way_variance += (WAY_ERROR * way) ** 2
            self._turned += turn
            self._driven += way
        self._last, self._at = odom, now

    @property
    def spread(self) -> Spread:
        """The uncertainty now, limited to what a match searches."""
        whole = self.whole
        return Spread(turn=min(whole.turn, _MOST_TURN), way=min(whole.way, _MOST_WAY))

    @property
    def whole(self) -> Spread:
        """The uncertainty now."""
        turn = self._turn_variance + (SLIP * self._turned) ** 2 + _LEAST_TURN**2
        # An error of the heading that grew evenly along the path shifts the position aside.
        way = self._way_variance + self._driven**2 * turn / 3.0 + _LEAST_WAY**2
        return Spread(turn=math.sqrt(turn), way=math.sqrt(way))

    def matched(self, spread: Spread) -> None:
        """Set the uncertainty after a correction of the pose."""
        self._know(spread.turn**2, spread.way**2)

    def laid(self) -> None:
        """Set the uncertainty after a laser scan showed the motion since the last correction."""
        turn, way = self._known
        self._know(turn + LAID_TURN**2 * self._driven, way + LAID_WAY**2 * self._driven)

    def met_landmark(self) -> None:
        """Set the uncertainty after a correction by a landmark; that of the heading stays."""
        self.matched(Spread(turn=self.spread.turn, way=LANDMARK_OFF))

    def _know(self, turn: float, way: float) -> None:
        """Set the variances of heading and position."""
        self._known = self._turn_variance, self._way_variance = turn, way
        self._turned = self._driven = 0.0
