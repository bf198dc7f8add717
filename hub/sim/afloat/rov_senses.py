"""The sensors of the underwater robot, and its estimates of climb and heading."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.orientation import roll_pitch_yaw
from hub.sim.afloat.attitude import Vector
from hub.sim.afloat.estimators import ClimbObserver, HeadingFilter
from hub.sim.afloat.floating_body import FloatingBody
from hub.sim.afloat.sensors import (
    Compass,
    DopplerLog,
    EchoSounder,
    Gyro,
    PressureSensor,
    TiltSensor,
)
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.tether import Tether
from hub.sim.afloat.thrusters import EightThrusters
from hub.sim.afloat.vehicle import STEP, Readings
from hub.sim.arena_specs import WaterSpec
from hub.values import dataclass

WORST_COMPASS = math.radians(5.0)
STEPS_PER_PING = 5
"""The echo sounder measures at 10 Hz, the others but the log in each step."""
STEPS_PER_LOG = 7
"""The Doppler log measures at 7 Hz."""
_OBSERVER_RATE = 4.0
_MOST_TRIM = 30.0
"""[N]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class RovReadings(Readings):
    """The last measurements, with their errors.

    Attributes:
        depth: By pressure [m].
        surge: Speed ahead over the ground [m/s]; NaN where the log has no ground.
        sway: The same to the left [m/s].
        leak: Whether there is water inside.
        tether_used: Share of the tether that is out, 0 to 1.
        tether_turns: Turns that twist it, counter-clockwise positive, by the measured heading.
    """

    depth: float
    surge: float
    sway: float
    leak: bool
    tether_used: float
    tether_turns: float


class RovSenses:
    """All sensors, and what is estimated from them.

    Attributes:
        readings: The last measurements.
        vertical: Estimates of height over the surface, climb and trim.
    """

    def __init__(
        self,
        surroundings: Surroundings,
        body: FloatingBody,
        water: WaterSpec,
        tether: Tether,
        seed: np.random.SeedSequence,
    ) -> None:
        """Switch the sensors on.

        Args:
            surroundings: Solids and ground of the pool.
            body: The robot at its start.
            water: Its surface is where the depth is 0.
            tether: Its turns are counted by the measured heading.
            seed: Of all noise.
        """
        seeds = iter(seed.spawn(6))
        self._surroundings = surroundings
        self._water = water
        self._tether = tether
        self._pressure = PressureSensor(next(seeds))
        self._compass = Compass(next(seeds), worst=WORST_COMPASS)
        self._gyro = Gyro(next(seeds))
        self._tilt = TiltSensor(next(seeds))
        self._sounder = EchoSounder(next(seeds))
        self._log = DopplerLog(next(seeds))
        x, y, z = body.position
        self.vertical = ClimbObserver(
            body.hull, height=z - water.surface, rate=_OBSERVER_RATE, most_trim=_MOST_TRIM
        )
        angles = roll_pitch_yaw(*body.attitude)
        self._headings = HeadingFilter(self._compass.measure(x, y, angles[2]))
        self._altitude = self._sounder.measure(surroundings, x, y, z)
        self._speed = self._logged(body, angles)
        self._steps = 0
        self.readings = self._read(body, angles, leak=False)

    def advance(
        self, body: FloatingBody, thrusters: EightThrusters, *, leak: bool, moving: bool
    ) -> None:
        """Measure for one step.

        Args:
            body: The true motion.
            thrusters: Their thrust is known to the estimates.
            leak: Whether water comes in.
            moving: Whether a motion is commanded.
        """
        x, y, z = body.position
        angles = roll_pitch_yaw(*body.attitude)
        self.vertical.predict(self._lift(thrusters), STEP)
        if self._steps % STEPS_PER_PING == 0:
            self._altitude = self._sounder.measure(self._surroundings, x, y, z)
        if self._steps % STEPS_PER_LOG == 0:
            self._speed = self._logged(body, angles)
        self._steps += 1
        self.readings = self._read(body, angles, leak=leak)
        self.vertical.correct(-self.readings.depth, STEP, steady=not moving)
        compass = self._compass.measure(x, y, angles[2])
        self._headings.advance(self.readings.rates[2], compass, STEP)
        self._tether.follow(self._headings.heading)

    def up(self) -> Vector:
        """The upward unit vector in the body's frame, as its tilt is measured."""
        roll, pitch = self.readings.roll, self.readings.pitch
        level = math.cos(pitch)
        return -math.sin(pitch), math.sin(roll) * level, math.cos(roll) * level

    def _lift(self, thrusters: EightThrusters) -> float:
        """Upward force of the thrusters [N]."""
        x, y, z, _, _, _ = thrusters.wrench
        up_x, up_y, up_z = self.up()
        return x * up_x + y * up_y + z * up_z

    def _logged(self, body: FloatingBody, angles: Vector) -> tuple[float, float]:
        x, y, z = body.position
        below = self._surroundings.below(x, y, z - DopplerLog.BELOW, DopplerLog.HALF_BEAM)
        tilt = math.hypot(angles[0], angles[1])
        return self._log.measure(below.distance, tilt, body.velocity[0], body.velocity[1])

    def _read(self, body: FloatingBody, angles: Vector, *, leak: bool) -> RovReadings:
        roll, pitch = self._tilt.measure(angles[0], angles[1])
        _, _, _, p, q, r = body.velocity
        return RovReadings(
            depth=self._pressure.measure(self._water.surface - body.position[2]),
            climb=self.vertical.climb,
            altitude=self._altitude,
            surge=self._speed[0],
            sway=self._speed[1],
            roll=roll,
            pitch=pitch,
            heading=self._headings.heading,
            rates=self._gyro.measure(p, q, r),
            leak=leak,
            tether_used=self._tether.used,
            tether_turns=self._tether.turns,
        )
