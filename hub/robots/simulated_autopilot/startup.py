"""The start of a simulated autopilot: what it says and what it refuses when; pure.

Times are recorded ones, since the start of the process [s].
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from hub.values import dataclass

_INFO: Final = 6
_DEBUG: Final = 7
FAST: Final = 0.02
"""Share of the recorded times with a fast start: it knows its place after 0.9 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StartupTimes:
    """When a vehicle is ready for what [s].

    Attributes:
        heard: First heartbeat.
        ready: It takes modes and arms, if nothing else is wrong.
        initialised: The filter of its attitude runs.
        attitude: It knows its attitude.
        origin: It has an origin of its coordinates.
        place: It knows its place.
        refusals: What it says about arming, with the first and the last time.
        texts: What it says by itself: time, severity, text.
    """

    heard: float
    ready: float
    initialised: float
    attitude: float
    origin: float
    place: float
    refusals: tuple[tuple[str, float, float], ...]
    texts: tuple[tuple[float, int, str], ...]


def _pair(time: float, text: str) -> tuple[tuple[float, int, str], ...]:
    """The same text about both inertial units."""
    return tuple((time, _INFO, text.format(each)) for each in (0, 1))


_GPS: Final = "GPS 1: probing for u-blox at 230400 baud", "GPS 1: detected u-blox"
STARTUPS: Final[Mapping[str, StartupTimes]] = {
    "rover": StartupTimes(
        heard=1.0,
        ready=2.39,
        initialised=4.4,
        attitude=6.05,
        origin=19.89,
        place=41.93,
        refusals=(
            ("System not initialised", 0.0, 2.39),
            ("Accels inconsistent", 2.39, 13.3),
            ("Gyros inconsistent", 13.3, 23.6),
        ),
        texts=(
            (1.75, _INFO, "Barometer 1 calibration complete"),
            (1.75, _INFO, "Barometer 2 calibration complete"),
            (1.76, _INFO, "Beginning INS calibration. Do not move vehicle"),
            (2.39, _DEBUG, "INS: alloc 6144 bytes for ISB (free=524288)"),
            (2.39, _INFO, "ArduPilot Ready"),
            (2.39, _INFO, "AHRS: DCM active"),
            *_pair(4.4, "EKF3 IMU{} initialised"),
            *_pair(6.0, "EKF3 IMU{} tilt alignment complete"),
            *_pair(6.08, "EKF3 IMU{0} MAG0 initial yaw alignment complete"),
            (9.69, _INFO, _GPS[0]),
            (9.71, _INFO, _GPS[1]),
            *_pair(19.89, "EKF3 IMU{} origin set"),
            (41.93, _INFO, "EKF3 IMU0 is using GPS"),
            (41.93, _INFO, "AHRS: EKF3 active"),
            (42.11, _INFO, "EKF3 IMU1 is using GPS"),
        ),
    ),
    "sub": StartupTimes(
        heard=0.08,
        ready=1.78,
        initialised=3.78,
        attitude=5.4,
        origin=19.5,
        place=41.2,
        refusals=(("System not initialised", 0.0, 1.78),),
        texts=(
            (0.15, _INFO, "Calibrating barometer"),
            (1.77, _INFO, "Barometer 1 calibration complete"),
            (1.77, _INFO, "Barometer 2 calibration complete"),
            (1.78, _INFO, "ArduPilot Ready"),
            (1.78, _INFO, "AHRS: DCM active"),
            (1.78, _DEBUG, "RCInput: decoding UDP (Pulses)"),
            *_pair(3.78, "EKF3 IMU{} initialised"),
            (3.79, _INFO, "AHRS: EKF3 active"),
            *_pair(5.34, "EKF3 IMU{} tilt alignment complete"),
            *_pair(5.42, "EKF3 IMU{0} MAG0 initial yaw alignment complete"),
            (9.1, _INFO, _GPS[0]),
            (9.12, _INFO, _GPS[1]),
            *_pair(19.5, "EKF3 IMU{} origin set"),
            (41.15, _INFO, "EKF3 IMU0 is using GPS"),
            (41.35, _INFO, "EKF3 IMU1 is using GPS"),
        ),
    ),
    "blimp": StartupTimes(
        heard=1.0,
        ready=2.85,
        initialised=4.86,
        attitude=5.9,
        origin=20.2,
        place=42.3,
        refusals=(
            ("System not initialised", 0.0, 2.85),
            ("Need Alt Estimate", 2.85, 7.3),
            ("Accels inconsistent", 2.85, 13.3),
            ("Gyros inconsistent", 13.3, 23.6),
            ("EKF attitude is bad", 2.85, 7.3),
            ("AHRS: not using configured AHRS type", 2.85, 5.87),
        ),
        texts=(
            (2.32, _INFO, "Barometer 1 calibration complete"),
            (2.32, _INFO, "Barometer 2 calibration complete"),
            (2.85, _INFO, "ArduPilot Ready"),
            (2.85, _INFO, "AHRS: DCM active"),
            (2.85, _DEBUG, "RCInput: decoding UDP (Pulses)"),
            *_pair(4.09, "EKF2 IMU{0} MAG0 initial yaw alignment complete"),
            *_pair(4.86, "EKF3 IMU{} initialised"),
            (5.87, _INFO, "AHRS: EKF3 active"),
            *_pair(6.47, "EKF3 IMU{} tilt alignment complete"),
            *_pair(6.55, "EKF3 IMU{0} MAG0 initial yaw alignment complete"),
            *_pair(9.33, "EKF2 IMU{} tilt alignment complete"),
            (10.12, _INFO, _GPS[0]),
            (10.15, _INFO, _GPS[1]),
            *_pair(20.2, "EKF3 IMU{} origin set"),
            *_pair(20.2, "EKF2 IMU{} origin set"),
            *_pair(40.2, "EKF2 IMU{} is using GPS"),
            (42.3, _INFO, "EKF3 IMU0 is using GPS"),
            (42.5, _INFO, "EKF3 IMU1 is using GPS"),
        ),
    ),
}


class Startup:
    """One start of one vehicle; times since the start are as recorded, also with a fast one."""

    def __init__(self, kind: str, began: float, *, fast: bool) -> None:
        """Start now.

        Args:
            kind: "rover", "sub" or "blimp".
            began: Monotonic time [s].
            fast: Whether all takes a fiftieth of the time.
        """
        self.times = STARTUPS[kind]
        self.began = began
        self._share = FAST if fast else 1.0
        self._said = 0

    def age(self, now: float) -> float:
        """Time since the start, as recorded [s]."""
        return (now - self.began) / self._share

    def refusals(self, now: float) -> Iterator[str]:
        """Why it does not arm yet."""
        age = self.age(now)
        yield from (text for text, first, last in self.times.refusals if first <= age < last)

    def texts(self, now: float) -> Iterator[tuple[int, str]]:
        """Severity and text of what it says since the last call."""
        age, texts = self.age(now), self.times.texts
        while self._said < len(texts) and texts[self._said][0] <= age:
            yield texts[self._said][1:]
            self._said += 1
