"""New scans in the robot's reports, and the robot's pose at each of them; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import RobotState
from hub.modules.mapping.evidence import Floats
from hub.values import dataclass

LONGEST_LAG = 0.2
"""Largest age of a scan in a report [s]."""
FASTEST = 100.0
"""Larger velocities are not valid [m/s or rad/s]."""
SAME_PLACE = 0.05
"""Scans nearer to each other than this come from the same place [m]."""
SAME_HEADING = math.radians(5.0)
"""The same for the heading [rad]."""
SCANS_A_PLACE = 2
"""Largest number of scans used from one place: a sonar repeats its errors."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """Ranges, and the pose at which they were measured.

    Attributes:
        x: Position in `map` [m].
        y: Position in `map` [m].
        theta: Heading in `map` [rad].
        sonar: Range of each sonar from the centre [m], shape (16,); inf: no echo; NaN: not new.
        infrared: The same.
    """

    x: float
    y: float
    theta: float
    sonar: Floats
    infrared: Floats


class ScanSelector:
    """Picks the new scans out of the reports.

    Reports come more often than scans, and repeat the last one. Only ranges that differ from the
    report before are new: noise makes equal ranges unlikely. No echo counts as new when another
    sensor of the ring is new, or when the robot has moved.
    """

    def __init__(self) -> None:
        self._last: tuple[Floats, Floats] | None = None
        self._measured = -math.inf
        self._place = (math.inf, math.inf, 0.0)
        self._from_here = 0

    def scan(self, state: RobotState, measured: float) -> Scan | None:
        """The new scan in a report.

        Args:
            state: The report.
            measured: When it was measured, on one monotonic clock [s].

        Returns:
            None if there is none, or if enough of them came from this place.
        """
        elapsed = min(max(measured - self._measured, 0.0), LONGEST_LAG)
        self._measured = measured
        last, self._last = self._last, (state.sonar, state.infrared)
        if not all(math.isfinite(part) for part in (state.x, state.y, state.theta)):
            return None
        x, y, theta = _back(state, elapsed / 2.0)
        moved = self._moved(x, y, theta)
        sonar = _new_ranges(state.sonar, None if last is None else last[0], moved=moved)
        infrared = _new_ranges(state.infrared, None if last is None else last[1], moved=moved)
        if np.isnan(sonar).all() and np.isnan(infrared).all():
            return None
        if moved:
            self._place, self._from_here = (x, y, theta), 0
        self._from_here += 1
        if self._from_here > SCANS_A_PLACE:
            return None
        return Scan(x=x, y=y, theta=theta, sonar=sonar, infrared=infrared)

    def _moved(self, x: float, y: float, theta: float) -> bool:
        """Whether the robot is at another place than at the scan before."""
        place_x, place_y, heading = self._place
        turned = abs(math.remainder(theta - heading, 2.0 * math.pi))
        return math.hypot(x - place_x, y - place_y) > SAME_PLACE or turned > SAME_HEADING


def _new_ranges(now: Floats, before: Floats | None, *, moved: bool) -> Floats:
    """The new ranges; NaN for the others."""
    if before is None:
        return now
    new = now != before
    new |= np.isinf(now) & (moved or bool(new.any()))
    return np.where(new, now, np.float32(np.nan)).astype(np.float32)


def _back(state: RobotState, seconds: float) -> tuple[float, float, float]:
    """The robot's pose at the scan [m, m, rad].

    The scan was made at some time since the report before; half of that time is the best
    guess. The velocities give the motion since. The pose before does not: a landmark may
    just have corrected it.
    """
    if not (abs(state.linear) <= FASTEST and abs(state.angular) <= FASTEST):
        return state.x, state.y, state.theta
    turn = state.angular * seconds
    way = state.linear * seconds
    heading = state.theta - turn / 2.0
    return (
        state.x - way * math.cos(heading),
        state.y - way * math.sin(heading),
        state.theta - turn,
    )
