"""What a message is: its name, format, Python type, and how it travels.

A definition ties a format string to the frozen dataclass that holds its values; field names come
from the dataclass, layout on the wire from the format string alone.
"""

from __future__ import annotations

import dataclasses
import enum
import math
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from hub.errors import CodecError, MessageFormatError
from hub.ipc import codec
from hub.ipc import format as formats
from hub.ipc.codegen import Buffer

T = TypeVar("T")

MAX_NAME_LENGTH = 64


class Keep(enum.Enum):
    """What a slow receiver keeps: the newest message of a stream, or every event."""

    NEWEST = "newest"
    ALL = "all"


class Plane(enum.Enum):
    """The pair of broadcast sockets a message uses: one kind never queues behind another."""

    STATE = "state"
    COMMAND = "command"


@dataclass(frozen=True, kw_only=True, eq=False)
class MessageDefinition(Generic[T]):
    """A message that modules exchange through central.

    Attributes:
        name: Name at central; letters, digits and underscores.
        format: CMU IPC format string of the payload.
        type: Frozen dataclass whose fields, in order, are the members of the format.
        keep: Whether receivers keep the newest or all.
        plane: Broadcast sockets it travels on.
        rate_hz: Nominal rate of a stream [Hz]; 0 for what is sent on demand.
        lifespan_s: Age beyond which a receiver drops it [s].
        ros_type: ROS 2 type with the same layout, if there is one.
    """

    name: str
    format: str
    type: type[T]
    keep: Keep = Keep.NEWEST
    plane: Plane = Plane.STATE
    rate_hz: float = 0.0
    lifespan_s: float = math.inf
    ros_type: str = ""
    tree: formats.Format = field(init=False, repr=False)
    _codec: codec.Codec = field(init=False, repr=False)
    _record: _Record = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_name(self.name)
        tree = formats.parse(self.format)
        if not isinstance(tree, formats.Struct):
            raise MessageFormatError(self.format, 0, "a typed message is a struct: {...}")
        object.__setattr__(self, "tree", tree)
        object.__setattr__(self, "_codec", codec.compiled(self.format))
        object.__setattr__(self, "_record", _Record.of(self.type, tree, self.name))

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
        """Field names in the format's nesting, for people: "x, y, stamp{sec, nanosec}"."""
        return self._record.fields

    def build(self, values: Sequence[Any]) -> T:
        """The value whose members are `values`, structs as sequences.

        Raises:
            CodecError: An enum member has no such value.
        """
        return typing.cast("T", self._record.build(values))

    def encode(self, value: T) -> list[Buffer]:
        """The payload of `value`, in pieces that the frame joins once.

        Raises:
            CodecError: The values do not fit the format.
        """
        return self._codec.encode(self._record.values(value))

    def decode(self, payload: Buffer) -> T:
        """The value in `payload`; arrays are read-only views of it.

        Raises:
            CodecError: The bytes are no message of this definition.
        """
        return self.build(self._codec.decode(payload))


def check_name(name: str) -> None:
    """Refuse names that could not be told apart on the wire.

    Raises:
        MessageFormatError: The name is empty, too long, or has other characters than letters,
            digits and underscores.
    """
    if not (name.isascii() and name.isidentifier() and len(name) <= MAX_NAME_LENGTH):
        reason = f"a message name is 1 to {MAX_NAME_LENGTH} letters, digits and underscores"
        raise MessageFormatError(name, 0, reason)


@dataclass(frozen=True, slots=True)
class _Record:
    """How one dataclass and the values of one struct turn into each other."""

    kind: type[Any]
    names: tuple[str, ...]
    to_value: tuple[Callable[[Any], Any] | None, ...]
    to_field: tuple[Callable[[Any], Any] | None, ...]
    fields: str

    @classmethod
    def of(cls, kind: type[Any], tree: formats.Struct, where: str) -> _Record:
        members = dataclasses.fields(kind)
        if len(members) != len(tree.members):
            reason = f"{where}: {kind.__name__} has {len(members)} fields"
            raise MessageFormatError(str(tree), 0, f"{reason}, the format {len(tree.members)}")
        hints = typing.get_type_hints(kind)
        outward, inward, shown = [], [], []
        for member, node in zip(members, tree.members, strict=True):
            out, back, inner = _converters(hints[member.name], node, f"{where}.{member.name}")
            outward.append(out)
            inward.append(back)
            shown.append(member.name + inner)
        names = tuple(member.name for member in members)
        return cls(kind, names, tuple(outward), tuple(inward), ", ".join(shown))

    def values(self, record: Any) -> list[Any]:
        try:
            raw = [getattr(record, name) for name in self.names]
        except AttributeError as error:
            text = f"{type(record).__name__} is not a {self.kind.__name__}: {error}"
            raise CodecError(text) from error
        return [
            value if convert is None else convert(value)
            for convert, value in zip(self.to_value, raw, strict=True)
        ]

    def build(self, values: Sequence[Any]) -> Any:
        return self.kind(
            **{
                name: value if convert is None else convert(value)
                for name, convert, value in zip(self.names, self.to_field, values, strict=True)
            }
        )


def _converters(
    hint: Any, node: formats.Format, where: str
) -> tuple[Callable[[Any], Any] | None, Callable[[Any], Any] | None, str]:
    """How a field turns into a member's value and back, and its shown inner names."""
    if isinstance(node, formats.Struct):
        record = _Record.of(hint, node, where)
        return record.values, record.build, "{" + record.fields + "}"
    element = getattr(node, "element", None)
    if isinstance(element, formats.Struct):
        record = _Record.of(typing.get_args(hint)[0], element, where)
        return (
            lambda items: [record.values(item) for item in items],
            lambda items: tuple(record.build(item) for item in items),
            "[]{" + record.fields + "}",
        )
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return int, _enum_reader(hint, where), ""
    return None, None, ""


def _enum_reader(kind: type[enum.IntEnum], where: str) -> Callable[[Any], enum.IntEnum]:
    def read(value: int) -> enum.IntEnum:
        try:
            return kind(value)
        except ValueError as error:
            text = f"{where}: {value} is none of {[member.value for member in kind]}"
            raise CodecError(text) from error

    return read
