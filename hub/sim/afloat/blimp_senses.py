"""The sensors of the blimp, and its estimates of height, heading and speed."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.orientation import roll_pitch_yaw
from hub.sim.afloat.attitude import Vector, into_body
from hub.sim.afloat.estimators import (
    AirspeedObserver,
    ClimbObserver,
    EchoReference,
    HeadingFilter,
)
from hub.sim.afloat.floating_body import FloatingBody
from hub.sim.afloat.sensors import (
    Altimeter,
    Anemometer,
    Barometer,
    Compass,
    Gyro,
    TiltSensor,
)
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.thrusters import Propellers
from hub.sim.afloat.vehicle import STEP, Readings
from hub.values import dataclass

WORST_COMPASS = math.radians(10.0)
STEPS_PER_ECHO = 5
"""The altimeter and the barometer measure at 10 Hz, the others in each step."""
_ECHO_TIME = STEPS_PER_ECHO * STEP
_OBSERVER_RATE = 1.5
_MOST_TRIM = 0.06
"""[N]: 6 g."""
_BAROMETER_TRUST = 0.2
_BAROMETER_SHARE = 0.02
"""Share by which each echo corrects the barometer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlimpReadings(Readings):
    """The last measurements, with their errors.

    Attributes:
        height: Height above the first ground, estimated of all sensors [m].
        barometer: Height by air pressure [m]; it drifts.
        airspeed: Forward speed through the air [m/s].
    """

    height: float
    barometer: float
    airspeed: float


class BlimpSenses:
    """All sensors, and what is estimated from them.

    Attributes:
        readings: The last measurements.
        vertical: Estimates of height, climb and trim.
        airspeed: Estimated forward speed through the air [m/s].
    """

    def __init__(
        self, surroundings: Surroundings, body: FloatingBody, seed: np.random.SeedSequence
    ) -> None:
        """Switch the sensors on.

        Args:
            surroundings: Solids and ground of the arena.
            body: The blimp at its start.
            seed: Of all noise.
        """
        seeds = iter(seed.spawn(6))
        self._surroundings = surroundings
        self._altimeter = Altimeter(next(seeds))
        self._barometer = Barometer(next(seeds))
        self._compass = Compass(next(seeds), worst=WORST_COMPASS)
        self._gyro = Gyro(next(seeds))
        self._tilt = TiltSensor(next(seeds))
        self._anemometer = Anemometer(next(seeds))
        x, y, z = body.position
        self.vertical = ClimbObserver(
            body.hull,
            height=z - surroundings.ground.height(x, y),
            rate=_OBSERVER_RATE,
            most_trim=_MOST_TRIM,
        )
        self._echoes = EchoReference()
        self._airspeed = AirspeedObserver(body.hull, least=Anemometer.LEAST)
        roll, pitch, yaw = roll_pitch_yaw(*body.attitude)
        self._headings = HeadingFilter(self._compass.measure(x, y, yaw))
        self._pressure_height = self._barometer.measure(z, 0.0)
        self._pressure_offset = self._pressure_height - self.vertical.height
        self._altitude = self._altimeter.measure(surroundings, x, y, z, math.hypot(roll, pitch))
        self._steps = 0
        self.readings = self._read(body, (roll, pitch, yaw), (0.0, 0.0, 0.0))

    @property
    def airspeed(self) -> float:
        """Estimated forward speed through the air [m/s]."""
        return self._airspeed.speed

    def advance(self, body: FloatingBody, flow: Vector, propellers: Propellers) -> None:
        """Measure for one step.

        Args:
            body: The true motion.
            flow: Velocity of the air [m/s].
            propellers: Their thrust is known to the estimates.
        """
        x, y, _ = body.position
        angles = roll_pitch_yaw(*body.attitude)
        self.vertical.predict(propellers.up, STEP)
        if self._steps % STEPS_PER_ECHO == 0:
            self._sense_height(body.position, math.hypot(angles[0], angles[1]))
        self._steps += 1
        self.readings = self._read(body, angles, flow)
        compass = self._compass.measure(x, y, angles[2])
        self._headings.advance(self.readings.rates[2], compass, STEP)
        self._airspeed.advance(propellers.ahead, self.readings.airspeed, STEP)

    def _sense_height(self, position: Vector, tilt: float) -> None:
        """Use an echo, or without one the barometer as the last echoes corrected it."""
        x, y, z = position
        self._pressure_height = self._barometer.measure(z, _ECHO_TIME)
        self._altitude = self._altimeter.measure(self._surroundings, x, y, z, tilt)
        seen = self.vertical
        height = self._echoes.height(self._altitude, seen.height)
        if math.isnan(height):
            by_pressure = self._pressure_height - self._pressure_offset
            seen.correct(by_pressure, _ECHO_TIME, _BAROMETER_TRUST)
            return
        seen.correct(height, _ECHO_TIME)
        error = self._pressure_height - seen.height - self._pressure_offset
        self._pressure_offset += _BAROMETER_SHARE * error

    def _read(self, body: FloatingBody, angles: Vector, flow: Vector) -> BlimpReadings:
        roll, pitch = self._tilt.measure(angles[0], angles[1])
        u, _, _, p, q, r = body.velocity
        return BlimpReadings(
            altitude=self._altitude,
            height=self.vertical.height,
            climb=self.vertical.climb,
            barometer=self._pressure_height,
            airspeed=self._anemometer.measure(u - into_body(body.attitude, flow)[0]),
            roll=roll,
            pitch=pitch,
            heading=self._headings.heading,
            rates=self._gyro.measure(p, q, r),
        )
