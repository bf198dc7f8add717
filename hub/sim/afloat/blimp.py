"""A simulated indoor blimp, after the Blimp2b of EPFL.

Numbers: Zufferey, Guanella, Beyeler, Floreano 2006, "Flying over the reality gap: from simulated to
real indoor airships", Autonomous Robots 21, as in the files blimp2b.h and blimp2b.c of Webots. That
robots carry a blimp is of the report of 2005; sensors, holds and landing are our own design.

It flies slightly heavy: without power it lands. It has a front propeller, a tail propeller and a
lift propeller, so it cannot sway, roll or pitch by command.
"""

from __future__ import annotations

import enum
import math

import numpy as np

from hub.gcm.body import HoldKind
from hub.pose import wrapped
from hub.sim.afloat.blimp_senses import BlimpReadings, BlimpSenses
from hub.sim.afloat.body_contact import ContactShape
from hub.sim.afloat.floating_body import HullSpec
from hub.sim.afloat.fluid import AIR_DENSITY, Drafts
from hub.sim.afloat.holds import (
    OFF,
    ClimbGains,
    Held,
    RestingPlace,
    TurnGains,
    speed_force,
)
from hub.sim.afloat.lithium_battery import LithiumBattery
from hub.sim.afloat.motion import NEUTRAL, BodyVelocity
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.thrusters import TAIL_BEHIND, Propellers
from hub.sim.afloat.vehicle import STEP, FloatingVehicle
from hub.sim.arena_specs import AirSpec
from hub.sim.spatial_pose import SpatialPose

MASS = 0.184
"""[kg], blimp2b.h."""
SHAPE = ContactShape(radius=0.55, above=0.26, below=0.30)
"""Envelope of 1.09 m by 0.52 m, with the gondola below it."""
LIMITS = BodyVelocity(surge=0.75, heave=0.3, yaw=1.5)
"""Within full thrust: 0.756 m/s ahead, 1.53 rad/s to the left, 0.34 m/s up with a trim of 2 g."""
HEAVY = 0.002
"""Default trim: mass over that of the displaced air [kg]."""
LOW_BATTERY = 0.2
"""A blimp that is left alone lands below this charge."""
LONGEST_HOLD = 600.0
"""A blimp that is left alone lands after this time [s]."""
CARRIED_TOO_FAR = 1.0
"""A hold fails when drafts carried the blimp farther [m]."""
IDLE_POWER = 1.2
"""Of computer, camera and radio [W]; our assumption."""

_CLIMB = ClimbGains(climb_per_metre=0.60, fastest=0.30, force_per_climb=0.30, stopped=0.04)
_TURN = TurnGains(moment_per_angle=0.08, moment_per_rate=0.06, stopped=0.05)
_FORCE_PER_SPEED = 0.35
"""Force of the front propeller for an error of the airspeed [N s/m]."""
_ASTRAY = math.radians(10.0)
"""From this error of the heading on it flies slower [rad]."""
_LOST = math.radians(30.0)
"""At this error of the heading it stops [rad]."""
_SLOW = 0.1
"""The blimp is at rest below this speed [m/s]; drafts carry it as fast."""


def hull(heavy: float = 0.0) -> HullSpec:
    """The numbers of blimp2b.h, with a trim [kg] over the mass of the displaced air."""
    return HullSpec(
        mass=MASS,
        volume=(MASS - heavy) / AIR_DENSITY,
        density=AIR_DENSITY,
        sag=0.125,
        inertia=(0.0095, 0.0193, 0.0193),
        added=(0.033, 0.129, 0.129),
        linear=(0.0, 0.0, 0.0, 0.005, 0.0079, 0.0079),
        quadratic=(0.07, 0.28, 0.22, 0.0, 0.0, 0.0),
    )


class Flight(enum.Enum):
    """What the blimp does.

    | state | event | next |
    | --- | --- | --- |
    | FLYING | `land()`; or left alone for ten minutes, or with a low battery | LANDING |
    | LANDING | something holds it from below | LANDED |
    | LANDING | a command that is not neutral | FLYING |
    | LANDED | a climb is commanded | FLYING |

    Attributes:
        FLYING: It follows commands, and holds height and heading while they are neutral.
        LANDING: The lift propeller is off; it brakes and sinks.
        LANDED: All propellers are off.
    """

    FLYING = "flying"
    LANDING = "landing"
    LANDED = "landed"


class SimulatedBlimp(FloatingVehicle):
    """The whole blimp: hull, propellers, sensors, holds, battery, drafts."""

    limits = LIMITS
    vertical = HoldKind.HEIGHT

    def __init__(
        self,
        surroundings: Surroundings,
        *,
        start: SpatialPose,
        air: AirSpec | None = None,
        heavy: float = HEAVY,
        charge: float = 1.0,
        seed: int = 0,
    ) -> None:
        """Hold the height and heading of the start, or stand there.

        Args:
            surroundings: Solids and ground of its arena.
            start: Its first pose.
            air: Drafts and wind; None: it stands.
            heavy: Mass over that of the displaced air [kg]; the propeller lifts 4.6 g at most.
            charge: Of the battery, 0 to 1.
            seed: Of all noise.
        """
        super().__init__(
            hull(heavy),
            SHAPE,
            surroundings,
            start,
            battery=LithiumBattery(cells=2, energy=7.4 * 3600.0, resistance=0.1, fraction=charge),
            climb=_CLIMB,
            turn=_TURN,
        )
        air_seed, senses_seed = np.random.SeedSequence(seed).spawn(2)
        self._drafts = Drafts(air or AirSpec(draft=0.0), air_seed)
        self._propellers = Propellers()
        self._senses = BlimpSenses(surroundings, self._body, senses_seed)
        self._place = RestingPlace(_SLOW)
        self._alone_since = math.inf
        self._flight = Flight.LANDED if self._contact.supported else Flight.FLYING

    def brake_and_hold(self) -> None:
        """Brake, hold height and heading; after ten minutes or at a low battery, land.

        The ten minutes begin with the first of several calls. `resume` ends them, and a command
        that is not neutral.
        """
        self._keep()
        self._alone_since = min(self._alone_since, self.time)

    def resume(self) -> None:
        """Take note that it has an operator again; a landing goes on until a command."""
        self._alone_since = math.inf

    def land(self) -> None:
        """Stop the lift propeller, brake, and sink to what is below."""
        self._commanded = NEUTRAL
        if self._flight is Flight.FLYING:
            self._flight = Flight.LANDING

    @property
    def flight(self) -> Flight:
        """Whether it flies, lands or stands."""
        return self._flight

    @property
    def readings(self) -> BlimpReadings:
        """The last measurements of its sensors."""
        return self._senses.readings

    @property
    def thrusts(self) -> tuple[float, float, float]:
        """Of the front, the tail and the lift propeller now [N]: ahead, to turn left, up."""
        return self._propellers.ahead, self._propellers.left, self._propellers.up

    @property
    def hold(self) -> Held:
        """What it holds, and whether that fails."""
        if self._flight is not Flight.FLYING:
            return Held()
        x, y, _ = self._body.position
        off = self._height_hold.off(self._senses.vertical.height)
        carried = self._place.carried(x, y)
        return Held(
            height=self._height_hold.goal,
            heading=self._heading_hold.goal,
            braking=self._place.braking and self._commanded == NEUTRAL,
            off=off,
            carried=carried,
            fails=abs(off) > OFF or carried > CARRIED_TOO_FAR,
        )

    def _vertical_place(self) -> float:
        return self._senses.vertical.height

    def _moved(self) -> None:
        self.resume()
        if self._flight is Flight.LANDING or self._commanded.heave > 0.0:
            self._flight = Flight.FLYING

    def _step(self) -> None:
        self._drafts.advance(STEP)
        self._senses.advance(self._body, self._drafts.flow, self._propellers)
        self._change_flight()
        ahead, left, up = self._wanted_thrusts()
        self._propellers.advance(ahead, left, up, STEP)
        self._battery = self._battery.after(STEP, IDLE_POWER + self._propellers.power)
        self._move(self._propellers.wrench, self._drafts.flow)
        x, y, _ = self._body.position
        vx, vy, _ = self._body.world_velocity
        self._place.follow(x, y, math.hypot(vx, vy), moving=self._commanded != NEUTRAL)

    def _change_flight(self) -> None:
        """Take the next state of `Flight`."""
        alone = self.time - self._alone_since
        low = self._battery.fraction < LOW_BATTERY and alone >= 0.0
        if self._flight is Flight.FLYING and (alone >= LONGEST_HOLD or low):
            self._flight = Flight.LANDING
        if self._flight is Flight.LANDING and self._contact.supported:
            self._flight = Flight.LANDED
        if self._flight is not Flight.FLYING:
            self._height_hold.release()
            self._alone_since = math.inf
        if self._flight is Flight.LANDED:
            self._senses.vertical.rest_at(self._senses.vertical.height)

    def _wanted_thrusts(self) -> tuple[float, float, float]:
        """Thrusts ahead, to turn left, and up [N]."""
        if self._flight is Flight.LANDED or not self.powered:
            return 0.0, 0.0, 0.0
        spec, wanted = self._body.hull, self._commanded
        surge = wanted.surge * self._straight()
        ahead = speed_force(spec, _FORCE_PER_SPEED, self._senses.airspeed, surge)
        rate = self._senses.readings.rates[2]
        turn = self._heading_hold.moment(self._senses.readings.heading, rate, wanted.yaw)
        up = 0.0
        if self._flight is Flight.FLYING:
            up = self._height_hold.lift(self._senses.vertical, wanted.heave)
        return ahead, turn / TAIL_BEHIND, up

    def _straight(self) -> float:
        """Share of the commanded speed, 0 to 1: a body without fins must slow to turn back."""
        goal = self._heading_hold.goal
        if goal is None:
            return 1.0
        off = abs(wrapped(goal - self._senses.readings.heading))
        return max(0.0, min(1.0, (_LOST - off) / (_LOST - _ASTRAY)))
