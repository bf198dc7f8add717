"""How a dataclass and the plain values that a codec knows turn into each other.

The functions that do it are generated once for each message, because that is the fastest.
"""

from __future__ import annotations

import dataclasses
import enum
import operator
import typing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from hub.errors import CodecError, MessageFormatError
from hub.ipc import format as formats

FAULTS = (TypeError, ValueError, IndexError, KeyError, AttributeError)
"""What a value of the wrong kind may raise on its way."""

_Converter = Callable[[Any], Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One field of a dataclass and the member of a struct that it stands for.

    Attributes:
        name: The field.
        struct: The record of a member that is a struct itself.
        outward: What turns the field's value into the member's, if anything has to.
        inward: The way back.
        shown: Its inner names, for people.
    """

    name: str
    struct: Record | None = None
    outward: _Converter | None = None
    inward: _Converter | None = None
    shown: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """How one dataclass and the values of one struct turn into each other.

    Attributes:
        kind: The dataclass.
        members: Its fields, in order.
        values: A dataclass's fields as the members of the struct.
        build: The dataclass of the members of the struct.
    """

    kind: type[Any]
    members: tuple[Member, ...]
    values: Callable[[Any], Sequence[Any]]
    build: Callable[[Sequence[Any]], Any]

    @classmethod
    def of(cls, kind: Any, tree: formats.Struct, where: str) -> Record:
        """The record of a dataclass and a struct.

        Raises:
            MessageFormatError: They do not fit each other.
        """
        if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
            raise MessageFormatError(str(tree), 0, f"{where} needs a dataclass for a struct")
        fields = dataclasses.fields(kind)
        if len(fields) != len(tree.members):
            reason = f"{where}: {kind.__name__} has {len(fields)} fields"
            raise MessageFormatError(str(tree), 0, f"{reason}, the format {len(tree.members)}")
        hints = typing.get_type_hints(kind)
        members = tuple(
            _member(field.name, hints[field.name], node, f"{where}.{field.name}")
            for field, node in zip(fields, tree.members, strict=True)
        )
        build = _Builder(flat=False).function(kind, members)
        return cls(kind=kind, members=members, values=_taker_apart(kind, members), build=build)

    @property
    def fields(self) -> str:
        """The names, for people."""
        return ", ".join(member.name + member.shown for member in self.members)

    def flat_values(self) -> Callable[[Any], tuple[Any, ...]]:
        """The function from a dataclass to the numbers in it and in its inner ones, in order."""
        paths = list(_paths(self.members))
        if not paths:
            return lambda _: ()
        get = operator.attrgetter(*paths)
        # An attrgetter of one name returns the bare value.
        return get if len(paths) > 1 else lambda value: (get(value),)

    def flat_builder(self) -> Callable[[tuple[Any, ...]], Any]:
        """The function from those numbers to the dataclass."""
        return _Builder(flat=True).function(self.kind, self.members)


def _paths(members: Sequence[Member]) -> Iterator[str]:
    for member in members:
        if member.struct is None:
            yield member.name
        else:
            yield from (f"{member.name}.{path}" for path in _paths(member.struct.members))


def _taker_apart(kind: type[Any], members: Sequence[Member]) -> Callable[[Any], Sequence[Any]]:
    """The function that turns a dataclass into the members of a struct, converted where needed."""
    names = [member.name for member in members]
    convert = [(place, member.outward) for place, member in enumerate(members) if member.outward]
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


class _Builder:
    """Generates the function that turns the members of a struct into a dataclass.

    A frozen class pays dearly for each field it sets, so a value is made as an open twin of its
    class, with the same slots, and then becomes frozen.
    """

    def __init__(self, *, flat: bool) -> None:
        self.flat = flat
        self.lines: list[str] = []
        self.known: dict[str, Any] = {"new": object.__new__, "refuse": _refuse, "faults": FAULTS}

    def function(self, kind: type[Any], members: Sequence[Member]) -> Callable[[Any], Any]:
        pattern, made = self.struct(kind, members)
        body = [f"{pattern} = values" if not self.flat else f"[{pattern}] = values", *self.lines]
        lines = ["def build(values):", "    try:", *(f"        {line}" for line in body)]
        lines += ["    except faults as error:", f"        refuse({kind.__name__!r}, error)"]
        lines.append(f"    return {made}")
        exec(compile("\n".join(lines), "<records>", "exec"), self.known)
        build: Callable[[Any], Any] = self.known["build"]
        return build

    def constant(self, value: Any) -> str:
        name = f"constant{len(self.known)}"
        self.known[name] = value
        return name

    def variable(self) -> str:
        return self.constant(None).replace("constant", "value")

    def struct(self, kind: type[Any], members: Sequence[Member]) -> tuple[str, str]:
        """Generate the making of one dataclass.

        Returns:
            The pattern that takes its values apart, the variable that holds it afterwards.
        """
        patterns, arguments = [], []
        for member in members:
            if member.struct is not None:
                pattern, given = self.struct(member.struct.kind, member.struct.members)
            else:
                pattern = given = self.variable()
                if member.inward is not None:
                    given = f"{self.constant(member.inward)}({given})"
            patterns.append(pattern)
            arguments.append((member.name, given))
        made, twin = self.variable(), _open_twin(kind, [member.name for member in members])
        if twin is None:
            keywords = ", ".join(f"{name}={given}" for name, given in arguments)
            self.lines.append(f"{made} = {self.constant(kind)}({keywords})")
        else:
            self.lines.append(f"{made} = new({self.constant(twin)})")
            self.lines += [f"{made}.{name} = {given}" for name, given in arguments]
            self.lines.append(f"{made}.__class__ = {self.constant(kind)}")
        if self.flat:
            return ", ".join(filter(None, patterns)), made
        return f"[{', '.join(patterns)}]", made


def _refuse(kind: str, error: Exception) -> typing.NoReturn:
    if isinstance(error, CodecError):
        raise error
    text = f"these are no values of {kind}: {error}"
    raise CodecError(text) from error


def _open_twin(kind: type[Any], names: Sequence[str]) -> type[Any] | None:
    """A class whose objects can become `kind`, or None if `kind` does more than hold fields."""
    plain = kind.__bases__ == (object,) and tuple(getattr(kind, "__slots__", ())) == tuple(names)
    if not plain or not names or hasattr(kind, "__post_init__"):
        return None
    return type(kind.__name__, (), {"__slots__": tuple(names)})


def _member(name: str, hint: Any, node: formats.Format, where: str) -> Member:
    if isinstance(node, formats.Struct):
        record = Record.of(hint, node, where)
        shown = "{" + record.fields + "}"
        return Member(name=name, struct=record, outward=record.values, shown=shown)
    element = getattr(node, "element", None)
    if isinstance(element, formats.Struct):
        record = Record.of(next(iter(typing.get_args(hint)), hint), element, where)
        return Member(
            name=name,
            outward=lambda items: [record.values(item) for item in items],
            inward=lambda items: tuple(record.build(item) for item in items),
            shown="[]{" + record.fields + "}",
        )
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return Member(name=name, inward=_enum_reader(hint, where))
    return Member(name=name)


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
