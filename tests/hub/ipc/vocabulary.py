"""Messages that the tests of the bus send."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hub.ipc.definition import Keep, MessageDefinition, Plane


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    value: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    name: str
    count: int
    pixels: npt.NDArray[np.uint8]


STREAM = MessageDefinition(name="T_Stream", format="{int}", type=Number, rate_hz=20.0)
OTHER_STREAM = MessageDefinition(name="T_Stream", format="{double}", type=Number)
STREAM_LONGER_NAME = MessageDefinition(name="T_Stream2", format="{int}", type=Number)
LOG = MessageDefinition(name="T_Log", format="{int}", type=Number, keep=Keep.ALL)
LOG_TOO = MessageDefinition(name="T_LogToo", format="{int}", type=Number, keep=Keep.ALL)
EVENT = MessageDefinition(
    name="T_Event", format="{int}", type=Number, keep=Keep.ALL, plane=Plane.COMMAND
)
COMMAND = MessageDefinition(
    name="T_Command", format="{int}", type=Number, plane=Plane.COMMAND, lifespan_s=0.3
)
PICTURE = MessageDefinition(name="T_Picture", format="{string,uint,<ubyte:2>}", type=Picture)
ASK = MessageDefinition(name="T_Ask", format="{int}", type=Number)
ANSWER = MessageDefinition(name="T_Answer", format="{int}", type=Number)
PICTURE_NUMBER = MessageDefinition(
    name="T_PictureNumber", format="{int}", type=Number, keep=Keep.ALL, plane=Plane.PICTURE
)
RING_PICTURE = MessageDefinition(
    name="T_RingPicture",
    format="{string,uint,<ubyte:2>}",
    type=Picture,
    plane=Plane.PICTURE,
)
