"""Extreme messages: every definition of the catalog with values that no robot can mean.

Of each message some fields are wild, which is anything that the wire carries; the others are at the
edges of what they declare, so that messages with a few wild fields get as far as those without.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import math
import typing
from collections.abc import Iterator
from random import Random
from typing import Any

import numpy as np

from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.ipc.formats import ranges, wire_types
from hub.ipc.formats.codegen import DTYPES, Buffer

CONTROL = "\x1b]0;PWNED\x07\x9b31m\u202e\u200b\r\n\x08<script>=1+1"
WILD_FLOATS = (
    *(math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, -5e-324, -0.0, 0.0, 1.0, -1.0),
    *(1e9, -1e9, 1e16, 3.5, 100.0, 3.4e38, 1.8e38, -1e-9, 1e-300),
)
WILD_TEXTS = (
    *("", "a", CONTROL, "x" * 300, "../../../etc/passwd", "\n\n", "\t" * 50, " ", "%s%n{0}${x}"),
    *("driver", "navigation", "magellan", "VIS_VID PRO_MAP", "running", "\U0001f600\u0301" * 9),
)
_LONG = 100_000
_DEPTH = 2


def payloads(definition: MessageDefinition[Any], random: Random) -> Iterator[Buffer]:
    """Payloads without end: well-formed ones of extreme values, now and then a damaged one."""
    while True:
        wildness = random.choice((0.0, 0.0, 0.05, 0.2, 1.0))
        made = _Maker(random, wildness)
        values = made.struct(definition.tree, definition.type, 0)
        payload = b"".join(definition.encode(definition.build(values)))
        yield _damaged(payload, random) if random.random() < 0.05 else payload


def taken(definition: MessageDefinition[Any], random: Random) -> Iterator[Any]:
    """Values without end that pass the bounds: what handlers and visualizers may get."""
    for payload in payloads(definition, random):
        try:
            yield definition.decode(payload)
        except ValueError:
            continue


@functools.cache
def fields_of(kind: type[Any]) -> tuple[tuple[str, Any], ...]:
    """Names and types of a dataclass's fields."""
    hints = typing.get_type_hints(kind, include_extras=True)
    return tuple((field.name, hints[field.name]) for field in dataclasses.fields(kind))


def is_enum(hint: Any) -> bool:
    """Whether a field's type is an enum."""
    kind = ranges.bare(hint)
    return isinstance(kind, type) and issubclass(kind, enum.IntEnum)


class _Maker:
    def __init__(self, random: Random, wildness: float) -> None:
        self.random = random
        self.wildness = wildness

    def struct(self, tree: Any, kind: Any, depth: int) -> list[Any]:
        sizes: dict[int, int] = {}
        for member in tree.members:
            if isinstance(member, formats.VariableArray):
                sizes |= dict.fromkeys((n - 1 for n in member.size_members), self.size(depth))
        values: list[Any] = []
        for place, (member, node) in enumerate(
            zip(wire_types.members(kind), tree.members, strict=True)
        ):
            if place in sizes:
                values.append(sizes[place])
            elif isinstance(node, formats.VariableArray):
                chosen = [sizes[n - 1] for n in node.size_members]
                count = math.prod(chosen) if chosen else self.size(depth)
                values.append(self.array(node, member.hint, count, depth))
            else:
                values.append(self.value(node, member.hint, depth))
        return values

    def value(self, node: Any, hint: Any, depth: int) -> Any:
        if isinstance(node, formats.Struct):
            return self.struct(node, ranges.bare(hint), depth + 1)
        if isinstance(node, formats.FixedArray):
            return self.array(node, hint, node.count, depth)
        if isinstance(node, formats.Enum):
            return self.random.randint(0, node.largest)
        if is_enum(hint):
            return self.random.choice(list(ranges.bare(hint)))
        if isinstance(node, formats.Primitive):
            wild = self.random.random() < self.wildness
            return (
                self.text(hint, wild=wild)
                if node.name == "string"
                else self.number(node, hint, wild=wild)
            )
        raise AssertionError(node)

    def array(self, node: Any, hint: Any, count: int, depth: int) -> Any:
        element = node.element
        if isinstance(element, formats.Primitive) and element.name in DTYPES:
            wild = self.random.random() < self.wildness
            few = [self.number(element, hint, wild=wild) for _ in range(min(count, 40))] or [0]
            return np.resize(np.array(few, DTYPES[element.name]), count)
        inner = next(iter(typing.get_args(ranges.bare(hint))))
        return [self.value(element, inner, depth) for _ in range(count)]

    def number(self, node: formats.Primitive, hint: Any, *, wild: bool) -> Any:
        limits = [each for each in ranges.declared(hint) if isinstance(each, ranges.Range)]
        if node.name == "boolean":
            return self.random.random() < 0.5
        if node.name in ("float", "double"):
            value = self.random.choice(WILD_FLOATS)
            if limits and not wild:
                value = self.random.choice(_edges(limits[0]))
            most = 3.4e38 if node.name == "float" else math.inf
            return value if abs(value) <= most or not math.isfinite(value) else most
        kind = np.iinfo(DTYPES[node.name])
        low, high = int(kind.min), int(kind.max)
        if limits and not wild:
            low, high = max(low, int(limits[0].low)), min(high, int(limits[0].high))
        near = self.random.randint(max(low, -20), min(high, 20)) if low <= 20 <= high else low
        return self.random.choice((low, high, near, min(high, max(low, 0)), min(high, low + 1)))

    def text(self, hint: Any, *, wild: bool) -> str:
        if self.random.random() < 0.01:
            return "L" * _LONG
        text = self.random.choice(WILD_TEXTS)
        most = [each.most for each in ranges.declared(hint) if isinstance(each, ranges.Text)]
        return text if wild or not most else text[: most[0]]

    def size(self, depth: int) -> int:
        if depth >= _DEPTH:
            return self.random.choice((0, 1, 3))
        if self.random.random() < 0.005:
            return self.random.choice((1000, 1001, 3000))
        return self.random.choice((0, 0, 1, 2, 5, 20))


def _edges(limit: ranges.Range) -> tuple[float, ...]:
    middle = 0.0 if limit.low <= 0.0 <= limit.high else (limit.low + limit.high) / 2.0
    step = min(limit.high, middle + 1.5)
    edges = [limit.low, limit.high, middle, step, step, middle, min(limit.high, middle + 5e-324)]
    edges += [math.nan] * limit.nan + [math.inf] * limit.infinite
    return tuple(edges)


def _damaged(payload: bytes, random: Random) -> bytes:
    """Cut, longer, or with a few other bytes: counts that do not fit, surrogates, wrong enums."""
    way = random.randrange(3)
    if way == 0:
        return payload[: random.randrange(len(payload) + 1)]
    if way == 1:
        return payload + bytes(random.randrange(1, 9))
    raw = bytearray(payload)
    for _ in range(3):
        raw[random.randrange(len(raw))] = random.choice((0, 1, 0x7F, 0x80, 0xED, 0xFF))
    return bytes(raw)
