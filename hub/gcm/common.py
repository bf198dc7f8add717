"""What any module may be told, by name: the common commands."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from hub.gcm.fields import Flag, Name, Sentence
from hub.ipc.definition import Keep, MessageDefinition, Plane


class CommonCommandKind(enum.IntEnum):
    """What a `CommonCommand` asks for.

    Attributes:
        START: Run; the daemon starts the module if it does not.
        STOP: End in order; the daemon does not start the module again until it is told to.
        RESTART: End in order and begin anew.
        STATUS: Publish `GCM_ModuleInfo` now.
        LOG_LEVEL: Log from the level in `argument` on: debug, info, warning or error.
        CAPABILITIES: Publish `GCM_ModuleInfo` now, which lists them.
    """

    START = 0
    STOP = 1
    RESTART = 2
    STATUS = 3
    LOG_LEVEL = 4
    CAPABILITIES = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class CommonCommand:
    """Tell a module something that any module understands.

    Attributes:
        module: Its name; empty means all of them.
        command: What to do.
        argument: As the command says; empty otherwise.
    """

    module: Name = ""
    command: CommonCommandKind = CommonCommandKind.STATUS
    argument: Sentence = ""


COMMON_COMMAND = MessageDefinition(
    name="GCM_Common_Command",
    type=CommonCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=5.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestData:
    """Ask whoever publishes a message to publish it now.

    Attributes:
        message: Its name.
    """

    message: Name = ""


REQUEST_DATA = MessageDefinition(
    name="GCM_Common_RequestData",
    type=RequestData,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CommonResult:
    """What is said to a request that can be done or refused.

    Attributes:
        done: 1 if it is done, 0 if it cannot be.
        text: What was done, or why not.
    """

    done: Flag
    text: Sentence


COMMON_RESULT = MessageDefinition(name="GCM_Common_Result", type=CommonResult)

MESSAGES = (COMMON_COMMAND, REQUEST_DATA, COMMON_RESULT)
