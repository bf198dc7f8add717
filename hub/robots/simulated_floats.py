"""The simulated blimp and the simulated underwater robot as bodies of the driver."""

from __future__ import annotations

import abc
import math
from dataclasses import replace

from hub.errors import ArenaError
from hub.gcm.body import HoldBody, HoldKind, RobotBody
from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import GroundTruth
from hub.gcm.vehicle import Arming, HoldPhase, HoldState, VehicleState
from hub.pose import Pose, wrapped
from hub.robots.interfaces import Sensors
from hub.robots.left_alone import LeftAlone
from hub.robots.simulation_faults import NO_WATER
from hub.sim.afloat.blimp import Flight, SimulatedBlimp
from hub.sim.afloat.fluid import pressure_at
from hub.sim.afloat.motion import NEUTRAL
from hub.sim.afloat.rov import Dive, SimulatedRov
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.vehicle import STEP, FloatingVehicle
from hub.sim.arena import Arena
from hub.sim.kinematics import limited, moved
from hub.sim.spatial_pose import SpatialPose

FLIES_AT = 1.2
"""Height of a blimp's start where the arena has no berth for it [m]."""
LEAK = DiagnosticStatus(
    level=Severity.ERROR, name="leak", message="water in the hull: the robot surfaces"
)
_FLIGHTS = {Flight.LANDING: "lands", Flight.LANDED: "stands"}
DIVES_AT = 0.5
"""Depth of an underwater robot's start where the arena has no berth for it [m]."""


class _FloatingBody(abc.ABC):
    """What both have in common; implements `Body`, `BodyLeftAlone`, `BodyHolds` and `BodyArms`.

    It has no encoders: its dead reckoning adds up the speed that it measures, and the commanded
    one where it measures none.
    """

    def __init__(self, vehicle: FloatingVehicle, body: RobotBody, origin: int) -> None:
        """Take a vehicle at its start.

        Args:
            vehicle: The simulated vehicle.
            body: Its described velocities, which limit the commands too, and holds.
            origin: Number of its start.
        """
        self._vehicle = vehicle
        self._limits = [0.0] * 6
        for motion in body.motions:
            self._limits[motion.freedom] = motion.limit
        self._holds = body.holds
        self._arms = bool(body.arms)
        self._origin = origin
        self._reckoned = Pose()
        self._heading = vehicle.readings.heading

    @property
    @abc.abstractmethod
    def speed(self) -> tuple[float, float]:
        """The speeds ahead and to the left that it measures or assumes [m/s]."""

    def command(self, twist: Twist) -> None:
        """Set the velocity; NaN counts as 0."""
        linear, angular = twist.linear, twist.angular
        wanted = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
        self._vehicle.command(*map(limited, wanted, self._limits))

    def hold(self, kind: HoldKind, target: float) -> None:
        """Hold a height, a depth or a heading; NaN: the present one."""
        if kind is HoldKind.HEADING:
            target += self._vehicle.readings.heading - self._reckoned.theta
        self._vehicle.start_hold(kind, target)

    def release(self, kind: HoldKind) -> None:
        """Hold it no longer."""
        self._vehicle.end_hold(kind)

    def arm(self, *, armed: bool) -> None:
        """Give the motors power, or switch them off."""
        self._vehicle.arm(armed=armed)

    def advance(self, seconds: float) -> None:
        """Advance the simulated time."""
        before = self._vehicle.time
        self._vehicle.advance(seconds)
        passed = self._vehicle.time - before
        ahead, left = self.speed
        heading = self._vehicle.readings.heading
        turn = wrapped(heading - self._heading)
        self._heading = heading
        self._reckoned = moved(self._reckoned, ahead * passed, turn, left * passed)

    def ground_truth(self) -> GroundTruth:
        """Its true pose in the arena's frame."""
        pose, velocity = self._vehicle.pose, self._vehicle.velocity
        commanded = self._vehicle.commanded
        return GroundTruth(
            time=self._vehicle.time,
            x=pose.x,
            y=pose.y,
            theta=wrapped(pose.yaw),
            linear=velocity.surge,
            angular=velocity.yaw,
            commanded_linear=commanded.surge,
            commanded_angular=commanded.yaw,
            contacts=self._vehicle.contacts,
            touching=int(self._vehicle.touching),
            z=pose.z,
            roll=pose.roll,
            pitch=pose.pitch,
            sway=velocity.sway,
            heave=velocity.heave,
            contact_angle=self._vehicle.impact.bearing,
            impact_speed=self._vehicle.impact.approach / STEP,
        )

    def _measured(self) -> Sensors:
        """The part that both measure."""
        read, battery = self._vehicle.readings, self._vehicle.battery
        wanted, pose = self._vehicle.commanded, self._reckoned
        surge, sway = self.speed
        turning = Vector3(**dict(zip("xyz", read.rates, strict=True)))
        return Sensors(
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            velocity=Twist(linear=Vector3(x=surge, y=sway, z=read.climb), angular=turning),
            commanded=Twist(
                linear=Vector3(x=wanted.surge, y=wanted.sway, z=wanted.heave),
                angular=Vector3(z=wanted.yaw),
            ),
            battery_voltage=battery.voltage,
            battery_fraction=battery.fraction,
            roll=read.roll,
            pitch=read.pitch,
            heading=read.heading,
            climb=read.climb,
            origin=self._origin,
            vehicle=self._state(),
        )

    def _hold_state(self, hold: HoldBody) -> HoldState:
        """What a hold does; headings are those of the dead reckoning, not of the compass."""
        state = self._vehicle.hold_state(hold.kind, hold.tolerance)
        if hold.kind is HoldKind.HEADING:
            state = replace(state, target=wrapped(self._reckoned.theta - state.error))
        return state

    def _state(self) -> VehicleState:
        """Holds, arming, and what it does."""
        holds = tuple(map(self._hold_state, self._holds))
        armed = Arming.ARMED if self._vehicle.armed else Arming.DISARMED
        phases = {hold.phase for hold in holds}
        if self._vehicle.commanded != NEUTRAL:
            activity = "drives"
        elif not phases.isdisjoint((HoldPhase.HOLDING, HoldPhase.FAILING)):
            activity = "holds"
        else:
            activity = "brakes" if HoldPhase.READY in phases else "drifts"
        return VehicleState(
            activity=activity, arming=armed if self._arms else Arming.NONE, holds=holds
        )


class BlimpBody(_FloatingBody):
    """The blimp."""

    def __init__(self, arena: Arena, body: RobotBody, *, seed: int = 0) -> None:
        """Fly at its berth, else over the start.

        Args:
            arena: Its arena.
            body: Its described velocities.
            seed: Of all noise.
        """
        start = start_of(arena, "blimp", FLIES_AT)
        self._blimp = SimulatedBlimp(
            Surroundings.in_air(arena), start=start, air=arena.air, seed=seed
        )
        super().__init__(self._blimp, body, arena.place_number(start))

    @property
    def speed(self) -> tuple[float, float]:
        """Through the air; it measures none to the side [m/s]."""
        return self._blimp.readings.airspeed, 0.0

    def sensors(self, stamp: float) -> Sensors:  # noqa: ARG002 - it has no range sensors
        """The present measurements."""
        read = self._blimp.readings
        common = self._measured()
        activity = _FLIGHTS.get(self._blimp.flight, common.vehicle.activity)
        return replace(
            common,
            z=read.height,
            height=read.height,
            above_ground=read.altitude,
            vehicle=replace(common.vehicle, activity=activity),
        )

    def left_alone(self, action: LeftAlone | None) -> None:
        """Brake and hold, with any action; it lands after ten minutes or at a low battery."""
        if action is None:
            self._blimp.resume()
        else:
            self._blimp.brake_and_hold()


class RovBody(_FloatingBody):
    """The underwater robot."""

    def __init__(
        self, arena: Arena, body: RobotBody, *, seed: int = 0, leaks_at: float = math.inf
    ) -> None:
        """Dive at its berth, else below the surface over the start.

        Args:
            arena: Its arena.
            body: Its described velocities.
            seed: Of all noise.
            leaks_at: Simulated time from which it has a leak [s].

        Raises:
            ArenaError: There is no water.
        """
        if arena.water is None:
            raise ArenaError(arena.name, [NO_WATER])
        start = start_of(arena, "rov", arena.water.surface - DIVES_AT)
        self._rov = SimulatedRov(
            Surroundings.under_water(arena),
            start=start,
            water=arena.water,
            leaks_at=leaks_at,
            seed=seed,
        )
        super().__init__(self._rov, body, arena.place_number(start))

    @property
    def speed(self) -> tuple[float, float]:
        """Over the ground; where its log has none, as commanded [m/s]."""
        read, wanted = self._rov.readings, self._rov.commanded
        if math.isnan(read.surge):
            return wanted.surge, wanted.sway
        return read.surge, read.sway

    def sensors(self, stamp: float) -> Sensors:  # noqa: ARG002 - it has no range sensors
        """The present measurements."""
        read = self._rov.readings
        common = self._measured()
        vehicle = replace(
            common.vehicle,
            tether_paid=self._rov.tether.paid_out,
            tether_length=self._rov.tether.length,
            tether_turns=read.tether_turns,
        )
        if self._rov.dive is Dive.SURFACING:
            vehicle = replace(vehicle, activity="surfaces")
        return replace(
            common,
            z=-read.depth,
            depth=read.depth,
            pressure=pressure_at(read.depth),
            above_ground=read.altitude,
            diagnostics=(LEAK,) if read.leak else (),
            vehicle=vehicle,
        )

    def left_alone(self, action: LeftAlone | None) -> None:
        """Surface, or hold depth and heading, also for a new operator."""
        if action is LeftAlone.SURFACE:
            self._rov.surface()
        else:
            self._rov.brake_and_hold()


def start_of(arena: Arena, robot: str, height: float) -> SpatialPose:
    """The first pose of a robot: its berth, else the start at a height [m]."""
    berth = arena.berth(robot)
    if berth is not None:
        return SpatialPose(x=berth.at[0], y=berth.at[1], z=berth.height, yaw=berth.heading)
    return SpatialPose(x=arena.start.x, y=arena.start.y, z=height, yaw=arena.start.theta)
