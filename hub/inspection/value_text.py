"""Message values and text: FIELD=VALUE on the command line, and values for people to read; pure."""

from __future__ import annotations

import dataclasses
import enum
import json
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES
from hub.ipc.formats.dataclass_codec import DataclassCodec
from hub.ipc.formats.ranges import no_note
from hub.nearest import did_you_mean
from hub.toml_reader import shorten

_LONGEST_ARRAY = 64


def value_from_text(
    definition: MessageDefinition[Any],
    assignments: Sequence[str],
    warn: Callable[[str], object] = no_note,
) -> Any:  # noqa: ANN401 - any message
    """The value with the given fields; all others are zero or empty.

    Args:
        definition: Which message.
        assignments: "field=value"; inner fields with dots, "twist.linear.x=0.5"; arrays
            as JSON lists.
        warn: Gets a sentence on each assignment that is left out.

    Raises:
        CodecError: A field that is not there, or a value that does not fit it.
    """
    value = definition.build(_zero(definition.tree))
    for assignment in assignments:
        path, equals, text = assignment.partition("=")
        if not equals:
            reason = f"{shorten(assignment)} is no FIELD=VALUE, such as twist.linear.x=0.5"
            raise CodecError(reason)
        counted = _counted_by(definition.record, path.split("."))
        if counted:
            warn(f"{path} follows from {counted}, leave it out")
            continue
        value = _assigned(value, path.split("."), text, definition.name)
    return value


def _counted_by(record: DataclassCodec | None, path: Sequence[str]) -> str:
    """The array whose number of elements the member at `path` is; empty if it is another member."""
    members = {member.name: member for member in record.members} if record else {}
    member = members.get(path[0])
    if member is None or len(path) == 1:
        return member.counts if member else ""
    return _counted_by(member.record, path[1:])


def demand_within_ranges(definition: MessageDefinition[Any], value: Any) -> None:  # noqa: ANN401
    """Refuse a value that every receiver would refuse, without a word to its sender.

    Raises:
        RangeError: A field is out of its range.
    """
    definition.decode(b"".join(definition.encode(value)))


def plain(value: Any, record: DataclassCodec | None = None) -> Any:  # noqa: ANN401 - any message
    """A message as a JSON value: mappings, lists, numbers, text; NaN and infinity as text.

    A linked list becomes a list of its nodes without the self pointer, because JSON cannot nest as
    deep as a list is long; a message that is one itself has the field "nodes", as in its schema.

    Args:
        value: The message.
        record: Its members; needed if it can hold linked lists.

    Raises:
        CodecError: A linked list is longer than one can be, or runs in a circle.
    """
    plain_value = _plain(value, record)
    return {"nodes": plain_value} if isinstance(plain_value, list) else plain_value


def lines(value: Any, record: DataclassCodec | None = None) -> Iterator[str]:  # noqa: ANN401 - any
    """A message for people: a line a field, inner fields indented; arguments as for `plain`."""
    yield from _lines(plain(value, record), "")


def _plain(value: Any, record: DataclassCodec | None) -> Any:  # noqa: ANN401 - part of a message
    is_record = value is None or dataclasses.is_dataclass(value)
    if record is not None and record.next_place is not None and is_record:
        next_name = record.members[record.next_place].name
        return [_members(node, record, next_name) for node in _nodes(value, next_name)]
    if dataclasses.is_dataclass(value):
        return _members(value, record)
    if isinstance(value, np.ndarray):
        return _plain(value.tolist(), None)
    if isinstance(value, (list, tuple)):
        return [_plain(item, record) for item in value]
    if isinstance(value, enum.IntEnum):
        return value.name
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _members(value: Any, record: DataclassCodec | None, without: str = "") -> dict[str, Any]:  # noqa: ANN401
    """The fields of a dataclass, except one."""
    inner = {member.name: member.record for member in record.members} if record else {}
    return {
        field.name: _plain(getattr(value, field.name), inner.get(field.name))
        for field in dataclasses.fields(value)
        if field.name != without
    }


def _nodes(first: Any, next_name: str) -> Iterator[Any]:  # noqa: ANN401 - any node or None
    """The nodes of a linked list, first to last."""
    for _ in range(formats.MAX_NODES):
        if first is None:
            return
        yield first
        first = getattr(first, next_name)
    if first is not None:
        text = f"a list longer than {formats.MAX_NODES} nodes, or one that runs in a circle"
        raise CodecError(text)


def _lines(members: dict[str, Any], indent: str) -> Iterator[str]:
    for name, member in members.items():
        if isinstance(member, dict):
            yield f"{indent}{name}:"
            yield from _lines(member, indent + "  ")
        else:
            yield f"{indent}{name}: {_shown(member)}"


def _shown(member: Any) -> str:  # noqa: ANN401 - any member
    if isinstance(member, float):
        # A time of day has ten digits before the point, and those behind it count.
        return f"{member:.3f}" if 1e6 <= abs(member) < 1e12 else f"{member:.6g}"
    if isinstance(member, list):
        shown = ", ".join(_shown(item) for item in member[:_LONGEST_ARRAY])
        more = f", ... {len(member)} in all" if len(member) > _LONGEST_ARRAY else ""
        return f"[{shown}{more}]"
    if isinstance(member, str):
        return member if member.isprintable() else repr(member)
    return json.dumps(member)


def _zero(node: formats.Format) -> Any:  # noqa: ANN401 - the value of any format
    """The value whose numbers are 0 and whose texts and arrays are empty."""
    if isinstance(node, formats.Struct):
        return [_zero(member) for member in node.members]
    if isinstance(node, formats.FixedArray):
        return _zeros(node)
    if isinstance(node, formats.VariableArray):
        return []
    if isinstance(node, (formats.Pointer, formats.SelfPointer)):
        return None
    if isinstance(node, formats.Primitive) and node.name == "string":
        return ""
    if isinstance(node, formats.Primitive) and node.name in ("float", "double"):
        return 0.0
    return False if node == formats.Primitive("boolean") else 0


def _zeros(node: formats.FixedArray) -> Any:  # noqa: ANN401 - an array or a list
    """Arrays of numbers in their shape, others flat, as a codec takes them."""
    if isinstance(node.element, formats.Primitive) and node.element.name in DTYPES:
        return np.zeros(node.dimensions, DTYPES[node.element.name])
    return [_zero(node.element)] * node.count


def _assigned(value: Any, path: list[str], text: str, where: str) -> Any:  # noqa: ANN401
    """A copy of `value` with the field at `path` read from `text`."""
    names = [field.name for field in dataclasses.fields(value)]
    name, rest = path[0], path[1:]
    if name not in names:
        hint = did_you_mean(name, names) or f"; it has {', '.join(names)}"
        reason = f"{where} has no field {name!r}{hint}"
        raise CodecError(reason)
    member = getattr(value, name)
    if dataclasses.is_dataclass(member) != bool(rest):
        wanted = "inner fields, such as " + name + ".x" if not rest else "no inner fields"
        reason = f"{where}.{name} has {wanted}"
        raise CodecError(reason)
    changed = (
        _assigned(member, rest, text, f"{where}.{name}")
        if rest
        else _read(member, text, f"{where}.{name}")
    )
    return dataclasses.replace(value, **{name: changed})


def _read(old: Any, text: str, where: str) -> Any:  # noqa: ANN401 - as the member it replaces
    """The value of `text`, in the type of the value that it replaces."""
    if isinstance(old, str):
        return text
    try:
        if isinstance(old, enum.IntEnum):
            kind = type(old)
            return kind[text.upper()] if not text.lstrip("-").isdigit() else kind(int(text))
        if isinstance(old, float):
            return float(text)
        read = json.loads(text)
    except (ValueError, KeyError, RecursionError) as error:
        raise _unfit(old, text, where) from error
    if old is not None and not isinstance(read, int if isinstance(old, int) else list):
        raise _unfit(old, text, where)
    return read


def _unfit(old: Any, text: str, where: str) -> CodecError:  # noqa: ANN401 - any member
    return CodecError(f"{where}: {shorten(text)} does not fit there; give {_wanted(old, text)}")


def _wanted(old: Any, text: str) -> str:  # noqa: ANN401 - any member
    """The allowed replacements of a value."""
    if isinstance(old, enum.IntEnum):
        names = [member.name for member in type(old)]
        return f"one of {', '.join(names)}{did_you_mean(text.upper(), names)}"
    if isinstance(old, int | float):
        return "a number"
    return 'a JSON list, such as [1, 2] or [{"x": 1}]'
