"""Decodes messages by the definition in their file.

| encoding | definition | by |
| --- | --- | --- |
| cdr | ros2msg, ros2idl, none | a format of Rune, whose codec makes arrays without a copy |
| ros1 | ros1msg, none | `ros1` |
| protobuf | protobuf | `protobuf` |
| json | jsonschema, none | `plain_json`; the schema is not needed |
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Mapping
from typing import Final, Protocol

from hub.errors import CodecError, RosMessageError
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codec import Codec
from hub.ros import foxglove
from hub.ros.known_types import known_texts
from hub.ros.plain_json import json_values
from hub.ros.protobuf import ProtobufReader
from hub.ros.ros1 import ros1_values
from hub.ros.schema import NUMBERS, RosField, RosType, full_name, ros_type, ros_version
from hub.ros.values import NamedValue, RosValue, TypedValue

READABLE: Final[Mapping[str, tuple[str, ...]]] = {
    "cdr": ("ros2msg", "ros2idl", ""),
    "ros1": ("ros1msg", ""),
    "protobuf": ("protobuf",),
    "json": ("jsonschema", ""),
}
"""Encodings of payloads that are decoded, and those of their definitions."""
MOST_PAYLOAD: Final = 1 << 28
"""Longest message that is decoded [bytes]."""

_MOST_KEPT: Final = 10_000
"""Most fields of all types whose decoders are kept; a decoder has some 20 kB for a field."""
_BYTES_OF_FIELD: Final = 20
"""Bytes of a definition that count as a field, where its fields are not known."""

Payload = bytes | memoryview


class DescribedTopic(Protocol):
    """A topic as recordings and bridges describe it."""

    @property
    def schema_name(self) -> str:
        """The name of its type."""

    @property
    def encoding(self) -> str:
        """The encoding of its messages, see `READABLE`."""

    @property
    def schema_encoding(self) -> str:
        """The encoding of its definition."""

    @property
    def schema(self) -> bytes:
        """Its definition; empty: it is known by its name."""


class RosDecoder:
    """Decodes the messages of one topic.

    Attributes:
        name: The name of their type.
        type: Their type; None: only the messages themselves have it.
        fields: Number of fields of their type, with those of all types within it; 0: not known.
    """

    def __init__(
        self, name: str, read: Callable[[Payload], RosValue], kind: RosType | None = None
    ) -> None:
        self.type = kind
        self.fields = 0 if kind is None else kind.all_fields
        self.name = name
        self._read = read

    @classmethod
    def of(cls, topic: DescribedTopic) -> RosDecoder:
        """The decoder of a topic.

        Raises:
            RosMessageError: Its messages cannot be read, and why.
        """
        if topic.schema_encoding not in READABLE.get(topic.encoding, ()):
            text = f"its messages are {topic.encoding or 'of no named encoding'}"
            text += f" ({topic.schema_encoding})" * bool(topic.schema_encoding)
            text += f", and Rune reads {', '.join(READABLE)}"
            raise RosMessageError(text)
        return _KEPT.of((topic.schema_name, topic.encoding, topic.schema_encoding, topic.schema))

    def decode(self, payload: Payload) -> RosValue:
        """The message in a payload; arrays of numbers are views of it.

        Raises:
            RosMessageError: The payload is no message of this type.
        """
        if len(payload) > MOST_PAYLOAD:
            text = f"a message of {len(payload)} bytes is longer than {MOST_PAYLOAD}"
            raise RosMessageError(text)
        try:
            return self._read(payload)
        except (CodecError, RosMessageError) as error:
            reason = error.__cause__ if isinstance(error, CodecError) else None
            text = f"a message does not fit {self.name}: {reason or error}"
            raise RosMessageError(text) from error

    def as_ros(self, payload: Payload) -> RosValue:
        """The message in a payload as one of ROS, where it is one of foxglove.

        Raises:
            RosMessageError: The payload is no message of this type.
        """
        return foxglove.as_ros(self.name, self.decode(payload))


_Description = tuple[str, str, str, bytes]


class _KeptDecoders:
    """Decoders that may be used again, within a bound; threads may share them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._found: dict[_Description, tuple[RosDecoder, int]] = {}
        self._fields = 0

    def of(self, described: _Description) -> RosDecoder:
        """The decoder of a type.

        Raises:
            RosMessageError: There is none.
        """
        with self._lock:
            known = self._found.pop(described, None)
            if known is not None:
                self._found[described] = known  # it is the newest now
                return known[0]
        made = _decoder(*described)
        fields = max(made.fields, len(described[3]) // _BYTES_OF_FIELD, 1)
        with self._lock:
            self._fields += fields - self._found.pop(described, (made, 0))[1]
            self._found[described] = made, fields
            while self._fields > _MOST_KEPT:
                self._fields -= self._found.pop(next(iter(self._found)))[1]
        return made


_KEPT: Final = _KeptDecoders()


def _decoder(name: str, encoding: str, schema_encoding: str, schema: bytes) -> RosDecoder:
    if encoding == "json":
        return RosDecoder(name, lambda payload: NamedValue(name, json_values(payload)))
    if encoding == "protobuf":
        reader = ProtobufReader(name, schema)
        return RosDecoder(name, lambda payload: NamedValue(name, reader.values(payload)))
    try:
        text = schema.decode()
    except UnicodeDecodeError as error:
        refusal = f"the definition of {name[:80]} is no text"
        raise RosMessageError(refusal) from error
    if text or schema_encoding == "ros2idl":
        return _typed(ros_type(name, schema_encoding, text), encoding)
    language = "ros1msg" if encoding == "ros1" else "ros2msg"
    known = known_texts(ros_version(encoding)).get(full_name(name), ("",))
    found = [_typed(ros_type(name, language, each), encoding) for each in known]
    return _of_any_distribution(found) if len(found) > 1 else found[0]


def _typed(kind: RosType, encoding: str) -> RosDecoder:
    """The decoder of a type, for the encoding "cdr" or "ros1"."""
    if encoding == "ros1":
        return RosDecoder(
            kind.name, lambda payload: TypedValue(kind, ros1_values(kind, payload)), kind
        )
    codec = Codec(format_of(kind))
    return RosDecoder(kind.name, lambda payload: TypedValue(kind, codec.decode(payload)), kind)


def _of_any_distribution(decoders: list[RosDecoder]) -> RosDecoder:
    """The decoder of a type whose fields differ between distributions: a payload fits one only."""
    first, order = decoders[0], tuple(decoders)

    def read(payload: Payload) -> RosValue:
        nonlocal order
        for each in order:
            with contextlib.suppress(RosMessageError):
                found = each.decode(payload)
                if each is not order[0]:  # the robot has this one; threads see either order
                    order = (each, *(other for other in decoders if other is not each))
                return found
        return first.decode(payload)

    return RosDecoder(first.name, read, first.type)


def format_of(kind: RosType) -> formats.Struct:
    """The format of a type's payload as CDR."""
    return formats.Struct(tuple(_member(each) for each in kind.fields))


def _member(each: RosField) -> formats.Format:
    kind = each.kind
    if not isinstance(kind, str):
        inner: formats.Format = format_of(kind)
    else:
        inner = formats.Primitive(NUMBERS.get(kind, "string"))
    if each.count is None:
        return inner
    return (
        formats.FixedArray(inner, (each.count,)) if each.count else formats.VariableArray(inner, ())
    )
