"""The transform from `odom` to `map`, corrected by landmarks with known places; pure.

One landmark corrects the position; the heading is assumed to be right. Two landmarks seen soon
after each other correct the heading too. The error of the heading is the angle between two lines:
through their known places, and through their measured places. This is the smallest case of the
least-squares fit of Arun, Huang and Blostein (1987). The newest landmark is matched exactly,
because drift grows with time.
"""

from __future__ import annotations

import math

from hub.gcm.navigation import LandmarkCorrection
from hub.pose import Pose, wrapped
from hub.values import dataclass

LEAST_APART = 1.0
"""Least distance between two landmarks that correct the heading [m]."""
RECENT_S = 120.0
"""Largest age of a landmark that corrects the heading [s]."""
LARGEST_TURN = math.radians(30.0)
"""Largest correction of the heading at once [rad]; more means that landmarks were confused."""
FARTHEST_SEEN = 20.0
"""Landmarks seen from farther away are refused [m]."""
FARTHEST_PLACE = 1e4
"""Landmarks farther from the origin of `map` are refused [m]."""

_FIT_ERROR = 0.3
_FIT_ERROR_SHARE = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sighting:
    """A landmark: its place in `map`, where it was seen in `odom` [m], and when [s]."""

    place: tuple[float, float]
    seen: tuple[float, float]
    at: float


class PoseCorrection:
    """Keeps the transform from `odom` to `map`.

    Attributes:
        odom: The origin of `odom` in `map`; the same until the first correction.
    """

    def __init__(self) -> None:
        self.odom = Pose()
        self._last: _Sighting | None = None

    def restart(self, odom: Pose) -> None:
        """Start again with a given origin of `odom` in `map` and no landmarks."""
        self.odom, self._last = odom, None

    def pose(self, x: float, y: float, theta: float) -> Pose:
        """The pose in `map` of a pose in `odom` [m, m, rad]."""
        return self.odom.then(Pose(x=x, y=y, theta=theta))

    def shift(self, assumed: Pose, real: Pose) -> None:
        """Move the robot from an assumed pose in `map` to the real one."""
        self.odom = real.then(self.odom.seen_from(assumed))

    def correct(self, landmark: LandmarkCorrection, robot: Pose, now: float) -> str:
        """Correct by a landmark that is seen now.

        Args:
            landmark: Its known and its measured place.
            robot: The robot's pose in `odom`.
            now: Monotonic time [s].

        Returns:
            The result, for people.
        """
        if not _plausible(landmark):
            return "refused: the place of the landmark is not valid"
        sighting = _Sighting(
            place=(landmark.x, landmark.y),
            seen=robot.outward(landmark.seen_x, landmark.seen_y),
            at=now,
        )
        turn = self._turn(sighting)
        self._last = sighting
        theta = wrapped(self.odom.theta + (turn or 0.0))
        moved_x, moved_y = Pose(theta=theta).outward(*sighting.seen)
        before = self.pose(robot.x, robot.y, robot.theta)
        self.odom = Pose(x=landmark.x - moved_x, y=landmark.y - moved_y, theta=theta)
        after = self.pose(robot.x, robot.y, robot.theta)
        way = math.hypot(after.x - before.x, after.y - before.y)
        if turn is None:
            return f"moved by {way:.2f} m"
        return f"moved by {way:.2f} m and turned by {math.degrees(turn):.1f} degrees"

    def _turn(self, sighting: _Sighting) -> float | None:
        """The angle by which `odom` must turn [rad]; None: not known."""
        last = self._last
        if last is None or sighting.at - last.at > RECENT_S:
            return None
        known_x, known_y = sighting.place[0] - last.place[0], sighting.place[1] - last.place[1]
        seen_x, seen_y = sighting.seen[0] - last.seen[0], sighting.seen[1] - last.seen[1]
        known, seen = math.hypot(known_x, known_y), math.hypot(seen_x, seen_y)
        if known < LEAST_APART or abs(known - seen) > _FIT_ERROR + _FIT_ERROR_SHARE * known:
            return None
        should_be = math.atan2(known_y, known_x)
        turn = wrapped(should_be - math.atan2(seen_y, seen_x) - self.odom.theta)
        return turn if abs(turn) <= LARGEST_TURN else None


def _plausible(landmark: LandmarkCorrection) -> bool:
    numbers = (landmark.x, landmark.y, landmark.seen_x, landmark.seen_y)
    return (
        all(math.isfinite(number) for number in numbers)
        and max(abs(landmark.x), abs(landmark.y)) <= FARTHEST_PLACE
        and math.hypot(landmark.seen_x, landmark.seen_y) <= FARTHEST_SEEN
    )
