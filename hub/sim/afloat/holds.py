"""Controllers that hold a height or depth, a heading, a speed and an attitude; pure.

They take estimates, not the true motion, and give forces and moments.
"""

from __future__ import annotations

import math

from hub.pose import wrapped
from hub.sim.afloat.estimators import HEAVE, SURGE, ClimbObserver
from hub.sim.afloat.floating_body import HullSpec
from hub.values import dataclass

OFF = 0.3
"""A hold fails when the robot is farther from its height or depth [m]."""
REACHED = 0.1
"""A height, depth or heading counts as reached within this [m or rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ClimbGains:
    """How a body holds its height.

    Attributes:
        climb_per_metre: Wanted climb for an error [1/s].
        fastest: Largest climb while it corrects an error [m/s].
        force_per_climb: Force for an error of the climb [N s/m].
        stopped: The climb below which it begins to hold after a command [m/s].
    """

    climb_per_metre: float
    fastest: float
    force_per_climb: float
    stopped: float


class Hold:
    """What a height hold and a heading hold have in common.

    | state | event | then |
    | --- | --- | --- |
    | any | `hold(goal)` | on; it goes to the goal |
    | any | `here()` | on; there is no goal |
    | any | `end()` | off; there is no goal |
    | on | its motion is commanded | there is no goal |
    | on, no goal | its motion is not commanded | it brakes |
    | on, no goal | it stopped | where it is becomes the goal |
    | off | its motion is not commanded | it brakes, then drifts |

    Attributes:
        on: Whether it holds something, now or after a command.
        goal: What it holds [m or rad]; None: nothing now.
        reached: Whether it was once near the goal; only then the hold can fail.
    """

    def __init__(self) -> None:
        self.on = True
        self.goal: float | None = None
        self.reached = False

    def hold(self, goal: float) -> None:
        """Go to a height [m] or heading [rad] and hold it."""
        self.on = True
        self.goal = goal
        self.reached = False

    def here(self) -> None:
        """Brake, and hold where that ends."""
        self.on = True
        self.release()

    def stay(self) -> None:
        """Hold the goal; where it is, if that is not reached yet."""
        self.on = True
        if not self.reached:
            self.release()

    def end(self) -> None:
        """Hold nothing until it is switched on again."""
        self.on = False
        self.release()

    def release(self) -> None:
        """Hold nothing until the next motion ended."""
        self.goal = None
        self.reached = False


class HeightHold(Hold):
    """Holds the height at which a climb ended.

    A cascade: the error of the height gives a climb, and the error of the climb a force. The known
    drag of the wanted climb and the estimated trim are added.
    """

    def __init__(self, hull: HullSpec, gains: ClimbGains) -> None:
        super().__init__()
        self._hull = hull
        self._gains = gains

    def lift(self, seen: ClimbObserver, commanded: float) -> float:
        """Upward force [N] for a commanded climb [m/s]."""
        gains = self._gains
        if commanded:
            self.release()
            wanted = commanded
        else:
            if self.on and self.goal is None and abs(seen.climb) < gains.stopped:
                self.goal = seen.height
            wanted = 0.0
            if self.goal is not None:
                off = self.goal - seen.height
                self.reached = self.reached or abs(off) < REACHED
                wanted = max(-gains.fastest, min(gains.fastest, gains.climb_per_metre * off))
        known = self._hull.drag(HEAVE, wanted) - seen.trim
        return gains.force_per_climb * (wanted - seen.climb) + known

    def off(self, height: float) -> float:
        """Height above the goal [m]; 0 before it was reached."""
        return height - self.goal if self.goal is not None and self.reached else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnGains:
    """How a body holds its heading.

    Attributes:
        moment_per_angle: For an error of the heading [N m/rad].
        moment_per_rate: For an error of the turn rate [N m s/rad].
        stopped: The turn rate below which it begins to hold after a command [rad/s].
    """

    moment_per_angle: float
    moment_per_rate: float
    stopped: float


class HeadingHold(Hold):
    """Holds the heading at which a turn ended."""

    def __init__(self, hull: HullSpec, gains: TurnGains) -> None:
        super().__init__()
        self._hull = hull
        self._gains = gains

    def hold(self, goal: float) -> None:
        """Turn to a heading [rad] and hold it."""
        super().hold(wrapped(goal))

    def moment(self, heading: float, rate: float, commanded: float) -> float:
        """Moment about z [N m].

        Args:
            heading: As estimated [rad].
            rate: As measured [rad/s].
            commanded: Turn rate that is wanted [rad/s]; 0 holds.
        """
        gains = self._gains
        if commanded:
            self.release()
            known = self._hull.drag(5, commanded)
            return gains.moment_per_rate * (commanded - rate) + known
        if self.on and self.goal is None and abs(rate) < gains.stopped:
            self.goal = heading
        moment = -gains.moment_per_rate * rate
        if self.goal is not None:
            off = wrapped(self.goal - heading)
            self.reached = self.reached or abs(off) < REACHED
            moment += gains.moment_per_angle * off
        return moment


def speed_force(hull: HullSpec, gain: float, speed: float, wanted: float) -> float:
    """Forward force [N] to a wanted speed through the fluid; for 0 it brakes by reverse thrust.

    Args:
        hull: The body, for its drag.
        gain: Force for an error of the speed [N s/m].
        speed: As estimated [m/s].
        wanted: As commanded [m/s].
    """
    return gain * (wanted - speed) + hull.drag(SURGE, wanted)


class Brake:
    """Ends a motion by reverse thrust, and then leaves the body to the fluid.

    Without a measured speed it does not brake, so it pushes no body that stands.

    | state | event | next |
    | --- | --- | --- |
    | any | a motion is commanded | READY |
    | READY | no motion is commanded | it brakes |
    | READY | no motion is commanded, and the measured speed is below `stopped` | OFF |
    | READY | no motion is commanded, and no speed is measured | OFF |
    | READY | it has braked for `LONGEST` | OFF |
    """

    LONGEST = 3.0
    """A current does not let it come to rest; then it brakes no longer than this [s]."""

    def __init__(self, hull: HullSpec, axis: int, *, gain: float, stopped: float) -> None:
        """Start OFF.

        Args:
            hull: The body, for its drag.
            axis: Number of the axis of the motion.
            gain: Force for the measured speed [N s/m].
            stopped: The speed below which the motion has ended [m/s].
        """
        self._hull = hull
        self._axis = axis
        self._gain = gain
        self._stopped = stopped
        self._left = 0.0

    def force(self, measured: float, wanted: float, seconds: float, *, moving: bool) -> float:
        """Force along the axis for a short time [N].

        Args:
            measured: Speed along the axis [m/s]; NaN: not known.
            wanted: The commanded one [m/s].
            seconds: The time.
            moving: Whether any motion is commanded: a turn leaves a speed aside too.
        """
        if moving:
            self._left = self.LONGEST
            return self._hull.drag(self._axis, wanted)
        self._left = self._left - seconds if abs(measured) >= self._stopped else 0.0
        return -self._gain * measured if self._left > 0.0 else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TiltGains:
    """How a body holds its roll and pitch.

    Attributes:
        moment_per_angle: [N m/rad]
        moment_per_rate: [N m s/rad]
        most: Largest roll and pitch that can be commanded [rad].
    """

    moment_per_angle: float
    moment_per_rate: float
    most: float


class TiltHold:
    """Holds a roll and a pitch, which commanded rates move.

    Attributes:
        roll: That it holds [rad].
        pitch: That it holds [rad].
    """

    def __init__(self, gains: TiltGains) -> None:
        self._gains = gains
        self.roll = 0.0
        self.pitch = 0.0

    def turn(self, roll_rate: float, pitch_rate: float, seconds: float) -> None:
        """Move the held angles at commanded rates [rad/s], within the limit."""
        most = self._gains.most
        self.roll = max(-most, min(most, self.roll + roll_rate * seconds))
        self.pitch = max(-most, min(most, self.pitch + pitch_rate * seconds))

    def level(self) -> None:
        """Hold the body level."""
        self.roll = self.pitch = 0.0

    def moments(
        self, roll: float, pitch: float, roll_rate: float, pitch_rate: float
    ) -> tuple[float, float]:
        """Moments about x and y [N m] for measured angles [rad] and rates [rad/s]."""
        gains = self._gains
        return (
            gains.moment_per_angle * (self.roll - roll) - gains.moment_per_rate * roll_rate,
            gains.moment_per_angle * (self.pitch - pitch) - gains.moment_per_rate * pitch_rate,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """What a floating robot holds.

    Attributes:
        height: Height above the ground that it holds [m]; None: none.
        depth: Depth below the surface that it holds [m]; None: none.
        heading: Heading that it holds, as its compass shows it [rad]; None: none.
        braking: Whether it still brakes.
        off: Height above the one that it holds [m]; negative below.
        carried: How far it drifted since it came to rest [m], from its true place; a real robot
            needs a camera that looks down for it.
        fails: Whether it is off by more than 0.3 m, or a blimp was carried more than 1 m.
    """

    height: float | None = None
    depth: float | None = None
    heading: float | None = None
    braking: bool = False
    off: float = 0.0
    carried: float = 0.0
    fails: bool = False


class RestingPlace:
    """Measures how far a robot drifts after it came to rest.

    Attributes:
        braking: Whether it has not come to rest yet.
    """

    def __init__(self, slow: float) -> None:
        """Start in motion.

        Args:
            slow: It is at rest below this speed [m/s].
        """
        self._slow = slow
        self._place = (0.0, 0.0)
        self.braking = True

    def follow(self, x: float, y: float, speed: float, *, moving: bool) -> None:
        """Take place [m], speed [m/s] and whether a motion is commanded."""
        if moving:
            self.braking = True
        elif self.braking and speed < self._slow:
            self.braking = False
            self._place = (x, y)

    def carried(self, x: float, y: float) -> float:
        """Distance from where it came to rest [m]; 0 before."""
        return 0.0 if self.braking else math.hypot(x - self._place[0], y - self._place[1])
