"""Encodes messages of ROS by their types: as CDR for ROS 2, and in the encoding of ROS 1."""

from __future__ import annotations

import functools
import struct
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from hub.errors import RosMessageError
from hub.ipc.formats.codec import Codec
from hub.ros.decoding import format_of
from hub.ros.ros1 import LETTERS
from hub.ros.schema import EMPTY, TEXT, RosField, RosType, full_name, ros_type

_NUMBER: Final = struct.Struct("<I")


@functools.lru_cache(maxsize=64)
def encoder_of(name: str, encoding: str, definition: str = "") -> RosEncoder:
    """The encoder of a type.

    Args:
        name: The type, as ROS 2 or ROS 1 write it.
        encoding: "cdr" or "ros1".
        definition: In the encoding "ros2msg" or "ros1msg"; empty: the type is a known one.

    Raises:
        RosMessageError: The type is not known, or its definition cannot be used.
    """
    schema = {"cdr": "ros2msg", "ros1": "ros1msg"}.get(encoding)
    if schema is None:
        text = f"Rune writes cdr and ros1, not {encoding[:40]!r}"
        raise RosMessageError(text)
    return RosEncoder(ros_type(full_name(name), schema, definition), encoding)


class RosEncoder:
    """Encodes the messages of one type.

    A message is a mapping or an object with the fields of the type; those it lacks are zero. The
    field `K` of ROS 1 is also found as `k`.
    """

    def __init__(self, kind: RosType, encoding: str) -> None:
        """Take a type.

        Args:
            kind: The type.
            encoding: "cdr" or "ros1".
        """
        self._type = kind
        self._codec = None if encoding == "ros1" else Codec(format_of(kind))

    def encode(self, message: Any) -> bytes:  # noqa: ANN401 - messages are of any class
        """The payload of a message.

        Raises:
            RosMessageError: A value does not fit its field.
        """
        try:
            values = _values(self._type, message)
            if self._codec is not None:
                return b"".join(self._codec.encode(values))
            parts: list[bytes] = []
            _write(self._type, values, parts)
        except (AttributeError, TypeError, ValueError, struct.error) as error:
            text = f"this is no {self._type.name}: {error}"
            raise RosMessageError(text) from error
        return b"".join(parts)


def _values(kind: RosType, message: Any) -> tuple[Any, ...]:  # noqa: ANN401 - any class
    return tuple(_value(each, _found(message, each.name)) for each in kind.fields)


def _found(message: Any, name: str) -> Any:  # noqa: ANN401 - any class
    if isinstance(message, Mapping):
        return message.get(name, message.get(name.lower()))
    return getattr(message, name, getattr(message, name.lower(), None))


def _value(field: RosField, value: Any) -> Any:  # noqa: ANN401 - fields have any type
    kind = field.kind
    if isinstance(kind, RosType):
        if field.count is None:
            return _values(kind, {} if value is None else value)
        return [_values(kind, each) for each in (() if value is None else value)]
    if field.count is None:
        return value if value is not None else "" if kind == TEXT else 0
    if kind == TEXT:
        return list(() if value is None else value)
    return np.asarray(np.zeros(field.count) if value is None else value, _dtype(kind)).reshape(-1)


def _dtype(kind: str) -> np.dtype[Any]:
    letter = LETTERS[kind]
    return np.dtype(f"<{letter}" if letter != "?" else "?")


def _write(kind: RosType, values: tuple[Any, ...], parts: list[bytes]) -> None:
    """Write a message as ROS 1 does: without gaps."""
    for field, value in zip(kind.fields, values, strict=True):
        if field.name == EMPTY:
            continue
        if field.count == 0:
            parts.append(_NUMBER.pack(len(value)))
        if field.count is None:
            _write_single(field.kind, value, parts)
        elif isinstance(value, np.ndarray):
            parts.append(value.tobytes())
        else:
            for each in value:
                _write_single(field.kind, each, parts)


def _write_single(kind: str | RosType, value: Any, parts: list[bytes]) -> None:  # noqa: ANN401
    if isinstance(kind, RosType):
        _write(kind, value, parts)
    elif kind == TEXT:
        text = value.encode()
        parts += (_NUMBER.pack(len(text)), text)
    else:
        parts.append(struct.pack("<" + LETTERS[kind], value))
