"""Generating the function that turns a payload of one format into its value."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.ipc import format as formats
from hub.ipc.codegen import DTYPES, ENCAPSULATION, LETTERS, Buffer, Generator

_TRAILING = 3
"""Bytes that some CDR writers add at the end to fill a word."""


def reader(tree: formats.Format) -> Callable[[Buffer], Any]:
    """The function that turns a payload of the format into its value."""
    return _Reader(tree).function()


class _Reader(Generator):
    """Generates the function payload -> value."""

    arguments = "payload"

    def body(self) -> None:
        self.names |= {
            "numbers": np.frombuffer,
            "string": _string,
            "flags": _flags,
            "refuse": _refuse,
        }
        self.emit(f"if payload[:4] != {ENCAPSULATION!r}:")
        self.emit("    refuse('the encapsulation is not little-endian CDR')")
        result = self.read(self.root)
        self.flush()
        end = "at" if self.offset is None else str(self.offset)
        self.emit(f"left = len(payload) - 4 - {end}")
        self.emit(f"if not 0 <= left <= {_TRAILING}:")
        self.emit("    refuse(f'{left} bytes are left over')")
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
        else:
            self.emit(f"{targets}, = {name}.unpack_from(payload, {(start or 0) + 4})")
        self.run = []
        for local, largest in self.unchecked:
            self.emit(f"if not 0 <= {local} <= {largest}:")
            self.emit(f"    refuse(f'enum value {{{local}}} is not 0 to {largest}')")
        self.unchecked = []

    def read(self, node: formats.Format) -> str:
        """Generate the reading of one value; returns the expression that holds it afterwards."""
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
        self.run.append((LETTERS[name], local))
        return local

    def read_enum(self, node: formats.Enum) -> str:
        local = self.fresh("v")
        self.run.append(("i", local))
        self.unchecked.append((local, node.largest))
        return local

    def read_struct(self, node: formats.Struct) -> str:
        members: list[str] = []
        for member in node.members:
            if isinstance(member, formats.VariableArray):
                members.append(self.read_sequence(member, members))
            else:
                members.append(self.read(member))
        return "(" + "".join(f"{member}, " for member in members) + ")"

    def read_sequence(self, node: formats.VariableArray, members: list[str]) -> str:
        count = self.read_number("uint")
        self.flush()
        sizes = " * ".join(members[number - 1] for number in node.size_members)
        self.emit(f"if {count} != {sizes}:")
        self.emit(f"    refuse(f'{{{count}}} elements where the size members say {{{sizes}}}')")
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
        self.emit(f"{local} = []")
        self.emit(f"for _ in range({count}):")
        self.indent += 1
        item = self.read(element)
        self.flush()
        self.emit(f"{local}.append({item})")
        self.indent -= 1
        return local

    def read_numbers(
        self, element: formats.Primitive, local: str, count: str, dimensions: tuple[int, ...] | None
    ) -> None:
        dtype = DTYPES[element.name]
        boolean = element.name == "boolean"
        kind = self.constant("dtype", DTYPES["ubyte"] if boolean else dtype)
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
        if boolean:
            self.emit(f"{local} = flags({local})")
        if dimensions is not None and len(dimensions) > 1:
            self.emit(f"{local} = {local}.reshape({dimensions})")

    def read_pointer(self, node: formats.Pointer) -> str:
        count = self.read_number("uint")
        self.flush()
        self.go_dynamic()
        local = self.fresh("v")
        self.emit(f"{local} = None")
        self.emit(f"if {count} == 1:")
        self.indent += 1
        target = self.read(node.target)
        self.flush()
        self.emit(f"{local} = {target}")
        self.indent -= 1
        self.emit(f"elif {count}:")
        self.emit(f"    refuse(f'a pointer to {{{count}}} values')")
        return local


def _empty(dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    nothing = np.empty(0, dtype)
    nothing.flags.writeable = False
    return nothing


def _flags(octets: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    """The booleans in these bytes; any other byte than 0 and 1 would be a broken boolean."""
    if octets.size and octets.max() > 1:
        _refuse("a boolean that is neither 0 nor 1")
    return octets.view(np.bool_)


def _string(payload: Buffer, start: int, count: int) -> str:
    if count == 0:
        return ""
    raw = bytes(payload[start : start + count])
    if len(raw) != count or raw.find(b"\0") != count - 1:
        _refuse("a string that does not end where it says")
    return raw[:-1].decode()


def _refuse(reason: str) -> None:
    raise ValueError(reason)
