"""The origin, order and age of a received message."""

from __future__ import annotations

from typing import Any, NamedTuple

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.ipc.wire import frames


class MessageInfo(NamedTuple):
    """Origin, order and age of a message.

    Attributes:
        publisher: Number of the sender's connection.
        sequence: Counts the messages of this name from this publisher, from 1.
        missed: Messages that were lost or dropped since the one before.
        age: Time since its measurement [s]; inf: not known, of a command that is stamped ahead of
            the hub's clock.
        measured: Time of its measurement, on this process's monotonic clock [s].
    """

    publisher: int
    sequence: int
    missed: int
    age: float
    measured: float


Gathered = tuple[Any, bytes, float, float, int, int]
"""A message among many: its label, its payload, when it came, when it was measured, its number, and
its length [bytes]. Times are on this process's monotonic clock [s].

A plain tuple, because a class costs a tenth of the reception.
"""


def decode(definition: MessageDefinition[Any], frame: frames.Frame) -> Any:
    """The value in a frame of `definition`.

    Raises:
        CodecError: It is another message, in another format, or malformed.
    """
    if frame.name != definition.name or frame.fingerprint != definition.fingerprint:
        text = f"{frame.name} came where {definition.name} in its own format was expected"
        raise CodecError(text)
    return definition.decode(frame.payload)
