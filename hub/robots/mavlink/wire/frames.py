"""Packs MAVLink 2 frames of one sender, and finds frames of versions 1 and 2 in bytes.

| bytes | action |
| --- | --- |
| no start of a frame | skip them to the next start |
| a start with an unknown id, unknown flags, or a wrong length of version 1 | skip one byte |
| a wrong checksum | skip one byte |
| a frame that is not complete | keep it for the next bytes; a datagram starts again |
| a signed frame that is not genuine, or an unsigned one where a key is set | skip it |

A start with an unknown id is never waited for: noise would hold back the frames after it.
"""

from __future__ import annotations

import struct
from typing import Any, Final

from hub.robots.mavlink.wire.checksum import checksum
from hub.robots.mavlink.wire.definitions import BY_NAME, BY_NUMBER, MessageFormat
from hub.robots.mavlink.wire.signing import SIGNATURE, Signer
from hub.values import dataclass

VERSION_2: Final = 0xFD
VERSION_1: Final = 0xFE
_HEADER_2: Final = 10
_HEADER_1: Final = 6
_SIGNED: Final = 1
"""The only flag of a frame that changes how it is read."""
_HEADER: Final = struct.Struct("<BBBBBBBHB")
_UNSIGNED: Final = frozenset({"RADIO_STATUS", "RADIO"})
"""Telemetry radios put these into the stream, and have no key."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MavlinkFrame:
    """One frame that came.

    Attributes:
        name: Name of its message.
        system: Number of the sender's vehicle or station.
        component: Number of the sender in it.
        sequence: 0 to 255, one more with each frame of a sender.
        signed: Whether it has a genuine signature.
        fields: Its fields by name; none: Rune does not read this message.
        raw: Its bytes.
    """

    name: str
    system: int
    component: int
    sequence: int
    signed: bool
    fields: dict[str, Any]
    raw: bytes

    @property
    def claims_signature(self) -> bool:
        """Whether it has a signature, genuine or not."""
        return self.raw[0] == VERSION_2 and bool(self.raw[2] & _SIGNED)

    def __getitem__(self, field: str) -> Any:  # noqa: ANN401 - a number, a text or a tuple
        """A field by name."""
        return self.fields[field]


class FramePacker:
    """Packs the frames of one sender.

    Attributes:
        system: Its number.
        signs: Whether its frames have signatures.
    """

    def __init__(self, system: int, component: int, signer: Signer | None = None) -> None:
        """Take the sender's numbers.

        Args:
            system: Number of the station or vehicle, 1 to 255.
            component: Number in it, 1 to 255.
            signer: Signs the frames; None: they have no signatures.
        """
        self.system, self._component = system, component
        self._signer, self.signs = signer, signer is not None
        self._sequence = 0

    def pack(self, name: str, /, **fields: object) -> bytes:
        """The frame of a message; fields that are not given are 0.

        Raises:
            KeyError: There is no such message or field.
            struct.error: A value is not in the range of its field.
        """
        form = BY_NAME[name]
        payload = form.payload(fields)
        header = _HEADER.pack(
            VERSION_2,
            len(payload),
            _SIGNED if self._signer else 0,
            0,
            self._sequence,
            self.system,
            self._component,
            form.number & 0xFFFF,
            form.number >> 16,
        )
        self._sequence = (self._sequence + 1) & 0xFF
        body = header + payload
        crc = checksum(body[1:] + bytes((form.crc_extra,)))
        frame = body + crc.to_bytes(2, "little")
        return frame + self._signer.signature(frame) if self._signer else frame


class FrameParser:
    """Finds the frames in the bytes of one link.

    Attributes:
        skipped: Bytes that belong to no frame.
        damaged: Frames with a wrong checksum, and starts that were none.
        unknown: Starts with the id of no known message.
        refused: Frames without a genuine signature where a key is set.
    """

    def __init__(self, signer: Signer | None = None) -> None:
        """Take the key.

        Args:
            signer: Checks the signatures; None: signatures are not read.
        """
        self._signer = signer
        self._rest = b""
        self.skipped = self.damaged = self.unknown = self.refused = 0

    def datagram(self, data: bytes) -> list[MavlinkFrame]:
        """The frames in a datagram; one that is not complete is lost."""
        self._rest = b""
        frames = self.feed(data)
        self.skipped += len(self._rest)
        self._rest = b""
        return frames

    def feed(self, data: bytes) -> list[MavlinkFrame]:
        """The frames that are complete with these bytes of a stream."""
        data = self._rest + data if self._rest else data
        frames: list[MavlinkFrame] = []
        at, end = 0, len(data)
        while at < end:
            start = data[at]
            if start != VERSION_2 and start != VERSION_1:
                next_start = _next_start(data, at)
                self.skipped += next_start - at
                at = next_start
                continue
            header = _HEADER_2 if start == VERSION_2 else _HEADER_1
            if end - at < header:
                break
            length = data[at + 1]
            form, flags = _format(data, at)
            if form is None or flags > _SIGNED or (start == VERSION_1 and length != form.least):
                self.unknown += form is None
                self.damaged += form is not None
                at += 1
                continue
            whole = header + length + 2 + SIGNATURE * flags
            if end - at < whole:
                break
            body_end = at + header + length
            crc = data[body_end] | data[body_end + 1] << 8
            if checksum(data[at + 1 : body_end] + bytes((form.crc_extra,))) != crc:
                self.damaged += 1
                at += 1
                continue
            frame = self._frame(form, data[at : at + whole], header, length)
            if frame is None:
                self.refused += 1
            else:
                frames.append(frame)
            at += whole
        self._rest = data[at:]
        return frames

    def _frame(
        self, form: MessageFormat, raw: bytes, header: int, length: int
    ) -> MavlinkFrame | None:
        """A frame with a right checksum; None: its signature is missing or not genuine."""
        first = header - 6 if header == _HEADER_2 else 2
        sequence, system, component = raw[first : first + 3]
        signed = False
        if self._signer is not None:
            signed = len(raw) > header + length + 2 and self._signer.genuine(raw, system, component)
            if not signed and form.name not in _UNSIGNED:
                return None
        return MavlinkFrame(
            name=form.name,
            system=system,
            component=component,
            sequence=sequence,
            signed=signed,
            fields=form.values(raw[header : header + length]),
            raw=raw,
        )


def _next_start(data: bytes, at: int) -> int:
    """Where the next frame may begin; the end of the data: nowhere."""
    starts = data.find(VERSION_2, at), data.find(VERSION_1, at)
    return min((each for each in starts if each >= 0), default=len(data))


def _format(data: bytes, at: int) -> tuple[MessageFormat | None, int]:
    """The message of a frame that begins here, and its flags."""
    if data[at] == VERSION_1:
        return BY_NUMBER.get(data[at + 5]), 0
    number = data[at + 7] | data[at + 8] << 8 | data[at + 9] << 16
    return BY_NUMBER.get(number), data[at + 2]
