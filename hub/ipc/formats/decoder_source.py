"""Generates the function from a payload of one format to its value."""

from __future__ import annotations

import functools
import math
import struct
from collections.abc import Callable, Mapping
from typing import Any, Literal, NoReturn

import numpy as np
import numpy.typing as npt

from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES, ENCAPSULATION, LETTERS, Buffer, Generator, Order, packed

_ENDS: Mapping[Order, Literal["little", "big"]] = {"<": "little", ">": "big"}
_TRAILING = 3
"""Bytes that some CDR writers add at the end to fill a word."""


def reader(tree: formats.Format) -> Callable[[Buffer], Any]:
    """The function from a payload of the format to its value.

    It reads little-endian payloads. A payload in the other order goes to a second function,
    generated at its first use.
    """
    big_reader = functools.cache(lambda: _Reader(tree, _refuse_encapsulation, ">").function())

    def other_order(payload: Buffer) -> Any:
        return big_reader()(payload)

    return _Reader(tree, other_order).function()


class _Reader(Generator):
    """Generates the function payload -> value."""

    arguments = "payload"

    def __init__(
        self, tree: formats.Format, otherwise: Callable[[Buffer], Any], order: Order = "<"
    ) -> None:
        super().__init__(tree, order)
        self.otherwise = otherwise
        self.opened = False

    def body(self) -> None:
        self.names |= {
            "otherwise": self.otherwise,
            "native": _native,
            "linked": _linked,
            "numbers": np.frombuffer,
            "string": _string,
            "flags": _flags,
            "refuse": _refuse,
        }
        head = len(self.lines)
        result = self.read(self.root)
        if any("left -=" in line for line in self.lines):
            self.lines.insert(head, f"    left = {formats.MAX_ITEMS}")
        self.flush()
        if not self.opened:
            check = (
                f"    if payload[:4] != {ENCAPSULATION[self.order]!r}: return otherwise(payload)"
            )
            self.lines.insert(head, check)
        end = "at + 4" if self.offset is None else str(self.offset + 4)
        self.emit(f"if not {end} <= len(payload) <= {end} + {_TRAILING}:")
        self.emit(f"    refuse(f'{{len(payload) - ({end})}} bytes are left over')")
        self.emit(f"return {result}")

    def flush(self) -> None:
        if not self.run:
            return
        targets = ", ".join(target for _, target in self.run)
        dynamic, start = self.offset is None, self.offset
        name = self.run_struct()
        if dynamic:
            self.emit(f"s = {name}[at & 7]")
            self.emit(f"{targets}, = s.unpack_from(payload, at + 4)")
            self.emit("at += s.size")
        elif start == 0:
            # The first struct call reads the encapsulation too, at almost no cost.
            self.opened = True
            self.names[name] = struct.Struct(f"{self.order}I{self.names[name].format[1:]}")
            self.emit(f"mark, {targets}, = {name}.unpack_from(payload)")
            self.emit(f"if mark != {int.from_bytes(ENCAPSULATION[self.order], _ENDS[self.order])}:")
            self.emit("    return otherwise(payload)")
        else:
            self.emit(f"{targets}, = {name}.unpack_from(payload, {(start or 0) + 4})")
        self.run = []
        for line in self.afterwards:
            self.emit(line)
        self.afterwards = []

    def read(self, node: formats.Format) -> str:
        """Generate the reading of one value; returns its expression."""
        if isinstance(node, formats.Primitive):
            return self.read_string() if node.name == "string" else self.read_number(node.name)
        if isinstance(node, formats.Enum):
            return self.read_enum(node)
        if isinstance(node, formats.Struct):
            return self.read_struct(node)
        if isinstance(node, formats.FixedArray):
            return self.read_elements(node.element, str(node.count), node.dimensions)
        if isinstance(node, formats.Pointer):
            return self.read_pointer(node)
        raise AssertionError(node)

    def read_number(self, name: str) -> str:
        local = self.fresh("v")
        if name == "boolean":
            # As a number first: a struct takes any byte but 0 for true.
            self.run.append((packed("B"), local))
            self.afterwards.append(f"{local} = bool({local}) if {local} < 2 else")
            self.afterwards[-1] += f" refuse(f'a boolean of {{{local}}} is neither 0 nor 1')"
        else:
            self.run.append((packed(LETTERS[name]), local))
        return local

    def read_enum(self, node: formats.Enum) -> str:
        local = self.fresh("v")
        self.run.append((packed("i"), local))
        self.afterwards.append(f"if not 0 <= {local} <= {node.largest}:")
        self.afterwards.append(f"    refuse(f'enum value {{{local}}} is not 0 to {node.largest}')")
        return local

    def read_struct(self, node: formats.Struct) -> str:
        if node.next_place is not None:
            return self.read_list(node, fewest=1)
        return self.read_members(node)

    def read_members(self, node: formats.Struct) -> str:
        """Generate the reading of the members but the self pointer; returns them as a tuple."""
        members: list[str] = []
        for member in node.members:
            if isinstance(member, formats.VariableArray):
                members.append(self.read_sequence(member, members))
            elif isinstance(member, formats.SelfPointer):
                members.append("")
            else:
                members.append(self.read(member))
        return "(" + "".join(f"{member}, " for member in members if member) + ")"

    def read_list(self, node: formats.Struct, fewest: int) -> str:
        count = self.read_number("uint")
        self.flush()
        self.emit(f"if not {fewest} <= {count} <= {formats.MAX_NODES} or {count} > len(payload):")
        self.emit(f"    refuse(f'a list of {{{count}}} nodes')")
        self.go_dynamic()
        nodes = self.fresh("v")
        self.emit(f"{nodes} = []")
        with self.block(f"for _ in range({count}):"):
            item = self.read_members(node)
            self.flush()
            self.emit(f"{nodes}.append({item})")
        self.emit(f"{nodes} = linked({nodes}, {node.next_place})")
        return nodes

    def read_sequence(self, node: formats.VariableArray, members: list[str]) -> str:
        count = self.read_number("uint")
        self.flush()
        sizes = [members[number - 1] for number in node.size_members]
        product = " * ".join(sizes)
        if sizes:
            self.emit(f"if {count} != {product}:")
            text = f"f'{{{count}}} elements where the size members say {{{product}}}'"
            self.emit(f"    refuse({text})")
        if len(sizes) > 1:
            self.emit(f"if min({', '.join(sizes)}) < 0:")
            self.emit("    refuse('a negative size')")
        self.emit(f"if {count} > len(payload):")
        self.emit(f"    refuse(f'{{{count}}} elements cannot be in it')")
        return self.read_elements(node.element, count, None)

    def read_string(self) -> str:
        count = self.read_number("uint")
        self.flush()
        self.go_dynamic()
        local = self.fresh("v")
        self.emit(f"{local} = string(payload, at + 4, {count})")
        self.emit(f"at += {count}")
        return local

    def read_elements(
        self, element: formats.Format, count: str, dimensions: tuple[int, ...] | None
    ) -> str:
        self.flush()
        local = self.fresh("v")
        if isinstance(element, formats.Primitive) and element.name != "string":
            self.read_numbers(element, local, count, dimensions)
            return local
        self.go_dynamic()
        self.emit(f"left -= {count}")
        self.emit("if left < 0:")
        self.emit(f"    refuse('more than {formats.MAX_ITEMS} texts, structs and sequences')")
        self.emit(f"{local} = []")
        with self.block(f"for _ in range({count}):"):
            item = self.read(element)
            self.flush()
            self.emit(f"{local}.append({item})")
        return local

    def read_numbers(
        self, element: formats.Primitive, local: str, count: str, dimensions: tuple[int, ...] | None
    ) -> None:
        dtype = DTYPES[element.name]
        boolean = element.name == "boolean"
        wire = DTYPES["ubyte"] if boolean else dtype.newbyteorder(self.order)
        kind = self.constant("dtype", wire)
        if dimensions is not None and self.offset is not None:
            self.offset += -self.offset % dtype.itemsize
            self.emit(f"{local} = numbers(payload, {kind}, {count}, {self.offset + 4})")
            self.offset += math.prod(dimensions) * dtype.itemsize
        else:
            self.go_dynamic()
            if dtype.itemsize > 1:
                self.emit(f"at += -at % {dtype.itemsize} if {count} else 0")
            self.emit(f"{local} = numbers(payload, {kind}, {count}, at + 4) if {count} else")
            self.lines[-1] += f" {self.constant('empty', _empty(dtype))}"
            self.emit(f"at += {count} * {dtype.itemsize}")
        if self.order == ">" and dtype.itemsize > 1:
            self.emit(f"{local} = native({local})")
        if boolean:
            self.emit(f"{local} = flags({local})")
        if dimensions is not None and len(dimensions) > 1:
            self.emit(f"{local} = {local}.reshape({dimensions})")

    def read_pointer(self, node: formats.Pointer) -> str:
        if isinstance(node.target, formats.Struct) and node.target.next_place is not None:
            return self.read_list(node.target, fewest=0)
        count = self.read_number("uint")
        self.flush()
        self.go_dynamic()
        local = self.fresh("v")
        self.emit(f"{local} = None")
        with self.block(f"if {count} == 1:"):
            target = self.read(node.target)
            self.flush()
            self.emit(f"{local} = {target}")
        self.emit(f"elif {count}:")
        self.emit(f"    refuse(f'a pointer to {{{count}}} values')")
        return local


def _empty(dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    nothing = np.empty(0, dtype)
    nothing.flags.writeable = False
    return nothing


def _native(swapped: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Numbers of the other byte order in this order, read-only like all arrays."""
    array = swapped.astype(swapped.dtype.newbyteorder("<"))
    array.flags.writeable = False
    return array


def _linked(nodes: list[tuple[Any, ...]], next_place: int) -> tuple[Any, ...] | None:
    """The first of these nodes, each with the next one as a further member."""
    first: tuple[Any, ...] | None = None
    for node in reversed(nodes):
        first = (*node[:next_place], first, *node[next_place:])
    return first


def _flags(octets: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    """The booleans in these bytes; a byte beside 0 and 1 is refused."""
    if octets.size and octets.max() > 1:
        _refuse("a boolean that is neither 0 nor 1")
    return octets.view(np.bool_)


def _string(payload: Buffer, start: int, count: int) -> str:
    if count == 0:
        return ""
    raw = bytes(payload[start : start + count])
    if len(raw) != count or raw.find(b"\0") != count - 1:
        _refuse("a string without NUL at its end")
    return raw[:-1].decode()


def _refuse(reason: str) -> NoReturn:
    raise ValueError(reason)


def _refuse_encapsulation(payload: Buffer) -> NoReturn:
    _refuse(f"the encapsulation {bytes(payload[:4]).hex(' ')} is not that of plain CDR")
