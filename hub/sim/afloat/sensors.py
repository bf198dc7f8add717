"""Sensors of floating robots with their faults; each draws its noise from a seed of its own.

Figures without a source are our assumptions. The same seed and the same calls give the same values
to the last bit.
"""

from __future__ import annotations

import math

import numpy as np

from hub.pose import wrapped
from hub.sim.afloat.surroundings import Surroundings


class Altimeter:
    """An ultrasonic altimeter that looks down, 10 Hz.

    It has no echo beyond its range, when it tilts, and over fabric, which swallows sound. Over a
    table it measures to the table.
    """

    BELOW = 0.3
    """Transducer below the middle of the blimp [m]."""
    NEAREST = 0.2
    FARTHEST = 6.0
    NOISE = 0.01
    """Standard deviation [m]."""
    MOST_TILT = math.radians(25.0)
    """It has no echo beyond this tilt [rad]."""
    HALF_BEAM = math.radians(10.0)

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)

    def measure(
        self, surroundings: Surroundings, x: float, y: float, z: float, tilt: float
    ) -> float:
        """Distance from the blimp's middle to the ground below [m]; NaN without an echo."""
        noise = self.NOISE * float(self._random.standard_normal())
        if tilt > self.MOST_TILT:
            return math.nan
        below = surroundings.below(x, y, z - self.BELOW, self.HALF_BEAM)
        if below.soft or not self.NEAREST <= below.distance <= self.FARTHEST:
            return math.nan
        return round(below.distance + noise, 2) + self.BELOW


class Barometer:
    """A barometer as altimeter: heights with noise and a drift of a third of a metre in minutes."""

    NOISE = 0.05
    """Standard deviation [m]."""
    DRIFT = 0.15
    """Standard deviation of the drift [m]."""
    DRIFT_TIME = 60.0
    """Time over which the drift changes [s]."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)
        self._drift = 0.0

    def measure(self, z: float, seconds: float) -> float:
        """Height [m], some time [s] after the measurement before."""
        drift, noise = map(float, self._random.standard_normal(2))
        kept = math.exp(-seconds / self.DRIFT_TIME)
        self._drift = kept * self._drift + math.sqrt(1.0 - kept * kept) * self.DRIFT * drift
        return z + self._drift + self.NOISE * noise


class Compass:
    """A magnetic compass indoors: steel bends the field, so the error depends on the place.

    The error is a sum of two waves over the floor with seeded directions and phases.
    """

    WAVELENGTHS = (3.0, 7.0)
    """Of the two waves [m]."""
    NOISE = math.radians(1.0)
    """Standard deviation [rad]."""

    def __init__(self, seed: np.random.SeedSequence, *, worst: float) -> None:
        """Draw the errors of a place.

        Args:
            seed: Of the errors.
            worst: Largest error without noise [rad].
        """
        self._random = np.random.default_rng(seed)
        directions = self._random.uniform(0.0, math.tau, 2)
        phases = self._random.uniform(0.0, math.tau, 2).tolist()
        self._waves = tuple(
            (math.tau / length * math.cos(way), math.tau / length * math.sin(way), phase)
            for length, way, phase in zip(
                self.WAVELENGTHS, directions.tolist(), phases, strict=True
            )
        )
        self._share = worst / len(self._waves)

    def error(self, x: float, y: float) -> float:
        """Error at a place without noise [rad]."""
        return self._share * sum(math.sin(kx * x + ky * y + at) for kx, ky, at in self._waves)

    def measure(self, x: float, y: float, yaw: float) -> float:
        """Heading [rad]."""
        noise = self.NOISE * self._random.standard_normal()
        return wrapped(yaw + self.error(x, y) + noise)


class Gyro:
    """Turn rates about three axes, with a constant error each."""

    BIAS = 0.002
    """Standard deviation of the constant errors [rad/s]."""
    NOISE = 0.005
    """Standard deviation [rad/s]."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)
        self._bias = tuple((self.BIAS * self._random.standard_normal(3)).tolist())

    def measure(self, p: float, q: float, r: float) -> tuple[float, float, float]:
        """Rates about x, y and z [rad/s]."""
        a, b, c = self._random.standard_normal(3).tolist()
        bias, noise = self._bias, self.NOISE
        return p + bias[0] + noise * a, q + bias[1] + noise * b, r + bias[2] + noise * c


class TiltSensor:
    """Roll and pitch from accelerometer and gyro, with a constant error each."""

    BIAS = math.radians(0.5)
    """Standard deviation of the constant errors [rad]."""
    NOISE = math.radians(0.1)
    """Standard deviation [rad]."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)
        self._bias = tuple((self.BIAS * self._random.standard_normal(2)).tolist())

    def measure(self, roll: float, pitch: float) -> tuple[float, float]:
        """Roll and pitch [rad]."""
        a, b = self._random.standard_normal(2).tolist()
        return roll + self._bias[0] + self.NOISE * a, pitch + self._bias[1] + self.NOISE * b


class Anemometer:
    """A small free propeller that measures the forward speed through the air.

    The Blimp2b carries one (Zufferey et al. 2006). It stands still in slow air.
    """

    LEAST = 0.05
    """Slower air does not turn it [m/s]."""
    NOISE = 0.02
    """Standard deviation [m/s]."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)

    def measure(self, airspeed: float) -> float:
        """Forward speed through the air [m/s]."""
        noise = self.NOISE * self._random.standard_normal()
        return 0.0 if abs(airspeed) < self.LEAST else airspeed + noise


class PressureSensor:
    """Depth from the water's pressure, after the Bar30: 2 mm steps, noise of some millimetres."""

    RESOLUTION = 0.002
    """[m], data sheet."""
    NOISE = 0.0025
    """Standard deviation [m]: 5 mm were measured at rest as the largest error."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)

    def measure(self, depth: float) -> float:
        """Depth [m]."""
        noisy = depth + self.NOISE * self._random.standard_normal()
        return round(noisy / self.RESOLUTION) * self.RESOLUTION


class EchoSounder:
    """A sonar that looks down, after the Ping1D: beam of 25 degrees, 0.3 to 100 m, 10 Hz.

    The speed of sound in the water is known to 1.5 %: all distances have the same error.
    """

    BELOW = 0.1
    """Transducer below the middle of the robot [m]."""
    NEAREST = 0.3
    FARTHEST = 100.0
    HALF_BEAM = math.radians(12.5)
    RESOLUTION = 0.005
    """Standard deviation as a share of the distance, data sheet."""
    SOUND_SPEED_ERROR = 0.015
    """Largest error as a share of the distance."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)
        self._scale = 1.0 + self.SOUND_SPEED_ERROR * float(self._random.uniform(-1.0, 1.0))

    def measure(self, surroundings: Surroundings, x: float, y: float, z: float) -> float:
        """Distance from the robot's middle to the ground below [m]; NaN without an echo."""
        noise = self.RESOLUTION * self._random.standard_normal()
        distance = surroundings.below(x, y, z - self.BELOW, self.HALF_BEAM).distance
        if not self.NEAREST <= distance <= self.FARTHEST:
            return math.nan
        return distance * self._scale * (1.0 + noise) + self.BELOW


class DopplerLog:
    """A sonar with four beams that measures the speed over the ground, after the DVL A50, 7 Hz.

    Without the ground in reach of its beams it measures nothing.
    """

    BELOW = 0.1
    """Transducers below the middle of the robot [m]."""
    HALF_BEAM = math.radians(22.5)
    """Of the four beams together [rad], data sheet."""
    NEAREST = 0.05
    """Least distance of the ground [m], data sheet."""
    FARTHEST = 50.0
    """Largest distance of the ground [m], data sheet."""
    MOST_TILT = math.radians(25.0)
    """Beyond this tilt a beam loses the ground [rad]."""
    NOISE = 0.005
    """Standard deviation [m/s]."""
    SCALE_ERROR = 0.01
    """Largest error as a share of the speed."""

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)
        self._scale = 1.0 + self.SCALE_ERROR * float(self._random.uniform(-1.0, 1.0))

    def measure(
        self, distance: float, tilt: float, surge: float, sway: float
    ) -> tuple[float, float]:
        """Speed ahead and to the left [m/s]; NaN without the ground.

        Args:
            distance: To the ground below [m].
            tilt: [rad]
            surge: True speed ahead [m/s].
            sway: True speed to the left [m/s].
        """
        a, b = self._random.standard_normal(2).tolist()
        if not self.NEAREST <= distance <= self.FARTHEST or tilt > self.MOST_TILT:
            return math.nan, math.nan
        return self._scale * surge + self.NOISE * a, self._scale * sway + self.NOISE * b
