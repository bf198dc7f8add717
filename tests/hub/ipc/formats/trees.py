"""Random formats and values for property tests.

Strategies are made once each: Hypothesis looks through every new one before it draws from it.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from hypothesis import strategies as st

from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES

_RANGE = {
    "byte": (-(2**7), 2**7 - 1),
    "ubyte": (0, 2**8 - 1),
    "char": (0, 2**8 - 1),
    "short": (-(2**15), 2**15 - 1),
    "ushort": (0, 2**16 - 1),
    "int": (-(2**31), 2**31 - 1),
    "uint": (0, 2**32 - 1),
    "long": (-(2**63), 2**63 - 1),
    "ulong": (0, 2**64 - 1),
}
_TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)
_RARELY = st.integers(0, 9).map(lambda number: number == 9)
_BOOLEANS = st.booleans()
_LENGTHS = st.integers(1, 3)
_NAMES = st.lists(
    st.sampled_from(["idle", "running", "enum", "int", "stopped", "A_1"]),
    min_size=1,
    max_size=4,
    unique=True,
)


@functools.cache
def formats_of(depth: int = 3, fewest: int = 0) -> st.SearchStrategy[formats.Format]:
    """Formats that may stand anywhere; `fewest`: members of each struct."""
    leaves: st.SearchStrategy[formats.Format] = st.one_of(
        st.sampled_from(formats.PRIMITIVES).map(formats.Primitive),
        st.integers(0, 5).map(formats.Enum),
        _NAMES.map(lambda names: formats.Enum(len(names) - 1, tuple(names))),
    )
    if depth == 0:
        return leaves
    inner = formats_of(depth - 1, fewest)
    dimensions = st.lists(st.integers(1, 3), min_size=1, max_size=3).map(tuple)
    return st.one_of(
        leaves,
        structs(depth, fewest),
        st.builds(formats.FixedArray, _solid(depth - 1, fewest), dimensions),
        inner.map(formats.Pointer),
    )


@functools.cache
def _solid(depth: int, fewest: int) -> st.SearchStrategy[formats.Format]:
    return formats_of(depth, fewest).filter(lambda node: formats.elements_of(node) > 0)


@functools.cache
def structs(depth: int = 3, fewest: int = 0) -> st.SearchStrategy[formats.Struct]:
    """Structs, with variable arrays behind their size members."""
    return _structs(depth, fewest)


@st.composite
def _structs(draw: st.DrawFn, depth: int, fewest: int) -> formats.Struct:
    inner = formats_of(depth - 1, fewest)
    members: list[formats.Format] = []
    for _ in range(fewest + draw(_up_to(5 - fewest))):
        if draw(_RARELY) and members and formats.SelfPointer() not in members:
            members.append(formats.SelfPointer())
            continue
        sizes = [
            number
            for number, node in enumerate(members, 1)
            if isinstance(node, formats.Primitive) and node.name in formats.INTEGERS
        ]
        if sizes and draw(_BOOLEANS):
            chosen = draw(st.lists(st.sampled_from(sizes), max_size=2))
            members.append(formats.VariableArray(draw(_solid(depth - 1, fewest)), tuple(chosen)))
        else:
            members.append(draw(inner))
    if not any(map(formats.elements_of, members)):
        members = [member for member in members if member != formats.SelfPointer()]
    return formats.Struct(tuple(members))


@st.composite
def values_of(draw: st.DrawFn, node: formats.Format) -> Any:
    """A value that fits a format, as its decoder would give it back."""
    return _value(draw, node)


def _value(draw: st.DrawFn, node: formats.Format) -> Any:
    if isinstance(node, formats.Primitive):
        return draw(_primitive(node.name))
    if isinstance(node, formats.Enum):
        return draw(_up_to(node.largest))
    if isinstance(node, formats.Pointer):
        return _value(draw, node.target) if draw(_BOOLEANS) else None
    if isinstance(node, formats.FixedArray):
        array = _array(draw, node.element, node.count)
        return array.reshape(node.dimensions) if isinstance(array, np.ndarray) else array
    assert isinstance(node, formats.Struct)
    place = node.next_place
    if place is None:
        return _members(draw, node)
    first: Any = None
    for _ in range(draw(_LENGTHS)):
        body = _members(draw, node)
        first = (*body[:place], first, *body[place + 1 :])
    return first


def _members(draw: st.DrawFn, node: formats.Struct) -> tuple[Any, ...]:
    """The members of a struct; a self pointer is None."""
    sizes = {
        number - 1
        for member in node.members
        if isinstance(member, formats.VariableArray)
        for number in member.size_members
    }
    values: list[Any] = []
    for index, member in enumerate(node.members):
        if isinstance(member, formats.SelfPointer):
            values.append(None)
        elif isinstance(member, formats.VariableArray):
            chosen = [values[number - 1] for number in member.size_members]
            count = math.prod(chosen) if chosen else draw(_LENGTHS)
            values.append(_array(draw, member.element, count))
        elif index in sizes:
            values.append(draw(_up_to(3)))
        else:
            values.append(_value(draw, member))
    return tuple(values)


@functools.cache
def _up_to(largest: int) -> st.SearchStrategy[int]:
    return st.integers(0, largest)


@functools.cache
def _primitive(name: str) -> st.SearchStrategy[Any]:
    if name == "string":
        return _TEXT
    if name == "boolean":
        return _BOOLEANS
    if name in ("float", "double"):
        return st.floats(width=32 if name == "float" else 64)
    return st.integers(*_RANGE[name])


def _array(draw: st.DrawFn, element: formats.Format, count: int) -> Any:
    if isinstance(element, formats.Primitive) and element.name != "string":
        items = draw(st.lists(_primitive(element.name), min_size=count, max_size=count))
        return np.array(items, DTYPES[element.name])
    return [_value(draw, element) for _ in range(count)]


def same(one: Any, other: Any) -> bool:
    """Equality that looks into arrays and takes NaN for equal to itself."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return (
            isinstance(one, np.ndarray)
            and isinstance(other, np.ndarray)
            and one.shape == other.shape
            and one.dtype == other.dtype
            and one.tobytes() == other.tobytes()
        )
    if isinstance(one, (list, tuple)):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    return bool(one == other)
