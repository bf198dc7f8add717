"""The table of one kind of vehicle.

Velocities of Rune are ENU and FLU: x ahead, y left, z up, counter-clockwise. Those of MAVLink are
NED and FRD: x ahead, y right, z down, clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol, TypeAlias

from hub.robots.left_alone import LeftAlone
from hub.values import dataclass

Message: TypeAlias = tuple[str, Mapping[str, Any]]
"""Name and fields of a message to the vehicle; the vehicle's number is added."""
Parameters: TypeAlias = Mapping[str, float]
"""Parameters of the vehicle that were read, by name."""

NEVER: Final = math.inf
"""The vehicle does not stop by itself [s]."""

_CUSTOM_MODE: Final = 1.0
"""MAV_MODE_FLAG_CUSTOM_MODE_ENABLED."""
OLDER_NAMES: Final[Mapping[str, str]] = {"SYSID_MYGCS": "MAV_GCS_SYSID"}
"""Present names of parameters, by their names in older firmware."""


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


SetpointModel: TypeAlias = Callable[[Setpoint, Parameters, float], tuple[Message, ...]]
"""From a velocity, the vehicle's parameters and the gain of its sticks to messages."""


class StopModel(Protocol):
    """The times to stand of one kind of vehicle."""

    def __call__(
        self, parameters: Parameters, speed: float, /, *, receiver: bool
    ) -> tuple[float, float]:
        """Times from a speed: after a zero, and after all is silent [s]; NaN: not known.

        Args:
            parameters: The vehicle's parameters.
            speed: [m/s].
            receiver: Whether it has a radio receiver.
        """


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VehicleProfile:
    """The rules of one kind of vehicle.

    A parameter that `scales` was not read: the setpoint leaves out the freedoms that need it.

    Attributes:
        name: "rover", "boat", "sub", "blimp", "copter".
        autopilot: "ArduPilot" or "PX4".
        verified: Whether its rules were compared with recordings of such a vehicle.
        types: The MAV_TYPE numbers of such vehicles.
        modes: The names of its modes, by number.
        drives: The modes that follow velocities, the best first.
        need_place: The modes that it refuses, or in which it ignores velocities, without a place.
        flies: Whether it follows velocities in the air only, where another has brought it.
        holds: The mode in which it stays where it is; None: it has none.
        offered: The modes that an operator may ask for; others can leave the vehicle unable to arm.
        alone: The mode of each action without an operator.
        rates: The messages that it is asked to send [Hz].
        wanted: The parameters that make it safe.
        scales: Parameters without which velocities cannot be made.
        reads: Further parameters that the driver uses.
        later: Parameters of its lights, which are read last.
        bytewise: Whether whole numbers come as the bytes of a 32-bit float.
        main_modes: Whether a mode's number is made of a main and a sub mode, as PX4 does.
        frees: The degrees of freedom: "ahead", "left", "up", "turn".
        setpoint: The messages of a velocity.
        open_loop: The modes in which speeds ahead and sideways are not controlled, and the
            messages of a velocity there; None: there are none.
        stops: Its times to stand.
        stops_by: The parameters that decide them, besides those that make it safe.
        coasts: Whether it moves on for long in the mode in which it stays: it brakes before.
    """

    name: str
    autopilot: str
    verified: bool
    types: frozenset[int]
    modes: Mapping[int, str]
    drives: tuple[int, ...]
    need_place: frozenset[int] = frozenset()
    flies: bool = False
    holds: int | None
    offered: tuple[int, ...]
    alone: Mapping[LeftAlone, int]
    rates: Mapping[str, float]
    wanted: tuple[WantedParameter, ...]
    scales: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    later: tuple[str, ...] = ()
    bytewise: bool = False
    main_modes: bool = False
    frees: tuple[str, ...]
    setpoint: SetpointModel
    open_loop: tuple[frozenset[int], SetpointModel] | None = None
    stops: StopModel
    stops_by: tuple[str, ...] = ()
    coasts: Callable[[Parameters], bool] = lambda _: False

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of all parameters that are read."""
        return (*(each.name for each in self.wanted), *self.scales, *self.reads)

    def unread(self, parameters: Parameters) -> tuple[str, ...]:
        """The names that decide how it stops, and were not read."""
        decisive = (*(each.name for each in self.wanted), *self.stops_by)
        return tuple(name for name in decisive if name not in parameters)

    def velocity(
        self, mode: int, wanted: Setpoint, parameters: Parameters, gain: float
    ) -> tuple[Message, ...]:
        """The messages of a velocity in a mode.

        Args:
            mode: The vehicle's mode.
            wanted: The velocity.
            parameters: The vehicle's parameters.
            gain: Share of its sticks' effect; NaN: not known.
        """
        if self.open_loop is not None and mode in self.open_loop[0]:
            return self.open_loop[1](wanted, parameters, gain)
        return self.setpoint(wanted, parameters, gain)

    def drives_with(self, *, place: bool) -> tuple[int, ...]:
        """The modes that follow velocities now.

        Args:
            place: Whether the vehicle knows its place.
        """
        kept = tuple(each for each in self.drives if place or each not in self.need_place)
        return kept or self.drives

    def mode_parameters(self, number: int) -> tuple[float, ...]:
        """The parameters of MAV_CMD_DO_SET_MODE for a mode."""
        if self.main_modes:
            return _CUSTOM_MODE, float(number >> 16 & 0xFF), float(number >> 24)
        return _CUSTOM_MODE, float(number)

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
    "HEARTBEAT": 4.0,
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
"""Rates of telemetry [Hz]. Above 80 % of the autopilot's loop it refuses them.

A vehicle sends one heartbeat per second by itself: where the link loses 30 %, two in a row are lost
every 11 s.
"""
STATION: Final = 255
"""The number of a ground station, as vehicles expect it."""
STATION_WANTED: Final = WantedParameter(
    name="MAV_GCS_SYSID",
    allowed=(float(STATION),),
    why="the vehicle obeys sticks of another ground station only, and ignores ours in silence",
)
