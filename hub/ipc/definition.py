"""The definition of a message: its name, Python type, format, and transport.

The frozen dataclass that holds a message's values declares each field once: name, type, range and
unit. The format comes from it by the rules of `hub.ipc.formats.wire_types`, at the first use of the
definition: a program imports many definitions and uses few of them.
"""

from __future__ import annotations

import enum
import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, TypeVar

from hub.errors import CodecError, MessageFormatError
from hub.ipc.formats import codec, wire_types
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import Buffer
from hub.ipc.formats.dataclass_codec import FAULTS, DataclassCodec
from hub.ipc.formats.ranges import Note, no_note
from hub.values import dataclass

T = TypeVar("T")

MAX_NAME_LENGTH = 64


class Keep(enum.Enum):
    """The messages that a slow receiver keeps: the newest of a stream, or every event."""

    NEWEST = "newest"
    ALL = "all"


class Plane(enum.Enum):
    """The pair of broadcast sockets a message uses: one kind never queues behind another."""

    STATE = "state"
    COMMAND = "command"
    PICTURE = "picture"

    __hash__ = object.__hash__  # fast: Enum's own hash is written in Python


@dataclass(frozen=True, kw_only=True, eq=False)
class MessageDefinition(Generic[T]):
    """A message that modules exchange through central.

    Attributes:
        name: Name at central; letters, digits and underscores.
        type: Frozen dataclass whose fields, in order, are the members of the format.
        format: CMU IPC format string of the payload; empty: it follows from the type. Give it for
            a type without declared fields, such as one from a listing of central.
        keep: Whether receivers keep the newest or all.
        plane: Its broadcast sockets.
        rate_hz: Nominal rate of a stream [Hz]; 0: sent on demand.
        lifespan_s: Age beyond which a receiver drops it [s].
        unreadable: Value of an unreadable payload; None: the payload is dropped. A message
        with this value has no order: every frame counts, even with a wrong header.
    """

    name: str
    type: type[T]
    format: str = ""
    keep: Keep = Keep.NEWEST
    plane: Plane = Plane.STATE
    rate_hz: float = 0.0
    lifespan_s: float = math.inf
    unreadable: T | None = None

    def __post_init__(self) -> None:
        check_name(self.name)
        if self.format:
            self.prepare()

    def prepare(self) -> None:
        """Read the type and the format now, not at first use.

        Raises:
            MessageFormatError: They do not match.
        """
        self.record  # noqa: B018 - the cached property reads them

    @functools.cached_property
    def wire_format(self) -> str:
        """The format string of the payload, given or from the type.

        Raises:
            MessageFormatError: The type of a field has no format.
        """
        return self.format or wire_types.format_of(self.type)

    @functools.cached_property
    def tree(self) -> formats.Struct:
        """The format.

        Raises:
            MessageFormatError: It is no format of a struct.
        """
        tree = self._codec.tree
        if not isinstance(tree, formats.Struct):
            raise MessageFormatError(self.wire_format, 0, "a typed message is a struct: {...}")
        return tree

    @functools.cached_property
    def record(self) -> DataclassCodec:
        """The mapping between the dataclass and the members of the format.

        Raises:
            MessageFormatError: They do not match.
        """
        strict = self.plane is Plane.COMMAND
        return DataclassCodec.of(self.type, self.tree, self.name, strict=strict)

    @property
    def fingerprint(self) -> int:
        """Identity of the format on the wire: equal for equal formats."""
        return self._codec.fingerprint

    @property
    def fixed_length(self) -> bool:
        """Whether every message of it has the same length."""
        return self._codec.fixed_length

    @property
    def fields(self) -> str:
        """Field names in the format's nesting, for people: "x, stamp{sec, nanosec}".

        "[]" stands before the inner names of an array, "*" before those of a pointer.
        """
        return self.record.fields

    @property
    def flat_letters(self) -> str | None:
        """The whole body as `struct` letters if the format is flat; see `Codec.flat_letters`."""
        return self._codec.flat_letters

    @functools.cached_property
    def flat_values(self) -> Callable[[T], tuple[Any, ...]]:
        """The function from a value to all its numbers, in wire order, if the format is flat.

        The function raises CodecError for a value of another kind. If a `struct` of
        `flat_letters` cannot pack the numbers, `encode` raises the reason.

        Raises:
            CodecError: The format is not flat.
        """
        self._refuse_unless_flat()
        return self.record.flat_values()

    @functools.cached_property
    def receive_flat(self) -> Callable[..., T]:
        """The function from all numbers, in wire order, to the value, if the format is flat.

        Like `decode`, it bounds the numbers and takes a `Note`.

        Raises:
            CodecError: The format is not flat.
        """
        self._refuse_unless_flat()
        return self.record.flat_receiver()

    def build(self, values: Sequence[Any]) -> T:
        """The value with the members `values`, structs as sequences; without bounds.

        Raises:
            CodecError: An enum member has no such value, or the type refuses a value.
        """
        value: T = self.record.build(values)
        return value

    def encode(self, value: T | Mapping[str, Any]) -> list[Buffer]:
        """The payload of `value`, in pieces; the frame joins them.

        Args:
            value: The dataclass, or a mapping with the names of all its fields, at every level.

        Raises:
            CodecError: The values do not fit the format.
        """
        try:
            values = self.record.values(value)
        except CodecError:
            raise
        except FAULTS as error:
            text = f"this is no value of {self.name}: {error}"
            raise CodecError(text) from error
        return self._codec.encode(values)

    def decode(self, payload: Buffer, note: Note = no_note) -> T:
        """The value in `payload`, within the declared ranges; arrays are read-only views.

        Every received value is made here; `hub.ipc.formats.ranges` bounds its fields.
        A linked list comes as its first node and is nested as deep as it is long, up to
        `grammar.MAX_NODES`: follow it in a loop, because its repr and == are recursive.

        Args:
            payload: The bytes.
            note: Gets a sentence on each changed value.

        Raises:
            RangeError: A value is outside its field's range and cannot be replaced.
            CodecError: The bytes are no message of this definition.
        """
        try:
            value: T = self._receive(self._codec.decode(payload), note)
        except CodecError as error:
            if self.unreadable is None:
                raise
            note(f"{self.name} cannot be read, and counts all the same: {error}")
            return self.unreadable
        return value

    @functools.cached_property
    def _codec(self) -> codec.Codec:
        return codec.compiled(self.wire_format)

    @functools.cached_property
    def _receive(self) -> Callable[[Any, Note], T]:
        return self.record.receive

    def _refuse_unless_flat(self) -> None:
        if self.flat_letters is None:
            text = f"{self.name} is not of a flat format: {self.wire_format[:80]}"
            raise CodecError(text)


def check_name(name: str) -> None:
    """Refuse names that are ambiguous on the wire.

    Raises:
        MessageFormatError: The name is empty, too long, or has other characters than letters,
            digits and underscores.
    """
    if not (name.isascii() and name.isidentifier() and len(name) <= MAX_NAME_LENGTH):
        reason = f"a message name is 1 to {MAX_NAME_LENGTH} letters, digits and underscores"
        raise MessageFormatError(name, 0, reason)
