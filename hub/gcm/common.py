"""The common commands to any module."""

from __future__ import annotations

import enum

from hub.gcm.fields import Flag, Name, Sentence
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.values import dataclass


class CommonCommandKind(enum.IntEnum):
    """The order in a `CommonCommand`.

    Attributes:
        START: Run; the daemon starts the module if needed.
        STOP: End in order; the daemon starts the module again only after START.
        RESTART: End in order and start again.
        STATUS: Publish `GCM_ModuleInfo` now.
        LOG_LEVEL: Set the log level to `argument`: debug, info, warning or error.
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
    """An order that any module understands.

    Attributes:
        module: Its name; empty: all modules.
        command: The order.
        argument: Argument of the order; else empty.
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
    """Ask the publishers of a message to publish it now.

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
    """The answer to a request.

    Attributes:
        done: 1: it is done; 0: it is refused.
        text: The result, or the reason.
    """

    done: Flag
    text: Sentence


COMMON_RESULT = MessageDefinition(name="GCM_Common_Result", type=CommonResult)

MESSAGES = (COMMON_COMMAND, REQUEST_DATA, COMMON_RESULT)
