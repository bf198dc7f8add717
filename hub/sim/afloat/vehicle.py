"""What blimp and underwater robot share: commands, time in steps, true motion, contacts."""

from __future__ import annotations

import abc
import math

from hub.gcm.body import HoldKind
from hub.gcm.orientation import quaternion, roll_pitch_yaw
from hub.gcm.vehicle import HoldPhase, HoldState
from hub.pose import wrapped
from hub.sim.afloat.attitude import Vector
from hub.sim.afloat.body_contact import BodyContact, ContactShape
from hub.sim.afloat.floating_body import FloatingBody, HullSpec, Six
from hub.sim.afloat.holds import (
    ClimbGains,
    HeadingHold,
    HeightHold,
    Hold,
    TurnGains,
)
from hub.sim.afloat.lithium_battery import LithiumBattery
from hub.sim.afloat.motion import NEUTRAL, BodyVelocity
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.contact import NO_IMPACT, Impact
from hub.sim.spatial_pose import SpatialPose
from hub.sim.steps import WholeSteps
from hub.values import dataclass

STEP = 0.02
"""Length of a step of the simulation [s]."""
FRICTION_TIME = 0.3
"""Time in which friction stops a body that lies on something [s]; our choice."""
STUCK = 0.001
"""A body that lies on something and gets no faster than this in a step [m/s] stays; our choice."""
_FRICTION_SHARE = 1.0 - math.exp(-STEP / FRICTION_TIME)


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """The measurements that blimp and underwater robot share, with their errors.

    Attributes:
        climb: Upward velocity, estimated [m/s].
        altitude: From the middle to the ground below [m]; NaN without an echo.
        roll: [rad]
        pitch: [rad]
        heading: Of gyro and compass [rad].
        rates: About x, y and z [rad/s].
    """

    climb: float
    altitude: float
    roll: float
    pitch: float
    heading: float
    rates: tuple[float, float, float]


class FloatingVehicle(abc.ABC):
    """A simulated robot in a fluid.

    The same seed and the same calls give the same values to the last bit. Reading a state changes
    nothing.

    Attributes:
        armed: Whether its motors follow commands and holds.
    """

    limits: BodyVelocity
    """Largest velocities that can be commanded; 0 where the body has no such motion."""
    vertical: HoldKind
    """What it holds along the vertical: its height or its depth."""

    def __init__(
        self,
        hull: HullSpec,
        shape: ContactShape,
        surroundings: Surroundings,
        start: SpatialPose,
        *,
        battery: LithiumBattery,
        climb: ClimbGains,
        turn: TurnGains,
    ) -> None:
        self._body = FloatingBody(
            hull,
            (start.x, start.y, start.z),
            quaternion(start.roll, start.pitch, start.yaw),
        )
        self._surroundings = surroundings
        self._contact = BodyContact(surroundings, shape)
        self._impact = NO_IMPACT
        place = self._body.position
        self._body.position = self._contact.move(place, place)
        self._commanded = NEUTRAL
        self._battery = battery
        self._height_hold = HeightHold(self._body.hull, climb)
        self._heading_hold = HeadingHold(self._body.hull, turn)
        self.armed = True
        self._steps = 0
        self._time = WholeSteps(STEP)

    def command(
        self,
        surge: float = 0.0,
        sway: float = 0.0,
        heave: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
        yaw: float = 0.0,
    ) -> None:
        """Set the velocities along and about the body's axes [m/s, rad/s]; NaN counts as 0.

        The body uses those that it can. Where all are 0 it brakes, then holds. While it is
        disarmed all count as 0.
        """
        wanted = BodyVelocity(surge=surge, sway=sway, heave=heave, roll=roll, pitch=pitch, yaw=yaw)
        self._commanded = wanted.within(self.limits) if self.armed else NEUTRAL
        if self._commanded != NEUTRAL:
            self._moved()

    def advance(self, seconds: float) -> None:
        """Advance the simulated time in whole steps; the rest counts in the next call."""
        for _ in range(self._time.due(seconds)):
            self._step()
            self._steps += 1

    def arm(self, *, armed: bool) -> None:
        """Let the motors follow commands and holds, or switch them off.

        Afterwards it holds where it is then.
        """
        self.armed = armed
        self._commanded = NEUTRAL
        self._height_hold.release()
        self._heading_hold.release()

    def start_hold(self, kind: HoldKind, target: float = math.nan) -> None:
        """Hold a height, a depth or a heading [m or rad]; NaN: the present one."""
        hold = self._hold_of(kind)
        if math.isfinite(target):
            hold.hold(self._goal(kind, target))
        else:
            hold.here()

    def end_hold(self, kind: HoldKind) -> None:
        """Hold it no longer: without a command the body brakes, then drifts."""
        self._hold_of(kind).end()

    def hold_state(self, kind: HoldKind, tolerance: float) -> HoldState:
        """What a hold does; it fails when the body is farther off than a tolerance [m or rad]."""
        hold = self._hold_of(kind)
        if not hold.on or hold.goal is None:
            return HoldState(kind=kind, phase=HoldPhase.READY if hold.on else HoldPhase.OFF)
        if kind is HoldKind.HEADING:
            error = wrapped(self.readings.heading - hold.goal)
        else:
            error = self._sign * (self._vertical_place() - hold.goal)
        fails = hold.reached and abs(error) > tolerance
        return HoldState(
            kind=kind,
            phase=HoldPhase.FAILING if fails else HoldPhase.HOLDING,
            target=self._goal(kind, hold.goal),
            error=error,
        )

    def _keep(self) -> None:
        """Command nothing, and hold height or depth, and heading."""
        self._commanded = NEUTRAL
        self._height_hold.stay()
        self._heading_hold.stay()

    def _hold_of(self, kind: HoldKind) -> Hold:
        return self._heading_hold if kind is HoldKind.HEADING else self._height_hold

    @property
    def _sign(self) -> float:
        return -1.0 if self.vertical is HoldKind.DEPTH else 1.0

    def _goal(self, kind: HoldKind, target: float) -> float:
        """From the value of a hold to the goal of its controller, and back: depths count down."""
        return target if kind is HoldKind.HEADING else self._sign * target

    @property
    @abc.abstractmethod
    def readings(self) -> Readings:
        """The last measurements of its sensors."""

    @abc.abstractmethod
    def _vertical_place(self) -> float:
        """The estimated height above the first ground, or above the surface [m]."""

    @property
    def battery(self) -> LithiumBattery:
        """Its battery."""
        return self._battery

    @property
    def powered(self) -> bool:
        """Whether its motors have power: it is armed, and its battery is not empty."""
        return self.armed and self._battery.fraction > 0.0

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * STEP

    @property
    def commanded(self) -> BodyVelocity:
        """The velocities that are commanded now, within the limits."""
        return self._commanded

    @property
    def pose(self) -> SpatialPose:
        """The true pose in the arena's frame."""
        x, y, z = self._body.position
        roll, pitch, yaw = roll_pitch_yaw(*self._body.attitude)
        return SpatialPose(x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw)

    @property
    def velocity(self) -> BodyVelocity:
        """The true velocity over ground, along and about the body's axes."""
        u, v, w, p, q, r = self._body.velocity
        return BodyVelocity(surge=u, sway=v, heave=w, roll=p, pitch=q, yaw=r)

    @property
    def impact(self) -> Impact:
        """The last new contact with a solid."""
        return self._impact

    @property
    def contacts(self) -> int:
        """Number of new contacts with a solid since the start."""
        return self._contact.contacts

    @property
    def touching(self) -> bool:
        """Whether it touches a solid, the ground or the ceiling."""
        return bool(self._contact.touched or self._contact.normals)

    @abc.abstractmethod
    def _step(self) -> None:
        """Sense, control and move for one step."""

    @abc.abstractmethod
    def _moved(self) -> None:
        """Take note of a command that is not neutral."""

    def _move(self, thrust: Six, flow: Vector, submerged: float = 1.0) -> None:
        """Move the body for one step, and let it slide along what it meets."""
        body, contact = self._body, self._contact
        before, contacts = body.position, contact.contacts
        body.step(thrust, STEP, flow, submerged)
        body.position = contact.move(before, body.position)
        if contact.contacts != contacts:
            bearing, approach = contact.impact
            self._impact = Impact(wrapped(bearing - self.pose.yaw), approach)
        for normal in contact.normals:
            body.strike(normal)
        if contact.supported:
            self._rub()

    def _rub(self) -> None:
        """Slow a body that lies on something."""
        x, y, _ = self._body.world_velocity
        speed = math.hypot(x, y)
        if speed > 0.0:
            share = 1.0 if speed <= STUCK else _FRICTION_SHARE
            self._body.strike((-x / speed, -y / speed, 0.0), share)
        self._body.slow_yaw(_FRICTION_SHARE)
