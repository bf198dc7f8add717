"""A simulated underwater robot: the BlueROV2 Heavy with eight thrusters and a tether.

Numbers: von Benzon, Sorensen, Uth, Jouffroy, Liniger, Pedersen 2022, "An Open-Source Benchmark
Simulator: Control of a BlueROV2 Underwater Robot", J. Mar. Sci. Eng. 10(12). They are for sea
water: in fresh water it sinks. That the team has an underwater robot is of the report of 2005;
sensors, holds and surfacing are our own design, after the modes of ArduSub.

When no motion is commanded, it brakes by reverse thrust to rest over the ground. Then it holds its
depth, its heading and its attitude. It cannot hold its place: a current carries it.
"""

from __future__ import annotations

import enum
import math

import numpy as np

from hub.gcm.body import HoldKind
from hub.sim.afloat.attitude import Vector, into_body
from hub.sim.afloat.body_contact import ContactShape
from hub.sim.afloat.floating_body import HullSpec, Six
from hub.sim.afloat.fluid import SEA_WATER_DENSITY, submerged, thrust_share
from hub.sim.afloat.holds import (
    OFF,
    Brake,
    ClimbGains,
    Held,
    RestingPlace,
    TiltGains,
    TiltHold,
    TurnGains,
)
from hub.sim.afloat.lithium_battery import LithiumBattery
from hub.sim.afloat.motion import NEUTRAL, BodyVelocity
from hub.sim.afloat.rov_senses import RovReadings, RovSenses
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.tether import Tether, TetherSpec
from hub.sim.afloat.thrusters import EightThrusters
from hub.sim.afloat.vehicle import STEP, FloatingVehicle
from hub.sim.arena_specs import WaterSpec
from hub.sim.spatial_pose import SpatialPose

SHAPE = ContactShape(radius=0.30, above=0.127, below=0.127)
"""A frame of 0.46 m by 0.58 m, 0.254 m high."""
LIMITS = BodyVelocity(surge=0.7, sway=0.55, heave=0.5, roll=0.5, pitch=0.5, yaw=1.2)
"""Within full thrust, with a reserve that keeps it upright: 0.734 m/s ahead, 0.726 m/s up."""
SURFACED = 0.15
"""Depth of the robot's middle when it floats at the surface [m]."""
IDLE_POWER = 18.0
"""Of computer, camera and electronics [W]; our assumption."""

_CLIMB = ClimbGains(climb_per_metre=0.9, fastest=0.45, force_per_climb=110.0, stopped=0.05)
_TURN = TurnGains(moment_per_angle=12.0, moment_per_rate=5.0, stopped=0.1)
_TILT = TiltGains(moment_per_angle=12.0, moment_per_rate=3.0, most=math.radians(30.0))
_BRAKING = 60.0
"""Reverse thrust for a measured speed [N s/m]."""
_SLOW = 0.03
"""The robot is at rest below this speed [m/s]."""


def hull(density: float = SEA_WATER_DENSITY) -> HullSpec:
    """The numbers of von Benzon et al. 2022 in water of a density [kg/m^3]."""
    return HullSpec(
        mass=13.5,
        volume=0.0134,
        density=density,
        sag=0.01,
        inertia=(0.26 + 0.189, 0.23 + 0.135, 0.37 + 0.222),
        added=(6.36, 7.12, 18.68),
        linear=(13.7, 0.0, 33.0, 0.0, 0.8, 0.0),
        quadratic=(141.0, 217.0, 190.0, 1.19, 0.47, 1.5),
    )


class Dive(enum.Enum):
    """What the robot does.

    | state | event | next |
    | --- | --- | --- |
    | DIVING | `surface()` or a leak | SURFACING |
    | SURFACING, no leak | a command that is not neutral | DIVING |
    | SURFACING, no leak | `brake_and_hold()`, a hold of the depth | DIVING |

    Attributes:
        DIVING: It follows commands, and holds depth and heading while they are neutral.
        SURFACING: Thrusters bring it up and keep it there; commands steer it, except heave.
    """

    DIVING = "diving"
    SURFACING = "surfacing"


class SimulatedRov(FloatingVehicle):
    """The whole underwater robot: hull, thrusters, tether, sensors, holds, battery, current."""

    limits = LIMITS
    vertical = HoldKind.DEPTH

    def __init__(
        self,
        surroundings: Surroundings,
        *,
        start: SpatialPose,
        water: WaterSpec,
        tether: TetherSpec | None = None,
        density: float = SEA_WATER_DENSITY,
        leaks_at: float = math.inf,
        charge: float = 1.0,
        seed: int = 0,
    ) -> None:
        """Hold the depth and heading of the start.

        Args:
            surroundings: Solids and ground of its pool.
            start: Its first pose; z counts from the pool's floor.
            water: Surface and current.
            tether: Its cable; 25 m from the surface above the start, if None.
            density: Of the water [kg/m^3].
            leaks_at: Simulated time from which it has a leak [s].
            charge: Of the battery, 0 to 1.
            seed: Of all noise.
        """
        super().__init__(
            hull(density),
            SHAPE,
            surroundings,
            start,
            battery=LithiumBattery(
                cells=4, energy=266.0 * 3600.0, resistance=0.02, fraction=charge
            ),
            climb=_CLIMB,
            turn=_TURN,
        )
        self._water = water
        self._flow: Vector = (*water.current, 0.0)
        self._thrusters = EightThrusters()
        x, y, _ = self._body.position
        cable = tether or TetherSpec(length=25.0, anchor=(x, y, water.surface))
        self._tether = Tether(cable, self._body.position, start.yaw)
        self._leaks_at = leaks_at
        spec = self._body.hull
        self._senses = RovSenses(
            surroundings, self._body, water, self._tether, np.random.SeedSequence(seed)
        )
        self._tilt_hold = TiltHold(_TILT)
        self._brakes = [Brake(spec, axis, gain=_BRAKING, stopped=_SLOW) for axis in (0, 1)]
        self._place = RestingPlace(_SLOW)
        self._dive = Dive.DIVING

    def brake_and_hold(self) -> None:
        """Brake, level the body, hold depth and heading."""
        self._end_surfacing()
        self._keep()
        self._tilt_hold.level()

    def surface(self) -> None:
        """Come up by thrusters and stay at the surface."""
        self.brake_and_hold()
        self._dive = Dive.SURFACING

    def start_hold(self, kind: HoldKind, target: float = math.nan) -> None:
        """Hold a depth below the surface or a heading."""
        if kind is HoldKind.DEPTH:
            self._end_surfacing()
        super().start_hold(kind, max(target, SURFACED) if kind is HoldKind.DEPTH else target)

    @property
    def dive(self) -> Dive:
        """Whether it dives or comes up."""
        return self._dive

    @property
    def readings(self) -> RovReadings:
        """The last measurements of its sensors."""
        return self._senses.readings

    @property
    def tether(self) -> Tether:
        """Its cable."""
        return self._tether

    @property
    def thrust(self) -> Six:
        """Forces and moments of all thrusters now [N, N m]."""
        return self._thrusters.wrench

    @property
    def hold(self) -> Held:
        """What it holds, and whether that fails."""
        x, y, _ = self._body.position
        goal = self._height_hold.goal
        off = self._height_hold.off(self._senses.vertical.height)
        return Held(
            depth=None if goal is None else -goal,
            heading=self._heading_hold.goal,
            braking=self._place.braking and self._commanded == NEUTRAL,
            off=off,
            carried=self._place.carried(x, y),
            fails=abs(off) > OFF,
        )

    @property
    def leaking(self) -> bool:
        """Whether water comes in."""
        return self.time >= self._leaks_at

    def _vertical_place(self) -> float:
        return self._senses.vertical.height

    def _moved(self) -> None:
        self._end_surfacing()

    def _end_surfacing(self) -> None:
        if not self.leaking:
            self._dive = Dive.DIVING

    def _step(self) -> None:
        body = self._body
        moving = self._commanded != NEUTRAL
        self._senses.advance(body, self._thrusters, leak=self.leaking, moving=moving)
        if self._senses.readings.leak and self._dive is Dive.DIVING:
            self.surface()
        self._thrusters.advance(self._wanted() if self.powered else (0.0,) * 6, STEP)
        self._battery = self._battery.after(STEP, IDLE_POWER + self._thrusters.power)
        depth = self._water.surface - body.position[2]
        pull = self._tether.pull(body.position, body.world_velocity, self._flow)
        px, py, pz = into_body(body.attitude, pull)
        share = thrust_share(depth)
        x, y, z, roll, pitch, yaw = (share * each for each in self._thrusters.wrench)
        self._move((x + px, y + py, z + pz, roll, pitch, yaw), self._flow, submerged(depth))
        x, y, _ = body.position
        vx, vy, vz = body.world_velocity
        speed = math.hypot(vx - self._flow[0], vy - self._flow[1], vz)
        self._place.follow(x, y, speed, moving=self._commanded != NEUTRAL)

    def _wanted(self) -> Six:
        """Forces and moments that commands and holds want [N, N m]."""
        seen, wanted = self._senses.readings, self._commanded
        if self._dive is Dive.SURFACING:
            if self._height_hold.goal != -SURFACED:
                self._height_hold.hold(-SURFACED)
            lift = self._height_hold.lift(self._senses.vertical, 0.0)
        else:
            lift = self._height_hold.lift(self._senses.vertical, wanted.heave)
        self._tilt_hold.turn(wanted.roll, wanted.pitch, STEP)
        p, q, r = seen.rates
        roll, pitch = self._tilt_hold.moments(seen.roll, seen.pitch, p, q)
        x, y, z = (lift * each for each in self._senses.up())
        yaw = self._heading_hold.moment(seen.heading, r, wanted.yaw)
        ahead, left = self._brakes
        moving = wanted != NEUTRAL
        x += ahead.force(seen.surge, wanted.surge, STEP, moving=moving)
        y += left.force(seen.sway, wanted.sway, STEP, moving=moving)
        return x, y, z, roll, pitch, yaw
