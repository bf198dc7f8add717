"""What a message is: its name, format, Python type, and how it travels.

A definition ties a format string to the frozen dataclass that holds its values; field names come
from the dataclass, layout on the wire from the format string alone.
"""

from __future__ import annotations

import dataclasses
import enum
import math
import operator
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
_FAULTS = (TypeError, ValueError, IndexError, KeyError, AttributeError)


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
            CodecError: An enum member has no such value, or the type refuses a value.
        """
        try:
            return typing.cast("T", self._record.build(values))
        except CodecError:
            raise
        except _FAULTS as error:
            text = f"these are no values of {self.name}: {error}"
            raise CodecError(text) from error

    def encode(self, value: T) -> list[Buffer]:
        """The payload of `value`, in pieces that the frame joins once.

        Raises:
            CodecError: The values do not fit the format.
        """
        try:
            values = self._record.values(value)
        except CodecError:
            raise
        except _FAULTS as error:
            text = f"this is no value of {self.name}: {error}"
            raise CodecError(text) from error
        return self._codec.encode(values)

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


_Converter = Callable[[Any], Any]


@dataclass(frozen=True, slots=True)
class _Record:
    """How one dataclass and the values of one struct turn into each other.

    Attributes:
        values: A dataclass's fields as the members of the struct.
        build: The dataclass of the members of the struct.
        fields: The names, for people.
    """

    values: Callable[[Any], Sequence[Any]]
    build: Callable[[Sequence[Any]], Any]
    fields: str

    @classmethod
    def of(cls, kind: Any, tree: formats.Struct, where: str) -> _Record:
        if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
            raise MessageFormatError(str(tree), 0, f"{where} needs a dataclass for a struct")
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
        names = [member.name for member in members]
        values, build = _taker_apart(kind, names, outward), _builder(kind, names, inward)
        return cls(values, build, ", ".join(shown))


def _taker_apart(
    kind: type[Any], names: Sequence[str], converters: Sequence[_Converter | None]
) -> Callable[[Any], Sequence[Any]]:
    """The function that turns a dataclass into the members of a struct, converted where needed."""
    convert = [(place, each) for place, each in enumerate(converters) if each is not None]
    # An attrgetter of one name returns the bare value, of none there is none.
    get = operator.attrgetter(*names) if len(names) > 1 else None

    def values(record: Any) -> Sequence[Any]:
        try:
            raw = get(record) if get else [getattr(record, name) for name in names]
        except AttributeError as error:
            text = f"{type(record).__name__} is not a {kind.__name__}: {error}"
            raise CodecError(text) from error
        if not convert:
            return typing.cast("Sequence[Any]", raw)
        converted = list(raw)
        for place, each in convert:
            converted[place] = each(converted[place])
        return converted

    return values


def _builder(
    kind: type[Any], names: Sequence[str], converters: Sequence[_Converter | None]
) -> Callable[[Sequence[Any]], Any]:
    """The function that turns the members of a struct into a dataclass, converted where needed.

    Generated, because that is the fastest. A frozen class pays dearly for each field it sets, so
    the value is made as an open twin of its class, with the same slots, and then becomes frozen.
    """
    variables = [f"value{place}" for place in range(len(names))]
    known: dict[str, Any] = {"kind": kind}
    arguments = []
    for variable, name, convert in zip(variables, names, converters, strict=True):
        known[f"convert_{variable}"] = convert
        given = variable if convert is None else f"convert_{variable}({variable})"
        arguments.append((name, given))
    lines = ["def build(values):", f"    [{', '.join(variables)}] = values"]
    twin = _open_twin(kind, names)
    if twin is None:
        keywords = ", ".join(f"{name}={given}" for name, given in arguments)
        lines.append(f"    return kind({keywords})")
    else:
        known |= {"new": object.__new__, "twin": twin}
        lines.append("    made = new(twin)")
        lines += [f"    made.{name} = {given}" for name, given in arguments]
        lines += ["    made.__class__ = kind", "    return made"]
    exec(compile("\n".join(lines), "<definition>", "exec"), known)
    build: Callable[[Sequence[Any]], Any] = known["build"]
    return build


def _open_twin(kind: type[Any], names: Sequence[str]) -> type[Any] | None:
    """A class whose objects can become `kind`, or None if `kind` does more than hold fields."""
    plain = kind.__bases__ == (object,) and tuple(getattr(kind, "__slots__", ())) == tuple(names)
    if not plain or not names or hasattr(kind, "__post_init__"):
        return None
    return type(kind.__name__, (), {"__slots__": tuple(names)})


def _converters(
    hint: Any, node: formats.Format, where: str
) -> tuple[_Converter | None, _Converter | None, str]:
    """How a field turns into a member's value and back, and its shown inner names."""
    if isinstance(node, formats.Struct):
        record = _Record.of(hint, node, where)
        return record.values, record.build, "{" + record.fields + "}"
    element = getattr(node, "element", None)
    if isinstance(element, formats.Struct):
        record = _Record.of(next(iter(typing.get_args(hint)), hint), element, where)
        return (
            lambda items: [record.values(item) for item in items],
            lambda items: tuple(record.build(item) for item in items),
            "[]{" + record.fields + "}",
        )
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return None, _enum_reader(hint, where), ""
    return None, None, ""


def _enum_reader(kind: type[enum.IntEnum], where: str) -> Callable[[Any], enum.IntEnum]:
    # A dict finds a member several times faster than a call of the enum.
    members = {member.value: member for member in kind}

    def read(value: int) -> enum.IntEnum:
        try:
            return members[value]
        except KeyError as error:
            text = f"{where}: {value} is none of {list(members)}"
            raise CodecError(text) from error

    return read
