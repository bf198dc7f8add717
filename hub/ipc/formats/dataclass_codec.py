"""Conversion between a dataclass and the plain values of a codec.

A mapping with the names of the fields may replace the dataclass, at any depth. The functions are
generated once for each message, because that is the fastest. That happens at first use, because no
program uses all its messages.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hub.errors import CodecError, MessageFormatError
from hub.ipc.formats import grammar as formats
from hub.ipc.formats import ranges, wire_types
from hub.ipc.formats.ranges import Note
from hub.nearest import did_you_mean
from hub.values import dataclass

FAULTS = (TypeError, ValueError, IndexError, KeyError, AttributeError)
"""Exceptions that a value of the wrong kind may raise."""

_Converter = Callable[[Any], Any]
_Reader = Callable[[Any, Note | None], Any]
"""From a codec's value to a field's value; without a Note nothing is checked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One field of a dataclass and its member of a struct.

    Attributes:
        name: The field.
        record: The record of the member's struct, or of its elements' struct.
        inline: Whether it is that struct itself, not an array, a pointer or a list.
        outward: Converts the field's value to the member's; None: they are equal.
        inward: Converts back.
        checks: Checks of the codec's value.
        shown: Its inner names, for people: "[]" for each array, "*" for each pointer around them.
        counts: The field whose elements the member counts; empty: it is a field itself.
    """

    name: str
    record: DataclassCodec | None = None
    inline: bool = False
    outward: _Converter | None = None
    inward: _Reader | None = None
    checks: tuple[ranges.Check, ...] = ()
    shown: str = ""
    counts: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class DataclassCodec:
    """Conversion between one dataclass and the values of one struct.

    Attributes:
        kind: The dataclass.
        members: The struct's members in order: the fields, and the numbers of counted arrays.
        adapt: From anything else with those fields, such as a mapping, to an object with them.
        next_place: Index of the next node in a linked list's node; None: it is no list.
    """

    kind: type[Any]
    members: tuple[Member, ...]
    adapt: _Converter
    next_place: int | None

    @classmethod
    def of(
        cls, kind: Any, tree: formats.Struct, where: str, *, strict: bool = False
    ) -> DataclassCodec:
        """The record of a dataclass and a struct.

        Args:
            kind: The dataclass.
            tree: The struct.
            where: Their message or field, for people.
            strict: Whether a number outside its range always refuses the message.

        Raises:
            MessageFormatError: They do not match.
        """
        if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
            raise MessageFormatError(str(tree), 0, f"{where} needs a dataclass for a struct")
        wanted = wire_types.members(kind)
        if len(wanted) != len(tree.members):
            reason = f"{where}: {kind.__name__} has {len(wanted)} fields"
            raise MessageFormatError(str(tree), 0, f"{reason}, the format {len(tree.members)}")
        members = tuple(
            Member(name=each.name, counts=each.counts)
            if each.counts
            else _member(each.name, each.hint, node, f"{where}.{each.name}", strict=strict)
            for each, node in zip(wanted, tree.members, strict=True)
        )
        adapt = _adapter(kind, members, where)
        return cls(kind=kind, members=members, adapt=adapt, next_place=tree.next_place)

    @functools.cached_property
    def values(self) -> _Converter:
        """The function from the dataclass, or a mapping, to the members of the struct.

        For a linked list: from the first node to its members, nested like its dataclasses.
        """
        values = _FieldReader(flat=False).function(self.kind, self.members, self.adapt)
        return values if self.next_place is None else _list_flattener(values, self.next_place)

    @functools.cached_property
    def build(self) -> Callable[..., Any]:
        """The function back to the dataclass, for trusted values."""
        return self._builder(checked=False)

    @functools.cached_property
    def receive(self) -> Callable[..., Any]:
        """The function back to the dataclass, for received values: it checks each field.

        The function raises RangeError for a value that it cannot replace, and notes each change.
        """
        return self._builder(checked=True)

    def _builder(self, *, checked: bool) -> Callable[..., Any]:
        build = _Builder(flat=False, checked=checked).function(self.kind, self.members)
        if self.next_place is None:
            return build
        return _list_builder(build, self.next_place, self.kind.__name__)

    @property
    def fields(self) -> str:
        """The field names, for people."""
        return ", ".join(member.name + member.shown for member in self.members)

    def flat_values(self) -> Callable[[Any], tuple[Any, ...]]:
        """The function from a dataclass to its numbers, inner ones too, in order."""
        return _FieldReader(flat=True).function(self.kind, self.members, self.adapt)

    def flat_receiver(self) -> Callable[..., Any]:
        """The function from those numbers to the dataclass, with the checks of `receive`."""
        return _Builder(flat=True, checked=True).function(self.kind, self.members)


def _adapter(kind: type[Any], members: Sequence[Member], where: str) -> _Converter:
    """The function that checks an object of another type for the fields of `kind`."""
    names = [member.name for member in members if not member.counts]
    counts = {member.name: member.counts for member in members if member.counts}

    def adapt(value: Any) -> Any:
        if isinstance(value, Mapping):
            value = _without_counts(value, counts, where)
            _check_names(value, names, where)
            return types.SimpleNamespace(**{name: value[name] for name in names})
        missing = [name for name in names if not hasattr(value, name)]
        if missing:
            text = (
                f"{where}: {type(value).__name__} is not a {kind.__name__}, it has no {missing[0]}"
            )
            raise CodecError(text)
        return value

    return adapt


def _without_counts(
    value: Mapping[Any, Any], counts: Mapping[str, str], where: str
) -> Mapping[Any, Any]:
    """The mapping without the numbers of elements; given ones have to be right."""
    for name, array in counts.items():
        if name in value and value[name] != len(value.get(array, ())):
            size = len(value.get(array, ()))
            text = f"{where}.{name} is {value[name]!r:.40}, but {array} has {size} element"
            raise CodecError(text + "s" * (size != 1) + "; leave it out")
    return {name: each for name, each in value.items() if name not in counts}


def _check_names(value: Mapping[Any, Any], names: Sequence[str], where: str) -> None:
    missing = [name for name in names if name not in value]
    for key in value:
        if key not in names:
            hint = did_you_mean(key, missing or names) or f"; it has {', '.join(names)}"
            text = f"{where} has no field {str(key)[:40]!r}{hint}"
            raise CodecError(text)
    if missing:
        text = f"{where} needs a value for {', '.join(missing)}"
        raise CodecError(text)


class _Generator:
    """Lines and constants of a function; `flat`: values of structs are not nested."""

    def __init__(self, *, flat: bool) -> None:
        self.flat = flat
        self.lines: list[str] = []
        self.known: dict[str, Any] = {}

    def constant(self, value: Any) -> str:
        name = f"constant{len(self.known)}"
        self.known[name] = value
        return name

    def variable(self) -> str:
        return self.constant(None).replace("constant", "value")

    def finished(self, head: str) -> Callable[..., Any]:
        exec(compile("\n    ".join([head, *self.lines]), "<records>", "exec"), self.known)
        function: Callable[..., Any] = self.known["generated"]
        return function


class _FieldReader(_Generator):
    """Generates the function that turns a dataclass into the members of a struct."""

    def function(
        self, kind: type[Any], members: Sequence[Member], adapt: _Converter
    ) -> Callable[[Any], tuple[Any, ...]]:
        values = self.struct(kind, members, adapt, "record")
        self.lines.append(f"return ({values})")
        return self.finished("def generated(record):")

    def struct(
        self, kind: type[Any], members: Sequence[Member], adapt: _Converter, source: str
    ) -> str:
        """Generate the reading of one dataclass; returns its values, each with a comma behind."""
        own = self.variable()
        self.lines.append(f"{own} = {source}")
        self.lines.append(f"if {own}.__class__ is not {self.constant(kind)}:")
        self.lines.append(f"    {own} = {self.constant(adapt)}({own})")
        values = ""
        for member in members:
            source = f"{own}.{member.name}"
            inner = member.record
            if inner is not None and member.inline:
                nested = self.struct(inner.kind, inner.members, inner.adapt, source)
                values += nested if self.flat else f"({nested}), "
            elif member.counts:
                values += f"len({own}.{member.counts}), "
            elif member.outward is not None:
                values += f"{self.constant(member.outward)}({source}), "
            else:
                values += f"{source}, "
        return values


def _list_flattener(
    members_of: Callable[[Any], Sequence[Any]], next_place: int
) -> Callable[[Any], Sequence[Any] | None]:
    """The function from the first node of a list to nested members, without recursion."""

    def values(node: Any) -> Sequence[Any] | None:
        nodes: list[Sequence[Any]] = []
        while node is not None:
            _refuse_longer(nodes)
            nodes.append(members_of(node))
            node = nodes[-1][next_place]
        first: Sequence[Any] | None = None
        for members in reversed(nodes):
            first = (*members[:next_place], first, *members[next_place + 1 :])
        return first

    return values


def _list_builder(build_node: _Reader, next_place: int, kind: str) -> Callable[..., Any]:
    """The function from nested members to the first node of a list."""

    def build(members: Sequence[Any] | None, note: Note | None = None) -> Any:
        nodes: list[Sequence[Any]] = []
        first: Any = None
        try:
            while members is not None:
                _refuse_longer(nodes)
                nodes.append(members)
                members = members[next_place]
            for node in reversed(nodes):
                first = build_node((*node[:next_place], first, *node[next_place + 1 :]), note)
        except FAULTS as error:
            _refuse(kind, error)
        if first is None:
            text = f"None instead of the first {kind} of a list"
            raise CodecError(text)
        return first

    return build


def _refuse_longer(nodes: Sequence[Any]) -> None:
    if len(nodes) == formats.MAX_NODES:
        text = f"a list longer than {formats.MAX_NODES} nodes, or one that runs in a circle"
        raise CodecError(text)


class _Builder(_Generator):
    """Generates the function that turns the members of a struct into a dataclass.

    A frozen class sets fields slowly. So a value starts as an open twin of its class, with the same
    slots, and then becomes frozen.
    """

    def __init__(self, *, flat: bool, checked: bool) -> None:
        super().__init__(flat=flat)
        self.checked = checked

    def function(self, kind: type[Any], members: Sequence[Member]) -> Callable[..., Any]:
        self.known |= {"new": object.__new__, "refuse": _refuse, "faults": FAULTS}
        self.known |= ranges.known()
        self.known["no_note"] = ranges.no_note if self.checked else None
        pattern, made = self.struct(kind, members)
        pattern = f"[{pattern}]" if self.flat else pattern
        body = [f"    {line}" for line in (f"{pattern} = values", *self.lines)]
        self.lines = ["try:", *body, "except faults as error:"]
        self.lines += [f"    refuse({kind.__name__!r}, error)", f"return {made}"]
        return self.finished("def generated(values, note=no_note):")

    def struct(self, kind: type[Any], members: Sequence[Member]) -> tuple[str, str]:
        """Generate the construction of one dataclass.

        Returns:
            The pattern that unpacks its values, and the variable that holds it.
        """
        patterns, arguments = [], []
        plain = [
            (member, self.variable())
            for member in members
            if member.record is None or not member.inline
        ]
        if self.checked:
            self.check(plain)
        variables = iter(plain)
        for member in members:
            if member.record is not None and member.inline:
                pattern, given = self.struct(member.record.kind, member.record.members)
            else:
                pattern = given = next(variables)[1]
                if member.inward is not None:
                    given = f"{self.constant(member.inward)}({given}, note)"
            patterns.append(pattern)
            if not member.counts:
                arguments.append((member.name, given))
        made, twin = self.variable(), _open_twin(kind, [name for name, _ in arguments])
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

    def check(self, given: Sequence[tuple[Member, str]]) -> None:
        """Generate the checks of the members in these variables."""
        found = [(check, value) for member, value in given for check in member.checks]
        at_once = [(check, check.lanes, value) for check, value in found if check.lanes is not None]
        for check, value in found:
            if check.lanes is None:
                outside = check.outside.replace("{value}", value)
                self.lines.append(f"if {outside}: {self.fixed(check, value)}")
        if at_once:
            values = [value for _, _, value in at_once]
            self.lines.append(f"if {ranges.suspect(values, [lanes for _, lanes, _ in at_once])}:")
            self.lines += [f"    {self.fixed(check, value)}" for check, _, value in at_once]

    def fixed(self, check: ranges.Check, value: str) -> str:
        return f"{value} = {self.constant(check.fix)}({value}, note)"


def _refuse(kind: str, error: Exception) -> typing.NoReturn:
    if isinstance(error, CodecError):
        raise error
    text = f"these are no values of {kind}: {error}"
    raise CodecError(text) from error


def _open_twin(kind: type[Any], names: Sequence[str]) -> type[Any] | None:
    """A class whose objects can become `kind`; None if `kind` has more than fields."""
    line = kind.__mro__[-2::-1]  # the class next to object comes first
    slots = tuple(slot for each in line for slot in getattr(each, "__slots__", ("",)))
    plain = all(len(each.__bases__) == 1 for each in line) and slots == tuple(names)
    if not plain or not names or hasattr(kind, "__post_init__"):
        return None
    # Only a class with the same base has the same layout; a frozen base would refuse all values.
    # Python sets attributes fast only where a class has both methods from `object`.
    own = {"__slots__": kind.__slots__, "__setattr__": object.__setattr__}
    return type(kind.__name__, kind.__bases__, own | {"__delattr__": object.__delattr__})


def _member(name: str, hint: Any, node: formats.Format, where: str, *, strict: bool) -> Member:
    hint, declared = ranges.bare(hint), ranges.declared(hint)
    try:
        checks = ranges.checks(declared, node, where, strict=strict)
    except TypeError as error:
        raise MessageFormatError(str(node), 0, str(error)) from error
    if isinstance(node, formats.Struct):
        record = DataclassCodec.of(hint, node, where, strict=strict)
        return Member(
            name=name,
            record=record,
            inline=node.next_place is None,
            outward=_late(record),
            inward=_late_reader(record),
            shown="{" + record.fields + "}",
        )
    if isinstance(node, formats.Pointer):
        inner = _member(name, _without_none(hint), node.target, where, strict=strict)
        return _around(inner, "*", _writing_pointer, _reading_pointer)
    if isinstance(node, (formats.FixedArray, formats.VariableArray)):
        if isinstance(node.element, formats.Primitive):
            texts = node.element.name == "string"
            return Member(name=name, checks=checks, inward=_read_texts if texts else None)
        entry = next(iter(typing.get_args(hint)), hint)
        inner = _member(name, entry, node.element, where, strict=strict)
        inner = _around(inner, "[]", _writing_array, _reading_array)
        return dataclasses.replace(inner, checks=checks)
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return Member(name=name, inward=_enum_reader(hint, where))
    return Member(name=name, checks=checks)


def _read_texts(items: Sequence[str], _note: Note | None) -> tuple[str, ...]:
    return tuple(items)


def _late(record: DataclassCodec) -> _Converter:
    """A record's outward conversion, generated at its first call."""
    return lambda value: record.values(value)  # noqa: PLW0108 - the attribute generates it


def _late_reader(record: DataclassCodec) -> _Reader:
    """A record's inward conversion, generated at its first call."""
    return lambda value, note: record.build(value) if note is None else record.receive(value, note)


def _without_none(hint: Any) -> Any:
    """The one type that `hint` allows beside None, if any."""
    kinds = [kind for kind in typing.get_args(hint) if kind is not types.NoneType]
    optional = typing.get_origin(hint) in (typing.Union, types.UnionType)
    return kinds[0] if optional and len(kinds) == 1 else hint


def _around(
    inner: Member,
    sign: str,
    writing: Callable[[_Converter], _Converter],
    reading: Callable[[Member], _Reader | None],
) -> Member:
    """The member that is an array of `inner`, or a pointer to it."""
    return dataclasses.replace(
        inner,
        inline=False,
        outward=inner.outward and writing(inner.outward),
        inward=reading(inner),
        checks=(),
        shown=inner.shown and sign + inner.shown,
    )


def _writing_pointer(convert: _Converter) -> _Converter:
    return lambda value: None if value is None else convert(value)


def _reading_pointer(inner: Member) -> _Reader | None:
    read = inner.inward
    return read and (lambda value, note: None if value is None else read(value, note))


def _writing_array(convert: _Converter) -> _Converter:
    return lambda items: list(map(convert, items))


def _reading_array(inner: Member) -> _Reader | None:
    read = inner.inward
    return read and (lambda items, note: tuple([read(item, note) for item in items]))


def _enum_reader(kind: type[enum.IntEnum], where: str) -> _Reader:
    # A dict finds a member several times faster than a call of the enum.
    members = {member.value: member for member in kind}

    def read(value: int, _note: Note | None) -> enum.IntEnum:
        try:
            return members[value]
        except KeyError as error:
            text = f"{where}: {value} is none of {list(members)}"
            raise CodecError(text) from error

    return read
