"""Reads messages in the encoding of ROS 1: as CDR, without a head and without gaps."""

from __future__ import annotations

import struct
from typing import Any, Final

import numpy as np

from hub.errors import RosMessageError
from hub.ipc.formats.grammar import MAX_ITEMS
from hub.ros.schema import EMPTY, TEXT, RosField, RosType

LETTERS: Final = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "octet": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""Letters of `struct`, and of numpy."""


def ros1_values(kind: RosType, payload: bytes | memoryview) -> tuple[Any, ...]:
    """The values of the fields of a message.

    Raises:
        RosMessageError: The payload is no message of this type.
    """
    reader = _Ros1Reader(payload)
    values = reader.message(kind)
    reader.end()
    return values


class _Ros1Reader:
    def __init__(self, payload: bytes | memoryview) -> None:
        self._data = memoryview(payload)
        self._at = 0
        self._items = 0

    def message(self, kind: RosType) -> tuple[Any, ...]:
        return tuple(self._field(each) for each in kind.fields)

    def end(self) -> None:
        """Refuse a payload with more bytes than the message."""
        if self._at < len(self._data):
            self._refuse(f"it has {len(self._data)} bytes, and a message ends at {self._at}")

    def _field(self, each: RosField) -> Any:  # noqa: ANN401 - fields have any type
        if each.name == EMPTY:  # only ROS 2 writes a byte for a type without fields
            return 0
        if each.count is None:
            return self._single(each.kind)
        count = each.count or self._length()
        letter = LETTERS.get(each.kind) if isinstance(each.kind, str) else None
        if letter is not None:
            kind = np.dtype(f"<{letter}" if letter != "?" else "u1")
            numbers = np.frombuffer(self._bytes(count * kind.itemsize), kind)
            return numbers != 0 if letter == "?" else numbers
        self._items += count
        if self._items > MAX_ITEMS:
            self._refuse(f"it has more than {MAX_ITEMS} elements")
        return [self._single(each.kind) for _ in range(count)]

    def _single(self, kind: str | RosType) -> Any:  # noqa: ANN401 - fields have any type
        if isinstance(kind, RosType):
            return self.message(kind)
        if kind == TEXT:
            return bytes(self._bytes(self._length())).decode("utf-8", "replace")
        number = struct.Struct("<" + LETTERS[kind])
        return number.unpack(self._bytes(number.size))[0]

    def _length(self) -> int:
        return int.from_bytes(self._bytes(4), "little")

    def _bytes(self, count: int) -> memoryview:
        found = self._data[self._at : self._at + count]
        if len(found) < count:
            self._refuse(f"it has {len(self._data)} bytes, and byte {self._at + count} is missing")
        self._at += count
        return found

    def _refuse(self, reason: str) -> None:
        raise RosMessageError(reason)
