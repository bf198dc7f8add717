"""Message values and text: FIELD=VALUE on the command line, and values for people to read; pure."""

from __future__ import annotations

import dataclasses
import enum
import json
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hub.errors import CodecError
from hub.ipc import format as formats
from hub.ipc.definition import MessageDefinition
from hub.toml_tables import nearest

_LONGEST_ARRAY = 64


def value_from_text(definition: MessageDefinition[Any], assignments: Sequence[str]) -> Any:  # noqa: ANN401
    """The value with the fields that were given; all others are zero or empty.

    Args:
        definition: Which message.
        assignments: "field=value"; inner fields with dots, "linear.x=0.5"; arrays as JSON lists.

    Raises:
        CodecError: A field that is not there, or a value that does not fit it.
    """
    value = definition.build(_zero(definition.tree))
    for assignment in assignments:
        path, equals, text = assignment.partition("=")
        if not equals:
            reason = f"{assignment!r} is no FIELD=VALUE"
            raise CodecError(reason)
        value = _assigned(value, path.split("."), text, definition.name)
    return value


def plain(value: Any) -> Any:  # noqa: ANN401 - any value of any message
    """The value as JSON knows it: mappings, lists, numbers, text; NaN and infinity as text."""
    if dataclasses.is_dataclass(value):
        return {
            field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)
        }
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, enum.IntEnum):
        return value.name
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def lines(value: Any) -> Iterator[str]:  # noqa: ANN401 - any value
    """The value for people: a line a field, inner fields indented."""
    yield from _lines(plain(value), "")


def _lines(members: dict[str, Any], indent: str) -> Iterator[str]:
    for name, member in members.items():
        if isinstance(member, dict):
            yield f"{indent}{name}:"
            yield from _lines(member, indent + "  ")
        else:
            yield f"{indent}{name}: {_shown(member)}"


def _shown(member: Any) -> str:  # noqa: ANN401 - any member
    if isinstance(member, float):
        return f"{member:.6g}"
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
        return np.array([_zero(node.element)] * node.count).reshape(node.dimensions)
    if isinstance(node, formats.VariableArray):
        return []
    if isinstance(node, (formats.Pointer, formats.SelfPointer)):
        return None
    if isinstance(node, formats.Primitive) and node.name == "string":
        return ""
    if isinstance(node, formats.Primitive) and node.name in ("float", "double"):
        return 0.0
    return False if node == formats.Primitive("boolean") else 0


def _assigned(value: Any, path: list[str], text: str, where: str) -> Any:  # noqa: ANN401
    """A copy of `value` with the field at `path` read from `text`."""
    names = [field.name for field in dataclasses.fields(value)]
    name, rest = path[0], path[1:]
    if name not in names:
        known = ", ".join(names)
        reason = f"{where} has no field {name!r}{nearest(name, names)}; it has {known}"
        raise CodecError(reason)
    member = getattr(value, name)
    if dataclasses.is_dataclass(member) != bool(rest):
        wanted = "inner fields, such as " + name + ".x" if not rest else "no inner fields"
        reason = f"{where}.{name} has {wanted}"
        raise CodecError(reason)
    changed = _assigned(member, rest, text, f"{where}.{name}") if rest else _read(member, text)
    return dataclasses.replace(value, **{name: changed})


def _read(old: Any, text: str) -> Any:  # noqa: ANN401 - as the member it replaces
    """What `text` says, in the kind of the value it replaces."""
    if isinstance(old, str):
        return text
    try:
        if isinstance(old, enum.IntEnum):
            kind = type(old)
            return kind[text.upper()] if not text.lstrip("-").isdigit() else kind(int(text))
        if isinstance(old, float):
            return float(text)
        return json.loads(text)
    except (ValueError, KeyError, RecursionError) as error:
        reason = f"{text[:40]!r} does not fit there: {error}"
        raise CodecError(reason) from error
