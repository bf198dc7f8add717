"""Definitions from a listing, for tools without a message's dataclass."""

from __future__ import annotations

import dataclasses
import re
import types
from typing import Any

from hub.errors import MessageFormatError
from hub.ipc.definition import Keep, MessageDefinition, Plane, check_name
from hub.ipc.formats.grammar import MAX_DEPTH
from hub.ipc.wire import control

MAX_FIELDS = 16_384
"""Longest text of the fields of a message [characters]."""

_TOKEN = re.compile(r" *([A-Za-z]\w*|\[\]|[*{},])", re.ASCII)
_TEXT = re.compile(f"(?:{_TOKEN.pattern})*", re.ASCII)


def from_listing(entry: control.Define) -> MessageDefinition[Any]:
    """The definition in a listing; its type is a generated dataclass.

    Raises:
        MessageFormatError: The entry does not describe a message.
    """
    if len(entry.fields) > MAX_FIELDS or not _TEXT.fullmatch(entry.fields):
        reason = f"the fields of {entry.name[:80]} are too long or hold what is no name"
        raise MessageFormatError(entry.fields, 0, reason)
    check_name(entry.name)
    tokens = _TOKEN.findall(entry.fields)
    kind = _record(tokens, entry.name, 1)
    if tokens:
        raise MessageFormatError(entry.fields, 0, f"the fields of {entry.name} do not end")
    try:
        keep, plane = Keep(entry.keep), Plane(entry.plane)
    except ValueError as error:
        raise MessageFormatError(entry.name, 0, str(error)) from error
    return MessageDefinition(
        name=entry.name,
        format=entry.format,
        type=kind,
        keep=keep,
        plane=plane,
        rate_hz=entry.rate_hz,
        lifespan_s=entry.lifespan_s,
    )


def to_listing(definition: MessageDefinition[Any]) -> control.Define:
    """The DEFINE of a definition."""
    return control.Define(
        name=definition.name,
        format=definition.wire_format,
        fields=definition.fields,
        keep=definition.keep.value,
        plane=definition.plane.value,
        rate_hz=definition.rate_hz,
        lifespan_s=definition.lifespan_s,
    )


def _record(tokens: list[str], name: str, depth: int) -> type[Any]:
    """The dataclass of the first fields in `tokens`; consumes them up to the closing brace."""
    if depth > MAX_DEPTH:
        raise MessageFormatError(name[:80], 0, f"its fields are nested deeper than {MAX_DEPTH}")
    members: list[tuple[str, Any]] = []
    while tokens and tokens[0] != "}":
        field = tokens.pop(0)
        around = []
        while tokens and tokens[0] in ("[]", "*"):
            around.append(tokens.pop(0))
        kind: Any = Any
        if tokens and tokens[0] == "{":
            tokens.pop(0)
            kind = _record(tokens, f"{name}_{field}", depth + 1)
            if not tokens:
                raise MessageFormatError(name, 0, "its fields do not end")
            tokens.pop(0)
            # A pointer's target needs no other type: it may be None anyway.
            for _ in range(around.count("[]")):
                kind = types.GenericAlias(tuple, (kind, ...))
        members.append((field, kind))
        if tokens and tokens[0] == ",":
            tokens.pop(0)
    try:
        return dataclasses.make_dataclass(name, members, frozen=True, kw_only=True)
    except (TypeError, ValueError) as error:
        raise MessageFormatError(name, 0, f"fields that are no names: {error}") from error
