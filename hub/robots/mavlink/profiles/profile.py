"""The table of one kind of vehicle.

Velocities of Rune are ENU and FLU: x ahead, y left, z up, counter-clockwise. Those of MAVLink are
NED and FRD: x ahead, y right, z down, clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

from hub.robots.left_alone import LeftAlone
from hub.values import dataclass

Message: TypeAlias = tuple[str, Mapping[str, Any]]
"""Name and fields of a message to the vehicle; the vehicle's number is added."""
Parameters: TypeAlias = Mapping[str, float]
"""Parameters of the vehicle that were read, by name."""

NEVER: Final = math.inf
"""The vehicle does not stop by itself [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setpoint:
    """A velocity in `base_link`.

    Attributes:
        ahead: [m/s].
        left: [m/s].
        up: [m/s].
        turn: Counter-clockwise [rad/s].
    """

    ahead: float = 0.0
    left: float = 0.0
    up: float = 0.0
    turn: float = 0.0

    @property
    def neutral(self) -> bool:
        """Whether nothing moves."""
        return not (self.ahead or self.left or self.up or self.turn)


NEUTRAL: Final = Setpoint()


@dataclass(frozen=True, slots=True, kw_only=True)
class WantedParameter:
    """A parameter that decides how the vehicle stops.

    Attributes:
        name: Its name.
        allowed: The safe values; the first is the one to set.
        why: What can happen with another value.
    """

    name: str
    allowed: tuple[float, ...]
    why: str

    def safe(self, value: float) -> bool:
        """Whether a value of the vehicle, a 32-bit float, is safe."""
        return any(math.isclose(value, each, rel_tol=1e-4, abs_tol=1e-6) for each in self.allowed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Braking:
    """How a vehicle comes to rest after its motors get zero: delay and time per speed.

    Attributes:
        delay: Until it slows down [s].
        per_speed: Further time at a speed [s per m/s].
        least: Further time at the least [s].
    """

    delay: float
    per_speed: float
    least: float = 0.0

    def time(self, speed: float) -> float:
        """Time until it stands, from a speed [m/s]."""
        return self.delay + max(self.least, self.per_speed * speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VehicleProfile:
    """The rules of one kind of vehicle.

    Attributes:
        name: "rover", "boat", "sub", "blimp", "copter".
        autopilot: "ArduPilot" or "PX4".
        verified: Whether its rules were compared with recordings of such a vehicle.
        types: The MAV_TYPE numbers of such vehicles.
        modes: The names of its modes, by number.
        drives: The modes that follow velocities, the best first.
        holds: The mode in which it stays where it is; None: it has none.
        offered: The modes that an operator may ask for; others can leave the vehicle unable to arm.
        alone: The mode of each action without an operator.
        rates: The messages that it is asked to send [Hz].
        wanted: The parameters that make it safe.
        reads: Further parameters that the driver needs.
        frees: The degrees of freedom: "ahead", "left", "up", "turn".
        setpoint: The messages of a velocity.
        stops: Times to stand from a speed: after a zero, and after all is silent [s]. Arguments
            are parameters, the speed [m/s], and whether it has a radio receiver.
    """

    name: str
    autopilot: str
    verified: bool
    types: frozenset[int]
    modes: Mapping[int, str]
    drives: tuple[int, ...]
    holds: int | None
    offered: tuple[int, ...]
    alone: Mapping[LeftAlone, int]
    rates: Mapping[str, float]
    wanted: tuple[WantedParameter, ...]
    reads: tuple[str, ...]
    frees: tuple[str, ...]
    setpoint: Callable[[Setpoint, Parameters, float], tuple[Message, ...]]
    stops: Callable[[Parameters, float, bool], tuple[float, float]]

    def mode_name(self, number: int) -> str:
        """The name of a mode."""
        return self.modes.get(number, f"mode {number}")

    def mode_number(self, name: str) -> int | None:
        """The number of a mode that is offered; None: there is none of that name."""
        return next((each for each in self.offered if self.modes[each] == name), None)


def stick(share: float, most: float = 1000.0) -> int:
    """A stick's deflection for a share of its travel, -1 to 1."""
    return round(most * max(-1.0, min(1.0, share)))


STREAMS: Final[Mapping[str, float]] = {
    "ATTITUDE": 20.0,
    "LOCAL_POSITION_NED": 20.0,
    "GLOBAL_POSITION_INT": 5.0,
    "VFR_HUD": 5.0,
    "SYS_STATUS": 2.0,
    "BATTERY_STATUS": 1.0,
    "EKF_STATUS_REPORT": 2.0,
    "GPS_RAW_INT": 1.0,
    "SCALED_PRESSURE2": 2.0,
    "DISTANCE_SENSOR": 10.0,
    "RC_CHANNELS": 2.0,
}
"""Rates of telemetry [Hz]. Above 80 % of the autopilot's loop it refuses them."""
STATION: Final = 255
"""The number of a ground station, as vehicles expect it."""
STATION_WANTED: Final = WantedParameter(
    name="MAV_GCS_SYSID",
    allowed=(float(STATION),),
    why="the vehicle obeys sticks of another ground station only, and ignores ours in silence",
)
