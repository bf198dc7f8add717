"""Where the robot was when a picture was taken; pure."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hub.gcm.fields import FARTHEST_M
from hub.gcm.navigation import RobotState
from hub.pose import Pose, wrapped

_KEPT_S = 5.0
"""Older poses are forgotten [s]; no picture takes that long."""
_MOST = 1000
AHEAD_S = 0.5
"""So long after the newest pose it is carried on with its velocity [s]; then it is not known."""
GAP_S = 1.0
"""Between two poses farther apart than this, the pose is not known [s]."""


UNKNOWN = Pose(x=math.nan, y=math.nan, theta=math.nan)
"""What is told of a place that is not known."""


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

    def add(self, state: RobotState, measured: float) -> None:
        """The robot says where it was at `measured` [s]; what is not finite is ignored."""
        values = (measured, state.x, state.y, state.theta, state.linear, state.angular)
        if not all(map(math.isfinite, values)):
            return
        # What comes late, as from a second navigation, would put the past into disorder.
        if self._entries and measured <= self._entries[-1].measured:
            return
        self._entries.append(_Entry(*values))
        while self._entries[0].measured < measured - _KEPT_S:
            self._entries.popleft()

    def at(self, time: float) -> Pose:
        """Where the robot was in `map` at a time on the same clock [s]; NaN: not known."""
        after = None
        for entry in reversed(self._entries):
            if entry.measured <= time:
                return _carried_on(entry, time) if after is None else _between(entry, after, time)
            after = entry
        return UNKNOWN


def _carried_on(entry: _Entry, time: float) -> Pose:
    """Along the circle that its velocities make, as Thrun, Probabilistic Robotics, 5.3."""
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
