"""The robot's pose at the time of a measurement or a picture; pure."""

from __future__ import annotations

import math
from collections import deque
from typing import Protocol

from hub.gcm.fields import FARTHEST_M
from hub.pose import Pose, wrapped
from hub.values import dataclass

_KEPT_S = 5.0
"""Older poses are forgotten [s]; no picture takes that long."""
_MOST = 1000
AHEAD_S = 0.5
"""Longest time to extrapolate the newest pose with its velocity [s]; later it is not known."""
GAP_S = 1.0
"""Largest time between two poses to interpolate [s]."""


UNKNOWN = Pose(x=math.nan, y=math.nan, theta=math.nan)
"""A pose that is not known."""


class Moving(Protocol):
    """A report with the robot's pose and velocity: `RobotState` or `DriveState`."""

    @property
    def x(self) -> float:
        """Position [m]."""

    @property
    def y(self) -> float:
        """Position [m]."""

    @property
    def theta(self) -> float:
        """Heading [rad]."""

    @property
    def linear(self) -> float:
        """Forward velocity [m/s]."""

    @property
    def angular(self) -> float:
        """Turn rate [rad/s]."""


@dataclass(frozen=True, slots=True)
class _Entry:
    measured: float
    x: float
    y: float
    theta: float
    linear: float
    angular: float


class PoseHistory:
    """Poses of the last seconds."""

    def __init__(self) -> None:
        self._entries: deque[_Entry] = deque(maxlen=_MOST)

    def add(self, state: Moving, measured: float) -> None:
        """Add the robot's pose at `measured` [s]; a pose that is not finite is ignored."""
        values = (measured, state.x, state.y, state.theta, state.linear, state.angular)
        if not all(map(math.isfinite, values)):
            return
        # A late pose, as from a second navigation, would break the order.
        if self._entries and measured <= self._entries[-1].measured:
            return
        self._entries.append(_Entry(*values))
        while self._entries[0].measured < measured - _KEPT_S:
            self._entries.popleft()

    def at(self, time: float) -> Pose:
        """The robot's pose at a time on the same clock [s]; NaN: not known."""
        after = None
        for entry in reversed(self._entries):
            if entry.measured <= time:
                return _carried_on(entry, time) if after is None else _between(entry, after, time)
            after = entry
        return UNKNOWN


def _carried_on(entry: _Entry, time: float) -> Pose:
    """Extrapolated along the circle of its velocities (Thrun, Probabilistic Robotics, 5.3)."""
    ahead = time - entry.measured
    if ahead > AHEAD_S:
        return UNKNOWN
    middle = entry.theta + entry.angular * ahead / 2.0
    # A chord, which for half a second of a wheeled robot is the arc to a millimetre.
    x = entry.x + entry.linear * ahead * math.cos(middle)
    y = entry.y + entry.linear * ahead * math.sin(middle)
    if max(abs(x), abs(y)) > FARTHEST_M:
        return UNKNOWN
    return Pose(x=x, y=y, theta=wrapped(entry.theta + entry.angular * ahead))


def _between(before: _Entry, after: _Entry, time: float) -> Pose:
    span = after.measured - before.measured
    if span > GAP_S:
        return UNKNOWN
    share = (time - before.measured) / span
    return Pose(
        x=before.x + (after.x - before.x) * share,
        y=before.y + (after.y - before.y) * share,
        theta=wrapped(before.theta + wrapped(after.theta - before.theta) * share),
    )
