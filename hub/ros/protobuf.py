"""Reads messages of Protocol Buffers by the descriptors in a recording.

A descriptor set is such a message itself, so the reader of the wire format reads both. The format:
https://protobuf.dev/programming-guides/encoding
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from hub.errors import RosMessageError
from hub.ipc.formats.grammar import MAX_ITEMS
from hub.values import dataclass

MOST_DEPTH: Final = 32
"""Messages within messages."""
_MOST_TYPES: Final = 20_000
_VARINT, _EIGHT, _BYTES, _FOUR = 0, 1, 2, 5
"""Ways to write a value."""
_FIXED: Final = {1: "<d", 2: "<f", 6: "<Q", 7: "<I", 15: "<i", 16: "<q"}
"""Types of 4 or 8 bytes, and their letters."""
_SIGNED: Final = {3, 5, 14}
_ZIGZAG: Final = {17, 18}
_NARROW: Final = {5, 13, 14}
_BOOL, _STRING, _GROUP, _MESSAGE, _RAW = 8, 9, 10, 11, 12
_REPEATED: Final = 3

Wire = Iterator[tuple[int, int, Any]]


@dataclass(frozen=True, slots=True)
class ProtoField:
    """A field of a type.

    Attributes:
        name: Its name.
        kind: Its type, as descriptors number them.
        message: Name of the type of a message; empty: it is none.
        repeated: It has any number of values.
    """

    name: str
    kind: int
    message: str
    repeated: bool


class ProtobufReader:
    """Reads the messages of one topic."""

    def __init__(self, name: str, descriptors: bytes) -> None:
        """Read the descriptors.

        Args:
            name: Name of the type.
            descriptors: A FileDescriptorSet.

        Raises:
            RosMessageError: They cannot be read, or lack the type.
        """
        self._types: dict[str, Mapping[int, ProtoField]] = {}
        self._empty: dict[str, dict[str, Any]] = {}
        self._items = 0
        for number, _, file in self._wire(descriptors):
            if number == 1:
                self._take_file(_raw(file))
        self._name = name.removeprefix(".")
        if self._name not in self._types:
            text = f"its definition lacks the type {name[:80]}"
            raise RosMessageError(text)

    def values(self, payload: bytes | memoryview) -> dict[str, Any]:
        """The values of a message by name; fields that are not in it have their usual value.

        Raises:
            RosMessageError: The payload is no message of this type.
        """
        self._items = 0
        return self._message(self._name, memoryview(payload), 0)

    def _message(self, name: str, data: memoryview, depth: int) -> dict[str, Any]:
        if depth > MOST_DEPTH:
            text = f"it has messages within messages deeper than {MOST_DEPTH}"
            raise RosMessageError(text)
        fields = self._types.get(name, {})
        values = dict(self._without_values(name, ()))
        lists: dict[str, list[Any]] = {}
        for number, way, value in self._wire(data):
            each = fields.get(number)
            if each is None:
                continue
            if not each.repeated:
                values[each.name] = self._value(each, way, value, depth)
            elif way == _BYTES and each.kind not in (_STRING, _MESSAGE, _RAW):
                numbers = self._packed(each, value)
                if isinstance(numbers, list) or each.name in lists:
                    lists.setdefault(each.name, []).extend(numbers)
                else:
                    values[each.name] = numbers
            else:
                lists.setdefault(each.name, []).append(self._value(each, way, value, depth))
        return values | lists

    def _value(self, each: ProtoField, way: int, value: Any, depth: int) -> Any:  # noqa: ANN401 - any
        if each.kind in _FIXED and way in (_EIGHT, _FOUR):
            letter = _FIXED[each.kind]
            if struct.calcsize(letter) == len(value):
                return struct.unpack(letter, value)[0]
        elif each.kind == _MESSAGE and way == _BYTES:
            return self._message(each.message, value, depth + 1)
        elif each.kind == _STRING and way == _BYTES:
            return bytes(value).decode("utf-8", "replace")
        elif each.kind == _RAW and way == _BYTES:
            return value
        elif way == _VARINT and each.kind not in (_STRING, _MESSAGE, _RAW, *_FIXED):
            return _number(each.kind, value)
        text = f"its field {each.name[:80]} is of another type"
        raise RosMessageError(text)

    def _packed(self, each: ProtoField, value: memoryview) -> Any:  # noqa: ANN401 - list or array
        """Several numbers in one value."""
        letter = _FIXED.get(each.kind)
        if letter is not None:
            kind = np.dtype(letter)
            return np.frombuffer(value[: len(value) // kind.itemsize * kind.itemsize], kind)
        found, at = [], 0
        while at < len(value):
            number, at = _varint(value, at)
            found.append(_number(each.kind, number))
        self._count(len(found))
        return found

    def _without_values(self, name: str, within: tuple[str, ...]) -> dict[str, Any]:
        """The values of a message in which nothing is written; None in place of rings of types."""
        if name not in self._empty:
            made: dict[str, Any] = {}
            for each in self._types.get(name, {}).values():
                ring = each.message in (*within, name) or len(within) > MOST_DEPTH
                if each.repeated:
                    made[each.name] = []
                elif each.kind == _MESSAGE:
                    inner = (*within, name)
                    made[each.name] = None if ring else self._without_values(each.message, inner)
                else:
                    made[each.name] = {_STRING: "", _RAW: b"", _BOOL: False}.get(each.kind, 0)
            self._empty[name] = made
        return self._empty[name]

    def _take_file(self, file: memoryview) -> None:
        """Take a FileDescriptorProto."""
        package, messages = "", []
        for number, _, value in self._wire(file):
            if number == 2:
                package = _text(value)
            elif number == 4:
                messages.append(_raw(value))
        for each in messages:
            self._take_type(package, each, 0)

    def _take_type(self, around: str, content: memoryview, depth: int) -> None:
        """Take a DescriptorProto."""
        if depth > MOST_DEPTH or len(self._types) >= _MOST_TYPES:
            text = "its definition has too many types, or too deep ones"
            raise RosMessageError(text)
        name, inner, fields = "", [], {}
        for number, _, value in self._wire(content):
            if number == 1:
                name = _text(value)
            elif number == 2:
                place, made = self._field(_raw(value))
                fields[place] = made
            elif number == 3:
                inner.append(_raw(value))
        full = f"{around}.{name}" if around else name
        self._types[full] = fields
        for each in inner:
            self._take_type(full, each, depth + 1)

    def _field(self, content: memoryview) -> tuple[int, ProtoField]:
        """Number and content of a FieldDescriptorProto."""
        found = {number: value for number, _, value in self._wire(content)}
        kind = _whole(found.get(5, 0))
        if kind == _GROUP:
            text = "its definition has a group, which Rune does not read"
            raise RosMessageError(text)
        message = _text(found.get(6)).removeprefix(".") if kind == _MESSAGE else ""
        name, repeated = _text(found.get(1)), _whole(found.get(4, 0)) == _REPEATED
        return _whole(found.get(3, 0)), ProtoField(name, kind, message, repeated)

    def _wire(self, content: bytes | memoryview) -> Wire:
        """Number, way and value of each field that is written; the value is a number or bytes.

        Raises:
            RosMessageError: It is cut, or no message.
        """
        data, at = memoryview(content), 0
        while at < len(data):
            self._count(1)
            key, at = _varint(data, at)
            number, way = key >> 3, key & 7
            if way == _VARINT:
                value, at = _varint(data, at)
                yield number, way, value
                continue
            if way == _BYTES:
                length, at = _varint(data, at)
            elif way in (_EIGHT, _FOUR):
                length = 8 if way == _EIGHT else 4
            else:
                text = f"byte {at} is no value of protobuf"
                raise RosMessageError(text)
            if length > len(data) - at:
                text = f"it is cut: {length} bytes are announced, and {len(data) - at} follow"
                raise RosMessageError(text)
            yield number, way, data[at : at + length]
            at += length

    def _count(self, items: int) -> None:
        self._items += items
        if self._items > MAX_ITEMS:
            text = f"it has more than {MAX_ITEMS} values"
            raise RosMessageError(text)


def _varint(data: memoryview, at: int) -> tuple[int, int]:
    """A number, and the place behind it."""
    value = shift = 0
    for place in range(at, min(at + 10, len(data))):
        byte = data[place]
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & 0xFFFF_FFFF_FFFF_FFFF, place + 1
        shift += 7
    text = "it is cut, or has a number that is too long"
    raise RosMessageError(text)


def _number(kind: int, value: int) -> int | bool:
    if kind == _BOOL:
        return value != 0
    if kind in _ZIGZAG:
        return (value >> 1) ^ -(value & 1)
    if kind in _NARROW:
        value &= 0xFFFF_FFFF
        return value - (1 << 32) if kind in _SIGNED and value >> 31 else value
    return value - (1 << 64) if kind in _SIGNED and value >> 63 else value


def _raw(value: Any) -> memoryview:  # noqa: ANN401 - what the wire has
    if not isinstance(value, memoryview):
        text = "its definition is no descriptor of protobuf"
        raise RosMessageError(text)
    return value


def _text(value: Any) -> str:  # noqa: ANN401 - what the wire has
    return bytes(_raw(value)).decode("utf-8", "replace")


def _whole(value: Any) -> int:  # noqa: ANN401 - what the wire has
    return value if isinstance(value, int) else 0
