"""Messages of the control lease: one operator commands a robot at a time."""

from __future__ import annotations

import enum
from dataclasses import field

import numpy as np

from hub.gcm import autonomy, autopilot, navigation, vehicle, vision
from hub.gcm.autonomy import DrivingMode
from hub.gcm.fields import Count, Flag, Name, Number, Numbers, Seconds, Sentence
from hub.gcm.geometry import TwistStamped
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.values import dataclass

HEARTBEAT_HZ = 5.0
"""Rate of a console's heartbeats [Hz]."""
WARNED_S = 1.0
"""Silence of the owner's console after which the state shows it [s]."""
LOST_S = 3.0
"""Silence of the owner's console after which it loses control [s]."""
ANSWER_S = 10.0
"""Time of the owner to answer a request for control [s]."""

DRIVING: frozenset[str] = frozenset(
    definition.name
    for definition in (
        navigation.VELOCITY_COMMAND,
        navigation.GOAL_COMMAND,
        navigation.TURN_COMMAND,
        autonomy.AUTONOMY_COMMAND,
    )
)
"""Messages that move the robot; one to a free robot takes control."""
RESTRICTED: frozenset[str] = DRIVING | {
    definition.name
    for definition in (
        navigation.ASSISTANCE_COMMAND,
        navigation.LANDMARK_CORRECTION,
        vision.CAMERA_COMMAND,
        vision.NIGHT_COMMAND,
        vehicle.VEHICLE_COMMAND,
        autopilot.MAVLINK_REQUEST,
    )
}
"""Messages of the owner alone, while there is one; `GCM_Stop` is not among them."""


def is_restricted(message: str, value: object) -> bool:
    """Whether only the owner may send this; zero speed and disarming are for all."""
    if isinstance(value, TwistStamped):
        return message in RESTRICTED and not value.neutral
    if isinstance(value, vehicle.VehicleCommand):
        return value.order is not vehicle.VehicleOrder.DISARM
    return message in RESTRICTED


def is_driving(message: str, value: object) -> bool:
    """Whether this moves the robot, so that it takes control of a free one."""
    if isinstance(value, vehicle.VehicleCommand):
        return value.order not in (vehicle.VehicleOrder.DISARM, vehicle.VehicleOrder.LIGHT)
    return message in DRIVING and is_restricted(message, value)


class ControlAction(enum.IntEnum):
    """The order in a `ControlRequest`.

    Attributes:
        TAKE: Take control of a free robot.
        RELEASE: Give up the sender's control.
        ASK: Ask the owner for control.
        GRANT: From the owner: hand control to the first request.
        DENY: From the owner: refuse the first request.
        TAKE_OVER: Take control from any owner; needs the role `supervise`.
        FREE: End any control; needs the role `supervise`.
    """

    TAKE = 0
    RELEASE = 1
    ASK = 2
    GRANT = 3
    DENY = 4
    TAKE_OVER = 5
    FREE = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlRequest:
    """An order about control; answered by `CommonResult`.

    Attributes:
        action: The order.
        operator: Operator of the console, for others to read.
    """

    action: ControlAction = ControlAction.TAKE
    operator: Sentence = ""


CONTROL_REQUEST = MessageDefinition(
    name="GCM_Control_Request",
    type=ControlRequest,
    plane=Plane.COMMAND,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsoleHeartbeat:
    """The heartbeat of a console.

    Attributes:
        holds: 1: it has control and keeps it; else 0.
    """

    holds: Flag = 0


CONSOLE_HEARTBEAT = MessageDefinition(
    name="GCM_Console_Heartbeat",
    type=ConsoleHeartbeat,
    plane=Plane.COMMAND,
    rate_hz=HEARTBEAT_HZ,
    lifespan_s=1.0,
)


PLAYED = "RECORDING"
"""The owner of control where a recording is played: the sender of its `ControlState` itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlState:
    """The owner of control; sent at each change and once a second.

    Attributes:
        owner: Number at central of the owner, as in frame headers; 0: none, all commands count.
        owner_name: Its name at central.
        operator: Its operator.
        held_s: Time since it got control [s].
        silent_s: Time since its last heartbeat [s].
        asker: Number at central of the first console that asks for control; 0: none.
        asker_name: Its name at central.
        asker_operator: Its operator.
        left_s: Remaining time for the owner's answer [s]; 0: no request.
        waiting: Number of further requests.
        commander: Number of the sender that moves the robot now.
        commander_name: Its name, for people; empty: none.
        why: The reason for this state, for people.
        modules: Numbers of the robot's own modules, shape (n,); their commands always count.
    """

    owner: Number = 0
    owner_name: Name = ""
    operator: Name = ""
    held_s: Seconds = 0.0
    silent_s: Seconds = 0.0
    asker: Number = 0
    asker_name: Name = ""
    asker_operator: Name = ""
    left_s: Seconds = 0.0
    waiting: Count = 0
    commander: DrivingMode = DrivingMode.NOBODY
    commander_name: Name = ""
    why: Sentence = ""
    modules: Numbers = field(default_factory=lambda: np.zeros(0, np.uint32))


CONTROL_STATE = MessageDefinition(
    name="GCM_Control_State",
    type=ControlState,
    rate_hz=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlRefusal:
    """A module refused a command, because its sender has no control; at most one a second.

    Attributes:
        sender: Number at central of the command's sender.
        message: Name of the command.
        owner: Number at central of the owner of control.
        operator: Its operator.
        refused: Commands that the module has refused since its start.
    """

    sender: Number
    message: Name
    owner: Number
    operator: Name
    refused: Number


CONTROL_REFUSAL = MessageDefinition(
    name="GCM_Control_Refusal",
    type=ControlRefusal,
    keep=Keep.ALL,
)

MESSAGES = (CONTROL_REQUEST, CONSOLE_HEARTBEAT, CONTROL_STATE, CONTROL_REFUSAL)
