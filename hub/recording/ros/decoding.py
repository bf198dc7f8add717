"""Decodes messages of any ROS 2 type by the definition in their file.

A definition becomes a format of Rune, whose codec reads the payload: arrays of numbers are views of
it, without a copy.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, Final

from hub.errors import CodecError, RecordingError
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codec import Codec
from hub.recording.ros.schema import NUMBERS, RosField, RosType, ros_type
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

READABLE: Final = {"cdr": ("ros2msg", "ros2idl", "")}
"""Encodings of payloads that are decoded, and those of their definitions."""
MOST_PAYLOAD: Final = 1 << 28
"""Longest message that is decoded [bytes]."""


@dataclass(frozen=True, slots=True, eq=False)
class RosValue:
    """A decoded message, or one within it.

    Attributes:
        type: Its type.
        values: The values of its fields, in their order.
    """

    type: RosType
    values: tuple[Any, ...]

    def get(self, path: str) -> Any:  # noqa: ANN401 - fields have any type
        """The value of a field such as `header.stamp`.

        A type is a `RosValue`, an array of types a tuple of them, numbers are arrays (n,).

        Raises:
            RecordingError: There is no such field.
        """
        value: Any = self
        for name in path.split("."):
            value = value.field(name) if isinstance(value, RosValue) else None
        if value is None:
            text = f"{self.type.name} has no field {path[:80]}"
            raise RecordingError(text)
        return value

    def field(self, name: str) -> Any:  # noqa: ANN401 - fields have any type
        """The value of an own field; None: there is none."""
        at = self.type.place(name)
        return None if at < 0 else self._wrapped(self.type.fields[at], self.values[at])

    def fields(self) -> Iterator[tuple[str, Any]]:
        """Name and value of each field."""
        for each, value in zip(self.type.fields, self.values, strict=True):
            yield each.name, self._wrapped(each, value)

    def _wrapped(self, each: RosField, value: Any) -> Any:  # noqa: ANN401 - fields have any type
        if isinstance(each.kind, str):
            return tuple(value) if isinstance(value, list) else value
        if each.count is None:
            return RosValue(each.kind, value)
        return tuple(RosValue(each.kind, item) for item in value)


class RosDecoder:
    """Decodes the messages of one topic.

    Attributes:
        type: Their type.
    """

    def __init__(self, kind: RosType) -> None:
        self.type = kind
        self._codec = Codec(_format(kind))

    @classmethod
    def of(cls, topic: RecordedTopic) -> RosDecoder:
        """The decoder of a topic.

        Raises:
            RecordingError: Its messages cannot be read, and why.
        """
        if topic.encoding not in READABLE or topic.schema_encoding not in READABLE["cdr"]:
            text = f"its messages are {topic.encoding or 'of no named encoding'}"
            text += f" ({topic.schema_encoding})" * bool(topic.schema_encoding)
            text += ", and Rune reads those of ROS 2 (cdr)"
            raise RecordingError(text)
        return _decoder(topic.schema_name, topic.schema_encoding, topic.schema)

    def decode(self, payload: bytes | memoryview) -> RosValue:
        """The message in a payload; arrays of numbers are views of it.

        Raises:
            RecordingError: The payload is no message of this type.
        """
        if len(payload) > MOST_PAYLOAD:
            text = f"a message of {len(payload)} bytes is longer than {MOST_PAYLOAD}"
            raise RecordingError(text)
        try:
            return RosValue(self.type, self._codec.decode(payload))
        except CodecError as error:
            text = f"a message does not fit {self.type.name}: {error.__cause__ or error}"
            raise RecordingError(text) from error


@functools.lru_cache(maxsize=512)
def _decoder(name: str, encoding: str, schema: bytes) -> RosDecoder:
    try:
        text = schema.decode()
    except UnicodeDecodeError as error:
        refusal = f"the definition of {name[:80]} is no text"
        raise RecordingError(refusal) from error
    return RosDecoder(ros_type(name, encoding, text))


def _format(kind: RosType) -> formats.Struct:
    return formats.Struct(tuple(_member(each) for each in kind.fields))


def _member(each: RosField) -> formats.Format:
    kind = each.kind
    if not isinstance(kind, str):
        inner: formats.Format = _format(kind)
    else:
        inner = formats.Primitive(NUMBERS.get(kind, "string"))
    if each.count is None:
        return inner
    return (
        formats.FixedArray(inner, (each.count,)) if each.count else formats.VariableArray(inner, ())
    )
