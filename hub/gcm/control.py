"""Messages of the control lease: one operator commands a robot at a time, and all see who."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

import numpy as np

from hub.gcm import autonomy, navigation, vision
from hub.gcm.autonomy import DrivingMode
from hub.gcm.fields import Count, Flag, Name, Number, Numbers, Seconds, Sentence
from hub.ipc.definition import Keep, MessageDefinition, Plane

HEARTBEAT_HZ = 5.0
"""How often a console says that it lives [Hz]."""
WARNED_S = 1.0
"""Silence of the owner's console after which the others are told [s]."""
LOST_S = 3.0
"""Silence of the owner's console after which it has lost control [s]."""
ANSWER_S = 10.0
"""Time the owner has to answer who asks for control [s]."""

DRIVING: frozenset[str] = frozenset(
    definition.name
    for definition in (
        navigation.VELOCITY_COMMAND,
        navigation.GOAL_COMMAND,
        navigation.TURN_COMMAND,
        autonomy.AUTONOMY_COMMAND,
    )
)
"""Messages that move the robot: who sends one to a free robot means to have control."""
RESTRICTED: frozenset[str] = DRIVING | {
    definition.name
    for definition in (
        navigation.ASSISTANCE_COMMAND,
        navigation.LANDMARK_CORRECTION,
        vision.CAMERA_COMMAND,
        vision.NIGHT_COMMAND,
    )
}
"""Messages that only the owner sends while there is one; `GCM_Stop` is not among them."""


class ControlAction(enum.IntEnum):
    """What a `ControlRequest` asks for.

    Attributes:
        TAKE: Control of a robot that nobody commands.
        RELEASE: Give up one's own control.
        ASK: Control of a robot that somebody commands: its owner is asked.
        GRANT: Of the owner: hand it to who asks.
        DENY: Of the owner: keep it.
        TAKE_OVER: Control, whoever has it; needs the role `supervise`.
        FREE: Nobody is to have control; needs the role `supervise`.
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
    """Something about control is wanted; answered by `CommonResult`.

    Attributes:
        action: What.
        operator: Who sits at the console, for the others to read.
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
    """A console lives.

    Attributes:
        holds: 1 if it knows that it has control, and so keeps it; else 0.
    """

    holds: Flag = 0


CONSOLE_HEARTBEAT = MessageDefinition(
    name="GCM_Console_Heartbeat",
    type=ConsoleHeartbeat,
    plane=Plane.COMMAND,
    rate_hz=HEARTBEAT_HZ,
    lifespan_s=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlState:
    """Who has control; when it changes and once a second.

    Attributes:
        owner: Whose commands count: its number at central, as in frame headers; 0: anybody's.
        owner_name: Its name at central.
        operator: Who sits there.
        held_s: How long it has had control [s].
        silent_s: Time since its console was heard [s].
        asker: Who asks for control: its number at central; 0: nobody.
        asker_name: Its name at central.
        asker_operator: Who sits there.
        left_s: Time that the owner has left to answer [s]; 0 if nobody asks.
        waiting: How many more ask, and come to their turn later.
        commander: Who moves the robot now.
        commander_name: Who that is, for people; empty if nobody does.
        why: How control came to be as it is, for people.
        modules: Numbers of the robot's own modules, whose commands always count, shape (n,).
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
    """A module has not carried out a command, as its sender has no control; at most one a second.

    Attributes:
        sender: Whose command: its number at central.
        message: Name of the command.
        owner: Who has control: its number at central.
        operator: Who sits there.
        refused: How many commands the module has refused since it started.
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
