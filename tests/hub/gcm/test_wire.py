"""The bytes of every message of the vocabulary, against files that other programs may rely on.

After a new message, write its file: RUNE_WRITE_SNAPSHOTS=1 pytest tests/hub/gcm/test_wire.py
"""

from __future__ import annotations

import itertools
import os
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hub.gcm.catalog import BY_NAME, MESSAGES
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import codec, ranges, wire_types
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES
from tests.support.cases import for_each
from tests.support.extremes import is_enum

_GOLDEN = Path(__file__).parents[2] / "golden" / "wire"


def value_of(definition: MessageDefinition[Any]) -> Any:
    """A value with another number in each member: 1, 2, 3 and so on; enums and sizes small."""
    return definition.build(_members(definition.tree, definition.type, itertools.count(1)))


def _members(node: formats.Format, kind: Any, numbers: Iterator[int]) -> list[Any]:
    assert isinstance(node, formats.Struct)
    hints = [member.hint for member in wire_types.members(kind)]
    sizes = {
        number - 1
        for member in node.members
        if isinstance(member, formats.VariableArray)
        for number in member.size_members
    }
    return [
        3 if place in sizes else _value(member, hint, numbers)
        for place, (member, hint) in enumerate(zip(node.members, hints, strict=True))
    ]


def _value(node: formats.Format, hint: Any, numbers: Iterator[int]) -> Any:
    hint = ranges.bare(hint)
    if isinstance(node, formats.Struct):
        return _members(node, hint, numbers)
    if is_enum(hint):
        return max(hint)
    if isinstance(node, formats.Enum):
        return node.largest
    if isinstance(node, formats.VariableArray):
        return _elements(node.element, hint, 3 ** max(1, len(node.size_members)), numbers)
    if isinstance(node, formats.FixedArray):
        return _elements(node.element, hint, node.count, numbers)
    if isinstance(node, formats.Pointer):
        return _value(node.target, typing.get_args(hint)[0], numbers)
    if isinstance(node, formats.SelfPointer):
        return None
    if node.name == "string":
        return f"text {next(numbers)}"
    if node.name in ("float", "double"):
        return next(numbers) + 0.25
    return next(numbers) if node.name != "boolean" else True


def _elements(element: formats.Format, hint: Any, count: int, numbers: Iterator[int]) -> Any:
    entry = next(iter(typing.get_args(hint)), hint)
    items = [_value(element, entry, numbers) for _ in range(count)]
    if isinstance(element, formats.Primitive) and element.name != "string":
        return np.array(items, DTYPES[element.name])
    return items


def _hex_lines(payload: bytes) -> str:
    """32 bytes a line."""
    return "".join(f"{payload[at : at + 32].hex(' ', -4)}\n" for at in range(0, len(payload), 32))


@for_each("definition", MESSAGES)
def test_message_has_the_bytes_of_its_golden_file(definition: MessageDefinition[Any]) -> None:
    payload = b"".join(definition.encode(value_of(definition)))
    wire = f"{definition.wire_format}\n{_hex_lines(payload)}"
    golden = _GOLDEN / f"{definition.name}.txt"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS") and not golden.exists():
        golden.write_text(wire)
    assert golden.is_file(), "a new message: write its file as this file's docstring says"
    assert golden.read_text() == wire, "other programs rely on these bytes: define another message"
    back = definition.build(codec.compiled(definition.wire_format).decode(payload))  # not bounded
    assert b"".join(definition.encode(back)) == payload


def test_every_golden_file_belongs_to_a_message() -> None:
    assert {path.stem for path in _GOLDEN.glob("*.txt")} == set(BY_NAME)


@for_each(
    ("name", "wire"),
    [
        ("GCM_Stop", "00010000 07000000 74657874 203100"),
        (
            "GCM_Image_Request",
            "00010000 01000000 01000000 02000000 03000000 03000000 07000000 74657874 203400",
        ),
        (
            "GCM_ModuleInfo",
            "00010000 07000000 74657874 203100 00 02000000"
            "07000000 74657874 203300 00 07000000 74657874 203400 00 07000000 74657874 203500 00"
            "06000000",
        ),
        (
            "GCM_Velocity_Command",
            "00010000 01000000 02000000 07000000 74657874 203300 00 00000000"
            "0000000000001140 0000000000001540 0000000000001940"
            "0000000000001d40 0000000000802040 0000000000802240",
        ),
    ],
)
def test_golden_file_agrees_with_bytes_computed_by_hand(name: str, wire: str) -> None:
    golden = (_GOLDEN / f"{name}.txt").read_text().partition("\n")[2]
    assert bytes.fromhex(golden) == bytes.fromhex(wire)


def test_message_names_are_unique_and_definitions_say_what_they_keep() -> None:
    assert len(BY_NAME) == len(MESSAGES)
    assert all(d.lifespan_s > 0 and d.rate_hz >= 0 for d in MESSAGES)
