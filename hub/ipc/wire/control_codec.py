"""The encoding of control messages.

A control message is one ZeroMQ frame: "RUNE", protocol version, kind, two zero bytes, and a CDR
payload in the kind's format. QUERY and RESPONSE are followed by a second frame with the message.
"""

from __future__ import annotations

import struct
from typing import Any

from hub.errors import FrameError
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.codegen import Buffer
from hub.ipc.wire import control, frames

_PREAMBLE = struct.Struct("<4sBBH")
_MAGIC = b"RUNE"

KINDS: tuple[MessageDefinition[Any], ...] = tuple(
    MessageDefinition(name=control.KINDS[number].name, type=control.KINDS[number].message)
    for number in range(1, len(control.KINDS) + 1)
)
"""The kinds, in the order of their numbers."""

_NUMBER = {definition.type: number for number, definition in enumerate(KINDS, 1)}


def pack(message: Any, version: int = frames.VERSION) -> bytes:
    """The frame of a control message; HELLO and REFUSED are alike in every version."""
    number = _NUMBER[type(message)]
    preamble = _PREAMBLE.pack(_MAGIC, version, number, 0)
    return b"".join((preamble, *KINDS[number - 1].encode(message)))


def peek(raw: Buffer) -> type | None:
    """The kind of a control message by its preamble; None: it is none."""
    view = memoryview(raw)
    number = view[5] if len(view) >= _PREAMBLE.size else 0
    return KINDS[number - 1].type if 1 <= number <= len(KINDS) else None


def other_version(raw: Buffer) -> int:
    """The protocol version of a HELLO if it is another one; 0: it is not."""
    view = memoryview(raw)
    if len(view) < _PREAMBLE.size or peek(view) is not control.Hello:
        return 0
    magic, version, _, _ = _PREAMBLE.unpack_from(view)
    return int(version) if magic == _MAGIC and version != frames.VERSION else 0


def unpack(raw: Buffer) -> Any:
    """The control message in a frame.

    Raises:
        FrameError: The bytes are no control message of this protocol version.
        CodecError: The payload does not fit its kind.
    """
    view = memoryview(raw)
    if len(view) < _PREAMBLE.size:
        text = f"a control frame of {len(view)} bytes has no whole preamble"
        raise FrameError(text)
    magic, version, number, _ = _PREAMBLE.unpack_from(view)
    if magic != _MAGIC:
        text = "a control frame does not start with RUNE"
        raise FrameError(text)
    if version != frames.VERSION:
        text = f"a control frame has protocol version {version}, this is {frames.VERSION}"
        raise FrameError(text)
    if not 1 <= number <= len(KINDS):
        text = f"a control frame has the unknown kind {number}"
        raise FrameError(text)
    return KINDS[number - 1].decode(view[_PREAMBLE.size :])
