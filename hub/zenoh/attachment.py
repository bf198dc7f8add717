"""The header of a message in a fleet: what the frame of the bus has besides name and payload; pure.

Its stamp is on the monotonic clock of the robot in the key, for commands too: their
sender measures that clock by queries of `clock`, as a client of the bus does.
"""

from __future__ import annotations

import math
import struct

from hub.errors import FrameError
from hub.ipc.definition import MAX_NAME_LENGTH, Keep, MessageDefinition, Plane
from hub.values import dataclass

VERSION = 1
COMMAND_LIFESPAN_S = 2.0
"""Age beyond which no command is obeyed, where its definition allows more [s]."""
PICTURE_LIFESPAN_S = 5.0
"""Age beyond which no picture is put, where its definition allows more [s]."""
_FIXED = struct.Struct("<BxxxIQQq")
CLOCK = struct.Struct("<q")
"""The answer of `clock`: time on the hub's monotonic clock [ns]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Attachment:
    """Origin, format, order and time of a message.

    Attributes:
        publisher: From a robot: number of the sender at the robot's hub. From an operator: number
            of its session.
        fingerprint: Identity of the payload's format.
        sequence: Counts the messages of this name from this publisher, from 1.
        stamp_ns: Time of measurement, on the clock of the robot's hub [ns].
        name: Name of the message, in answers to queries only; else the key has it.
    """

    publisher: int
    fingerprint: int
    sequence: int
    stamp_ns: int
    name: str = ""

    def pack(self) -> bytes:
        """Its bytes."""
        fixed = _FIXED.pack(VERSION, self.publisher, self.fingerprint, self.sequence, self.stamp_ns)
        return fixed + self.name.encode("ascii")

    def age(self, now_ns: int) -> float:
        """Time since its measurement [s]; never below 0."""
        return max(0, now_ns - self.stamp_ns) * 1e-9


def unpack(raw: bytes | None) -> Attachment:
    """The header in an attachment that came from outside.

    Raises:
        FrameError: There is none, or it is of another version or length.
    """
    size = len(raw) if raw is not None else 0
    if raw is None or size < _FIXED.size or size > _FIXED.size + MAX_NAME_LENGTH:
        text = f"an attachment of {size} bytes is no header of a fleet's message"
        raise FrameError(text)
    version, publisher, fingerprint, sequence, stamp_ns = _FIXED.unpack_from(raw)
    if version != VERSION:
        text = f"a fleet's message has version {version}, this is {VERSION}; update the older side"
        raise FrameError(text)
    name = raw[_FIXED.size :].decode("ascii", "replace")
    if name and not (name.isascii() and name.isidentifier()):
        text = f"a fleet's answer has {name[:20]!r} as its name, which is no message name"
        raise FrameError(text)
    return Attachment(
        publisher=publisher,
        fingerprint=fingerprint,
        sequence=sequence,
        stamp_ns=stamp_ns,
        name=name,
    )


def has_twin(definition: MessageDefinition[object]) -> bool:
    """Whether a message also comes at the low rate: a state whose newest value counts."""
    return definition.plane is Plane.STATE and definition.keep is Keep.NEWEST


def lifespan(definition: MessageDefinition[object]) -> float:
    """Age beyond which a message is dropped, before it is put and after it came [s].

    A message that counts even when it cannot be read has no limit: a stop is never too old.
    """
    if definition.unreadable is not None:
        return math.inf
    longest = {Plane.COMMAND: COMMAND_LIFESPAN_S, Plane.PICTURE: PICTURE_LIFESPAN_S}
    return min(definition.lifespan_s, longest.get(definition.plane, math.inf))
