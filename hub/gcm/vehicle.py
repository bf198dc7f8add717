"""Messages of what a vehicle does besides its motion: holds, arming, lights, joints, tether."""

from __future__ import annotations

import enum
import math
from typing import Annotated

from hub.gcm.body import MOST_PARTS, HoldKind
from hub.gcm.fields import LengthIfKnown, Name, Share, Stamp
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Counted
from hub.values import dataclass


class HoldPhase(enum.IntEnum):
    """What a hold does now.

    Attributes:
        OFF: Nothing: the robot drifts in this freedom.
        READY: It is on, and waits while the operator moves this freedom or the robot brakes.
        HOLDING: It holds its target.
        FAILING: It is on, and the robot is too far from the target.
    """

    OFF = 0
    READY = 1
    HOLDING = 2
    FAILING = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldState:
    """One hold now.

    Attributes:
        kind: What it keeps.
        phase: What it does.
        target: Height or depth [m], or heading in `odom` [rad], that it keeps; NaN: none.
        error: Measured value less the target [m or rad]; NaN: not known.
    """

    kind: HoldKind
    phase: HoldPhase = HoldPhase.OFF
    target: Annotated[float, Range(-1e6, 1e6, unit="m or rad", nan=True)] = math.nan
    error: Annotated[float, Range(-1e6, 1e6, unit="m or rad", nan=True)] = math.nan


class Arming(enum.IntEnum):
    """Whether the motors of the robot have power.

    Attributes:
        NONE: The body cannot be disarmed.
        DISARMED: They are off, and commands change nothing.
        ARMED: They follow commands.
    """

    NONE = 0
    DISARMED = 1
    ARMED = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class LightState:
    """One light now.

    Attributes:
        name: As in the description.
        brightness: 0 (off) to 1.
    """

    name: Name
    brightness: Annotated[Share, FLOAT32]


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleState:
    """What the vehicle does besides its motion.

    Attributes:
        stamp: Time of measurement [s since the epoch]; for records only.
        activity: What it does, in a word: "stands", "drives", "holds", "surfaces", "lands",
            "disarmed".
        arming: Whether its motors have power.
        holds: Its holds, in the order of the description.
        lights: The lights of its body; `GCM_CameraState` has those of cameras.
        tether_paid: Length of the tether that is out [m]; NaN: there is none.
        tether_length: Whole length of the tether [m]; NaN: there is none.
        tether_turns: Turns of the robot that twist the tether, counter-clockwise positive; NaN:
            not known.
    """

    stamp: Stamp = 0.0
    activity: Name = ""
    arming: Arming = Arming.NONE
    holds: Annotated[tuple[HoldState, ...], Counted("hold_count"), Most(len(HoldKind))] = ()
    lights: Annotated[tuple[LightState, ...], Counted("light_count"), Most(MOST_PARTS)] = ()
    tether_paid: LengthIfKnown = math.nan
    tether_length: LengthIfKnown = math.nan
    tether_turns: Annotated[float, Range(-1e6, 1e6, nan=True)] = math.nan


VEHICLE_STATE = MessageDefinition(name="GCM_Vehicle_State", type=VehicleState, rate_hz=2.0)
"""Sent at each change too, at most ten times per second."""


class VehicleOrder(enum.IntEnum):
    """What a `VehicleCommand` asks for.

    Attributes:
        HOLD: Switch a hold on; with a finite value, go there and hold that.
        RELEASE: Switch a hold off.
        ARM: Give the motors power; they wait for a neutral command.
        DISARM: Switch the motors off.
        LIGHT: Set the brightness of a light.
        JOINT: Turn a joint at a rate; without a fresh order it stops after 0.3 s.
        DRIVE: Ask an autopilot for the mode that follows velocities; they begin with a neutral one.
        MODE: Ask an autopilot for a mode by its name.
        STAY: Ask an autopilot for the mode in which it stays. Nothing that moves it is sent then,
            until it is asked for a mode that follows velocities.
    """

    HOLD = 0
    RELEASE = 1
    ARM = 2
    DISARM = 3
    LIGHT = 4
    JOINT = 5
    DRIVE = 6
    MODE = 7
    STAY = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleCommand:
    """An order that is no motion command.

    Each client that may command a robot may disarm it. The other orders need control of it.
    An order that is 1 s old, or whose age is not known, switches nothing on.

    Attributes:
        order: What to do.
        name: Name of the light, joint or mode; else empty.
        hold: Which hold, for `HOLD` and `RELEASE`.
        value: `HOLD`: height or depth [m], or heading in `odom` [rad]; NaN: the present one.
            `LIGHT`: brightness, 0 to 1. `JOINT`: turn rate [rad/s]. Else without meaning.
    """

    order: VehicleOrder = VehicleOrder.HOLD
    name: Name = ""
    hold: HoldKind = HoldKind.HEIGHT
    value: Annotated[float, Range(-1e6, 1e6, unit="m, rad or rad/s", nan=True)] = math.nan


VEHICLE_COMMAND = MessageDefinition(
    name="GCM_Vehicle_Command",
    type=VehicleCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
)
"""It has no lifespan: a late `DISARM` is obeyed. `too_late` says which orders are refused."""

LATE_S = 1.0
"""Age from which on an order is refused that switches something on [s]."""
_WHEN_LATE = frozenset({VehicleOrder.DISARM, VehicleOrder.RELEASE, VehicleOrder.JOINT})


def too_late(order: VehicleOrder, age: float) -> str:
    """Why an order is refused because of its age [s], in a sentence; empty: it is obeyed.

    The driver stops joints without fresh orders, so a late `JOINT` needs no rule here.
    """
    if age < LATE_S or order in _WHEN_LATE:
        return ""
    old = f"it is {age:.1f} s old" if math.isfinite(age) else "it is stamped ahead of the clock"
    return f"the order {order.name} is refused: {old}; the operator may see something else now"


MESSAGES = (VEHICLE_STATE, VEHICLE_COMMAND)
