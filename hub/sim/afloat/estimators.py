"""Estimates of a floating robot's motion from its sensors and its own thrust; pure."""

from __future__ import annotations

import math

from hub.pose import wrapped
from hub.sim.afloat.floating_body import HullSpec

HEAVE = 2
SURGE = 0


class ClimbObserver:
    """Estimates height, climb and trim from measured heights and the known lift.

    An observer of third order (Luenberger 1971) with all poles at the same rate. The trim is the
    steady force that the thrust does not explain: weight, buoyancy, a tether.

    Attributes:
        height: Estimated height [m].
        climb: Estimated upward velocity [m/s].
        trim: Estimated steady force, positive up [N].
    """

    def __init__(self, hull: HullSpec, *, height: float, rate: float, most_trim: float) -> None:
        """Start at rest.

        Args:
            hull: The body, for its mass and drag.
            height: At the start [m].
            rate: Of all poles [1/s].
            most_trim: Largest trim that is believed [N].
        """
        self._hull = hull
        self._mass = hull.mass + hull.added[HEAVE]
        self._rate = rate
        self._most_trim = most_trim
        self.height = height
        self.climb = 0.0
        self.trim = 0.0

    def predict(self, lift: float, seconds: float) -> None:
        """Advance under a known upward thrust [N]."""
        force = lift + self.trim - self._hull.drag(HEAVE, self.climb)
        middle = self.climb + 0.5 * seconds * force / self._mass
        self.height += seconds * middle
        self.climb += seconds * force / self._mass

    def correct(
        self, height: float, seconds: float, trust: float = 1.0, *, steady: bool = True
    ) -> None:
        """Use a measured height [m].

        Args:
            height: As measured.
            seconds: Since the measurement before.
            trust: Share of the full correction, 0 to 1.
            steady: Whether forces that the thrust does not explain are the trim. A body that
                leans while it drives has others.
        """
        error = trust * (height - self.height) * seconds
        rate = self._rate
        self.height += 3.0 * rate * error
        self.climb += 3.0 * rate * rate * error
        if steady:
            trim = self.trim + self._mass * rate**3 * error
            self.trim = max(-self._most_trim, min(self._most_trim, trim))

    def rest_at(self, height: float) -> None:
        """Start again at rest at a height [m]; the trim stays."""
        self.height = height
        self.climb = 0.0


class EchoReference:
    """Turns ranges to the ground below into heights above the first ground.

    A table below makes the range jump. Such ranges are rejected. If they go on, the robot is over
    other ground: its height stays, and the ground below gets a new height.

    | range is off by | event | then |
    | --- | --- | --- |
    | at most `JUMP` | a range | height is range plus ground |
    | more than `JUMP` | one of the first ranges | rejected: no height |
    | more than `JUMP` | `JUMPS` ranges in a row | the ground is new; its height follows |

    Attributes:
        ground: Height of the ground below over the first ground [m].
    """

    JUMP = 0.5
    """Largest difference from the expected range that is believed at once [m]."""
    JUMPS = 5
    """Ranges in a row that are off before the ground below counts as other ground."""

    def __init__(self) -> None:
        self.ground = 0.0
        self._jumps = 0

    def height(self, distance: float, expected: float) -> float:
        """Height above the first ground [m]; NaN for none.

        Args:
            distance: From the robot's middle to the ground below [m]; NaN without an echo.
            expected: The height as estimated without this range [m].
        """
        if math.isnan(distance):
            self._jumps = 0
            return math.nan
        off = expected - distance - self.ground
        if abs(off) <= self.JUMP:
            self._jumps = 0
            return distance + self.ground
        self._jumps += 1
        if self._jumps < self.JUMPS:
            return math.nan
        self._jumps = 0
        self.ground += off
        return expected


class HeadingFilter:
    """Estimates the heading from a gyro, which drifts, and a compass, which errs with the place.

    Attributes:
        heading: Counter-clockwise from x [rad].
    """

    COMPASS_TIME = 5.0
    """Time in which the compass takes over from the gyro [s]."""

    def __init__(self, compass: float) -> None:
        self.heading = wrapped(compass)

    def advance(self, rate: float, compass: float, seconds: float) -> None:
        """Use a turn rate [rad/s] and a compass heading [rad]."""
        self.heading += rate * seconds
        self.heading += wrapped(compass - self.heading) * seconds / self.COMPASS_TIME
        self.heading = wrapped(self.heading)


class AirspeedObserver:
    """Estimates the forward speed through the air from the known thrust and an anemometer.

    The anemometer stands below a least speed; there the thrust alone says how the speed changes.

    Attributes:
        speed: Through the air, forward [m/s].
    """

    CORRECTION_TIME = 0.4
    """Time in which the anemometer corrects the estimate [s]."""

    def __init__(self, hull: HullSpec, *, least: float) -> None:
        self._hull = hull
        self._mass = hull.mass + hull.added[SURGE]
        self._least = least
        self.speed = 0.0

    def advance(self, thrust: float, measured: float, seconds: float) -> None:
        """Use the forward thrust [N] and the anemometer's reading [m/s] of a step."""
        force = thrust - self._hull.drag(SURGE, self.speed)
        self.speed += seconds * force / self._mass
        expected = self.speed if abs(self.speed) >= self._least else 0.0
        self.speed += seconds / self.CORRECTION_TIME * (measured - expected)
