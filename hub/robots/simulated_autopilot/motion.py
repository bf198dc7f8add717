"""How a simulated vehicle follows what its autopilot demands; pure.

The responses are fitted to recorded sessions of ArduPilot's own simulator, which the tests replay,
and to stop times that were measured on it. NED and FRD: x ahead, y right, z down, clockwise.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from typing import Final, Protocol

from hub.values import dataclass


class DemandKind(enum.Enum):
    """How a vehicle follows a demand.

    Attributes:
        OFF: Its motors are off.
        VELOCITY: It follows velocities.
        BRAKE: It stands still, by its brakes.
        THRUST: Ahead and right are shares of the thrust; down and turn are velocities.
        OPEN: All are shares of the thrust.
        PLACE: It moves the place that it holds.
        RISE: It comes up; ahead and right are shares of the thrust.
    """

    OFF = "off"
    VELOCITY = "velocity"
    BRAKE = "brake"
    THRUST = "thrust"
    OPEN = "open"
    PLACE = "place"
    RISE = "rise"


@dataclass(frozen=True, slots=True, kw_only=True)
class Demand:
    """What the autopilot demands of its motors.

    Attributes:
        kind: How it is followed.
        ahead: [m/s], or a share of the thrust.
        right: [m/s], or a share.
        down: [m/s], or a share.
        turn: Clockwise [rad/s], or a share.
    """

    kind: DemandKind
    ahead: float = 0.0
    right: float = 0.0
    down: float = 0.0
    turn: float = 0.0


@dataclass(slots=True, kw_only=True)
class SimulatedState:
    """Place and motion of a vehicle; NED, from its start.

    Attributes:
        north: [m]
        east: [m]
        down: [m]; of a Sub, its depth.
        roll: [rad]
        pitch: [rad]
        yaw: Clockwise from north [rad].
        ahead: [m/s]
        right: [m/s]
        sinking: Downwards [m/s].
        turn: Clockwise [rad/s].
        charge: Of the battery, 0 to 1.
    """

    north: float = 0.0
    east: float = 0.0
    down: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    ahead: float = 0.0
    right: float = 0.0
    sinking: float = 0.0
    turn: float = 0.0
    charge: float = 1.0

    @property
    def ground(self) -> tuple[float, float]:
        """Velocity to the north and to the east [m/s]."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return self.ahead * cos - self.right * sin, self.ahead * sin + self.right * cos


class VehicleMotion(Protocol):
    """Moves a vehicle."""

    state: SimulatedState

    def step(self, demand: Demand, seconds: float) -> None:
        """Move for a time [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisResponse:
    """How one velocity follows its demand.

    Attributes:
        delay: Until anything happens [s].
        gain: Velocity per demand.
        late: Share of the velocity that comes only in the long run.
        creep: Time constant of that share [s].
        ramp: Largest acceleration when it speeds up [m/s^2, rad/s^2].
        braking: The same when it slows down.
        rise: Time constant when it speeds up [s].
        fall: The same when it slows down [s].
        push: Acceleration of the full thrust [m/s^2]; 0: the demand is a velocity.
        drag: Quadratic drag [1/m]; where the demand is a velocity, it slows the vehicle.
        brake: Deceleration beside the drag [m/s^2].
    """

    delay: float = 0.0
    gain: float = 1.0
    late: float = 0.0
    creep: float = 1.0
    ramp: float = math.inf
    braking: float = math.inf
    rise: float = 0.1
    fall: float = 0.1
    push: float = 0.0
    drag: float = 0.0
    brake: float = 0.0


class AxisFollower:
    """One velocity.

    Attributes:
        velocity: The present one [m/s or rad/s].
    """

    def __init__(self) -> None:
        self.velocity = 0.0
        self._response: AxisResponse | None = None
        self._demands: list[tuple[float, float]] = []
        self._demand = self._ramped = 0.0
        self._time = self._since = 0.0

    def step(self, response: AxisResponse, demand: float, seconds: float) -> None:
        """Follow a demand for a time [s]."""
        demand = max(-_LARGEST, min(_LARGEST, demand)) if math.isfinite(demand) else 0.0
        self._time += seconds
        if response is not self._response:
            if self._response is not None and bool(response.push) != bool(self._response.push):
                self._demand = 0.0
            self._response, self._ramped = response, self.velocity
            self._demands = [(self._time + response.delay, demand)]
        elif demand != (self._demands[-1][1] if self._demands else self._demand):
            self._demands.append((self._time + response.delay, demand))
        while self._demands and self._demands[0][0] <= self._time:
            self._since, self._demand = self._demands.pop(0)
        drag = response.drag * self.velocity**2
        if response.push:
            thrust = response.push * self._demand
            self.velocity += (thrust - math.copysign(drag, self.velocity)) * seconds
            return
        late = response.late * math.exp((self._since - self._time) / response.creep)
        goal = self._demand * response.gain * (1.0 - late)
        speeds_up = abs(goal) > abs(self.velocity)
        if response.drag and not speeds_up:
            most = min(response.braking, drag + response.brake) * seconds
            self.velocity += max(-most, min(most, goal - self.velocity))
            self._ramped = self.velocity
            return
        most = (response.ramp if speeds_up else response.braking) * seconds
        self._ramped += max(-most, min(most, goal - self._ramped))
        constant = response.rise if speeds_up else response.fall
        self.velocity += (self._ramped - self.velocity) * -math.expm1(-seconds / constant)


_LARGEST: Final = 50.0
"""Largest demand: parameters may say anything [m/s, rad/s]."""
_AXES: Final = ("ahead", "right", "down", "turn")
_STILL: Final = AxisResponse()
_ROVER_TURN: Final = AxisResponse(ramp=2.5, braking=2.3, rise=0.05, fall=0.05)
_SUB_TURN: Final = AxisResponse(delay=0.05, gain=1.05, rise=0.35, fall=0.31)
_SUB_CLIMB: Final = AxisResponse(delay=0.1, gain=1.05, rise=0.35, fall=0.42)
_SUB_DRAG: Final = 4.7
"""Of the recorded Sub as it coasts [1/m]; all its horizontal motion has it."""
_SUB_THRUST: Final = AxisResponse(delay=0.04, push=20.3, drag=_SUB_DRAG)
_SUB_PLACE: Final = (
    AxisResponse(delay=0.1, gain=1.02, rise=0.75, drag=_SUB_DRAG, brake=0.035),
    AxisResponse(delay=0.1, gain=1.02, rise=0.75, drag=_SUB_DRAG, brake=0.015),
)
_SUB_GUIDED: Final = (
    AxisResponse(delay=0.05, rise=0.13, late=0.22, creep=14.5, drag=_SUB_DRAG),
    AxisResponse(delay=0.1, rise=0.13, late=0.49, creep=23.0, drag=_SUB_DRAG, brake=0.035),
    AxisResponse(delay=0.1, rise=0.35, fall=0.37),
    AxisResponse(delay=0.05, rise=0.35, fall=0.35),
)
"""Its controller reaches the speed ahead and aside late; it brakes by drag."""
_SUB_SLOW_CLIMB: Final = AxisResponse(delay=0.3, rise=0.4, fall=0.4)
_SUB_COASTS: Final = AxisResponse(drag=_SUB_DRAG)
_BLIMP_FLAT: Final = AxisResponse(
    delay=0.1, gain=1.12, ramp=0.115, rise=0.1, braking=0.13, drag=10.8
)
_BLIMP_CLIMB: Final = AxisResponse(delay=0.2, gain=0.92, rise=0.5, fall=0.62)
_BLIMP_TURN: Final = AxisResponse(delay=0.15, gain=0.87, rise=0.3, fall=0.19)
_BLIMP_PLACE: Final = AxisResponse(delay=0.5, ramp=0.06, braking=0.075, rise=0.3, fall=0.2)
_BLIMP_COASTS: Final = AxisResponse(rise=15.0, fall=15.0)
_Axes = tuple[AxisResponse, AxisResponse, AxisResponse, AxisResponse]
RESPONSES: Final[Mapping[str, Mapping[DemandKind, _Axes]]] = {
    "rover": {
        DemandKind.VELOCITY: (
            AxisResponse(delay=0.03, ramp=1.0, braking=1.0, rise=0.2, fall=0.2),
            _STILL,
            _STILL,
            _ROVER_TURN,
        ),
        DemandKind.BRAKE: (AxisResponse(delay=0.1, fall=0.315), _STILL, _STILL, _ROVER_TURN),
        DemandKind.OFF: (AxisResponse(delay=0.04, fall=0.287), _STILL, _STILL, _ROVER_TURN),
    },
    "sub": {
        DemandKind.VELOCITY: _SUB_GUIDED,
        DemandKind.PLACE: (*_SUB_PLACE, _SUB_CLIMB, _SUB_TURN),
        DemandKind.THRUST: (_SUB_THRUST, _SUB_THRUST, _SUB_CLIMB, _SUB_TURN),
        DemandKind.OPEN: (_SUB_THRUST, _SUB_THRUST, _SUB_THRUST, _SUB_TURN),
        DemandKind.RISE: (_SUB_THRUST, _SUB_THRUST, _SUB_SLOW_CLIMB, _SUB_TURN),
        DemandKind.OFF: (_SUB_COASTS, _SUB_COASTS, _SUB_SLOW_CLIMB, _SUB_TURN),
    },
    "blimp": {
        DemandKind.VELOCITY: (_BLIMP_FLAT, _BLIMP_FLAT, _BLIMP_CLIMB, _BLIMP_TURN),
        DemandKind.PLACE: (_BLIMP_PLACE, _BLIMP_PLACE, _BLIMP_CLIMB, _BLIMP_TURN),
        DemandKind.OPEN: (_BLIMP_COASTS,) * 4,
        DemandKind.OFF: (_BLIMP_COASTS,) * 4,
    },
}


class FittedMotion:
    """Follows demands as the recorded vehicles did."""

    def __init__(self, kind: str, *, depth: float = 0.0) -> None:
        """Stand at the start, with the nose to the north.

        Args:
            kind: "rover", "sub" or "blimp".
            depth: Of the start [m].
        """
        self.state = SimulatedState(down=depth)
        self._kind = kind
        self._axes = tuple(AxisFollower() for _ in _AXES)

    def step(self, demand: Demand, seconds: float) -> None:
        """Move for a time [s]."""
        state = self.state
        responses = RESPONSES[self._kind][demand.kind]
        for axis, response, name in zip(self._axes, responses, _AXES, strict=True):
            axis.step(response, getattr(demand, name), seconds)
        ahead, right, down, turn = self._axes
        if self._kind == "sub" and state.down <= 0.0:
            down.velocity = max(0.0, down.velocity)
        if self._kind == "blimp" and state.down >= 0.0:
            down.velocity = min(0.0, down.velocity)
        state.ahead, state.right = ahead.velocity, right.velocity
        state.sinking, state.turn = down.velocity, turn.velocity
        state.yaw = math.remainder(state.yaw + state.turn * seconds, math.tau)
        north, east = state.ground
        state.north += north * seconds
        state.east += east * seconds
        state.down += state.sinking * seconds
