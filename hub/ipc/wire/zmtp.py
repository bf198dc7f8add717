"""ZMTP 3.1 as a PULL socket without encryption receives it; pure.

The protocol: https://rfc.zeromq.org/spec/37. Behind a greeting of 64 bytes, each side says READY,
and then all is frames: flags (1 byte), length (1 byte, or 8 if the flags say so), and content.
"""

from __future__ import annotations

import struct
from typing import Final

from hub.errors import FrameError
from hub.ipc.wire.frames import MAX_FRAME

_SIGNATURE: Final = b"\xff" + bytes(8) + b"\x7f"
_NULL: Final = b"NULL" + bytes(16)
GREETING: Final = _SIGNATURE + b"\x03\x01" + _NULL + bytes(32)
"""What each side sends first."""
_LONG, _COMMAND = 2, 4
_MAX_COMMAND: Final = 512
_PING: Final = b"\x04PING"
_PING_CONTEXT: Final = len(_PING) + 2
_LENGTH = struct.Struct(">Q")
_LONG_HEAD: Final = 1 + _LENGTH.size


def command(name: bytes, content: bytes) -> bytes:
    """A short command as a frame."""
    body = bytes([len(name)]) + name + content
    return bytes([_COMMAND, len(body)]) + body


READY: Final = command(b"READY", b"\x0bSocket-Type\x00\x00\x00\x04PULL")
"""The answer to the greeting."""


class Stream:
    """The bytes of one connection, until they are whole messages.

    Attributes:
        ready: Whether the other side has said READY.
    """

    def __init__(self) -> None:
        """Expect a greeting."""
        self.ready = False
        self._greeted = False
        self._waiting = bytearray()
        self._needed = len(GREETING)
        self._answer = b""

    def answer(self) -> bytes:
        """The bytes for the other side; each time only the new ones."""
        answer, self._answer = self._answer, b""
        return answer

    def feed(self, data: bytes) -> tuple[bytes, list[int]]:
        """Take received bytes.

        Returns a text, and where in it each whole message begins and ends, in turn.

        Raises:
            FrameError: They are not from a PUSH socket of our own version without encryption.
        """
        if self._waiting:
            self._waiting += data
            if len(self._waiting) < self._needed:
                return b"", []
            data = bytes(self._waiting)
        at = 0
        if not self._greeted:
            if len(data) < len(GREETING):
                self._waiting = bytearray(data)
                return b"", []
            self._greet(data[: len(GREETING)])
            at = len(GREETING)
        places, at = self._frames(data, at)
        self._waiting = bytearray(data[at:])
        return data, places

    def _frames(self, data: bytes, at: int) -> tuple[list[int], int]:
        """Begin and end of each whole message from a place on, in turn; and where the rest is."""
        places: list[int] = []
        end, self._needed = len(data), 0
        while end - at >= 2:
            flags, length, start = data[at], data[at + 1], at + 2
            if flags & _LONG:
                start = at + _LONG_HEAD
                if start > end:
                    break
                (length,) = _LENGTH.unpack_from(data, at + 1)
                if length > MAX_FRAME:
                    text = f"a frame of {length} bytes is announced; {MAX_FRAME} are most"
                    raise FrameError(text)
            if start + length > end:
                self._needed = start + length - at
                break
            at = start + length
            if flags & _COMMAND or not self.ready:
                self._obey(flags, data[start:at])
            else:
                places += (start, at)
        return places, at

    def _greet(self, greeting: bytes) -> None:
        self._greeted = True
        signed = greeting[0] == _SIGNATURE[0] and greeting[9] & 1
        if not signed or greeting[10] < 3 or greeting[12:32] != _NULL:
            text = f"a connection begins with {greeting[:12]!r}, which is no greeting of ZMTP 3"
            raise FrameError(text)

    def _obey(self, flags: int, content: bytes) -> None:
        if not flags & _COMMAND:
            text = "a message came before READY"
            raise FrameError(text)
        if len(content) > _MAX_COMMAND:
            text = f"a command of {len(content)} bytes is too long; {_MAX_COMMAND} are most"
            raise FrameError(text)
        if not self.ready:
            if not content.startswith(b"\x05READY"):
                text = f"a connection says {content[:16]!r} instead of READY"
                raise FrameError(text)
            self.ready = True
        elif content.startswith(_PING):
            self._answer = command(b"PONG", content[_PING_CONTEXT : _PING_CONTEXT + 16])
