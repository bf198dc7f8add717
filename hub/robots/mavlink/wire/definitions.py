"""The formats of MAVLink messages, from `definitions.txt`.

A line of the file is a message: its name, id, CRC extra byte and least length of the payload.
Messages that Rune reads or sends have their wire format and fields too. A test writes the file from
the definitions in pymavlink's wheel, see `tests/support/mavlink_definitions.py`.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from hub.values import dataclass

_TABLE = Path(__file__).with_suffix(".txt")
_CODE = re.compile(r"(?P<count>\d*)(?P<code>[a-zA-Z])")
LONGEST_PAYLOAD: Final = 255
"""Longest payload of a frame [bytes]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldFormat:
    """One field of a message.

    Attributes:
        name: As in the definitions.
        count: Number of elements of an array, or of bytes of a text; 0: one number.
        text: Whether it is a text.
    """

    name: str
    count: int
    text: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MessageFormat:
    """The format of one message.

    Attributes:
        name: As in the definitions.
        number: Its id.
        crc_extra: Seed of its checksum, which depends on names and types of its fields.
        least: Length of its payload without extension fields [bytes], which is that in MAVLink 1.
        wire: Layout of the whole payload; empty: Rune does not read its fields.
        fields: The fields in the order of the payload; none: Rune does not read them.
    """

    name: str
    number: int
    crc_extra: int
    least: int
    wire: struct.Struct
    fields: tuple[FieldFormat, ...]

    def values(self, payload: bytes) -> dict[str, object]:
        """The fields of a payload by name; trailing zeros that were cut off are added."""
        size = self.wire.size
        numbers = iter(self.wire.unpack(payload[:size].ljust(size, b"\0")))
        read: dict[str, object] = {}
        for field in self.fields:
            if field.text:
                read[field.name] = next(numbers).split(b"\0", 1)[0].decode("utf-8", "replace")
            elif field.count:
                read[field.name] = tuple(next(numbers) for _ in range(field.count))
            else:
                read[field.name] = next(numbers)
        return read

    def payload(self, values: Mapping[str, object]) -> bytes:
        """The payload with these fields, without its trailing zeros; a missing field is 0.

        Raises:
            KeyError: There is a field that the message does not have.
            struct.error: A value is not in the range of its field.
        """
        left = dict(values)
        numbers: list[object] = []
        for field in self.fields:
            value = left.pop(field.name, None)
            if field.text:
                numbers.append(str(value or "").encode()[: field.count])
            elif field.count:
                array = tuple(value) if isinstance(value, (tuple, bytes)) else ()
                numbers += [*array, *[0] * (field.count - len(array))]
            else:
                numbers.append(value or 0)
        if left:
            text = f"{self.name} has no field {', '.join(left)}"
            raise KeyError(text)
        return self.wire.pack(*numbers).rstrip(b"\0") or b"\0"


def _read(text: str) -> Iterator[MessageFormat]:
    for line in text.splitlines():
        if line.startswith("#"):
            continue
        name, number, crc_extra, least, *rest = line.split()
        wire, names = (rest[0], rest[1:]) if rest else ("<", [])
        codes = [*_CODE.finditer(wire)]
        yield MessageFormat(
            name=name,
            number=int(number),
            crc_extra=int(crc_extra),
            least=int(least),
            wire=struct.Struct(wire),
            fields=tuple(
                FieldFormat(name=field, count=int(code["count"] or 0), text=code["code"] == "s")
                for field, code in zip(names, codes, strict=True)
            ),
        )


BY_NUMBER: Final[Mapping[int, MessageFormat]] = {
    each.number: each for each in _read(_TABLE.read_text("ascii"))
}
BY_NAME: Final[Mapping[str, MessageFormat]] = {each.name: each for each in BY_NUMBER.values()}
