"""Generating, for one format, the functions that write and read its payloads.

`codec` says what the payloads look like; this file turns a Format tree into Python source.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.ipc import format as formats

Buffer = bytes | bytearray | memoryview
ENCAPSULATION = b"\x00\x01\x00\x00"

_LETTER = {
    "byte": "b",
    "ubyte": "B",
    "char": "B",
    "short": "h",
    "ushort": "H",
    "int": "i",
    "uint": "I",
    "long": "q",
    "ulong": "Q",
    "float": "f",
    "double": "d",
    "boolean": "?",
}
_DTYPE = {
    name: np.dtype(np.bool_ if letter == "?" else "<" + letter) for name, letter in _LETTER.items()
}
_TRAILING = 3
"""Bytes that some CDR writers add at the end to fill a word."""


def writer(tree: formats.Format) -> Callable[[Any], list[Buffer]]:
    """The function that turns a value of the format into the pieces of its payload."""
    return _Writer(tree).function()


def reader(tree: formats.Format) -> Callable[[Buffer], Any]:
    """The function that turns a payload of the format into its value."""
    return _Reader(tree).function()


class _Generator:
    """What writer and reader generation share: lines, constants, and the position as far as known.

    `self.offset` is the position behind the encapsulation header while it is the same for all
    values; from the first part of variable length on it is None and the generated code keeps it in
    the local variable `at`. `self.run` are numbers that wait for one struct call, `self.unchecked`
    the enums among them.
    """

    arguments = ""

    def __init__(self, tree: formats.Format) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = {"pad": [bytes(n) for n in range(8)]}
        self.indent = 1
        self.offset: int | None = 0
        self.run: list[tuple[str, str]] = []
        self.counter = 0
        self.unchecked: list[tuple[str, int]] = []
        self.root = tree

    def function(self) -> Callable[[Any], Any]:
        self.body()
        source = f"def generated({self.arguments}):\n" + "\n".join(self.lines)
        exec(compile(source, "<codec>", "exec"), self.names)
        generated: Callable[[Any], Any] = self.names["generated"]
        return generated

    def body(self) -> None:
        raise AssertionError

    def emit(self, line: str) -> None:
        self.lines.append("    " * self.indent + line)

    def fresh(self, stem: str) -> str:
        self.counter += 1
        return f"{stem}{self.counter}"

    def constant(self, stem: str, value: Any) -> str:
        name = self.fresh(stem)
        self.names[name] = value
        return name

    def go_dynamic(self) -> None:
        """From here on the position is only known at run time."""
        if self.offset is not None:
            self.emit(f"at = {self.offset}")
            self.offset = None

    def run_struct(self) -> str:
        """A constant with the struct of the pending run: one, or one per position modulo 8."""
        letters = [letter for letter, _ in self.run]
        if self.offset is not None:
            compact = _aligned(letters, self.offset)
            self.offset += compact.size
            return self.constant("run", compact)
        return self.constant("run", [_aligned(letters, start) for start in range(8)])


def _aligned(letters: Sequence[str], start: int) -> struct.Struct:
    """The struct of these numbers when the first byte free for it has position `start`."""
    text, at = "<", start
    for letter in letters:
        size = struct.calcsize("<" + letter)
        text += "x" * (-at % size) + letter
        at += -at % size + size
    return struct.Struct(text)


class _Writer(_Generator):
    """Generates the function value -> pieces."""

    arguments = "value"

    def body(self) -> None:
        self.names |= {
            "array": _array,
            "ndarray": np.ndarray,
            "text": _text,
            "flag": _flag,
            "index": operator.index,
            "check": _check_length,
        }
        self.emit(f"parts = [{ENCAPSULATION!r}]")
        self.emit("put = parts.append")
        self.write(self.root, "value")
        self.flush()
        self.emit("return parts")

    def flush(self) -> None:
        if not self.run:
            return
        values = ", ".join(value for _, value in self.run)
        dynamic = self.offset is None
        name = self.run_struct()
        if dynamic:
            self.emit(f"s = {name}[at & 7]")
            self.emit(f"put(s.pack({values}))")
            self.emit("at += s.size")
        else:
            self.emit(f"put({name}.pack({values}))")
        self.run = []

    def write(self, node: formats.Format, value: str) -> None:
        if isinstance(node, formats.Primitive):
            if node.name == "string":
                self.write_string(value)
            else:
                given = f"flag({value})" if node.name == "boolean" else value
                self.run.append((_LETTER[node.name], given))
        elif isinstance(node, formats.Enum):
            self.emit(f"if not 0 <= {value} <= {node.largest}:")
            self.emit(f"    raise ValueError(f'enum value {{{value}}} is not 0 to {node.largest}')")
            self.run.append(("i", value))
        elif isinstance(node, formats.Struct):
            self.write_struct(node, value)
        elif isinstance(node, formats.FixedArray):
            self.write_elements(node.element, value, str(node.count), node.dimensions)
        elif isinstance(node, formats.Pointer):
            self.write_pointer(node, value)
        else:
            raise AssertionError(node)

    def write_struct(self, node: formats.Struct, value: str) -> None:
        own = self.fresh("v")
        self.emit(f"{own} = {value}")
        length = len(node.members)
        self.emit(f"if {own}.__class__ is not tuple or len({own}) != {length}:")
        self.emit(f"    check({own}, {length})")
        for index, member in enumerate(node.members):
            if isinstance(member, formats.VariableArray):
                members = (f"index({own}[{number - 1}])" for number in member.size_members)
                count = self.fresh("n")
                self.emit(f"{count} = {' * '.join(members)}")
                self.run.append(("I", count))
                self.write_elements(member.element, f"{own}[{index}]", count, None)
            else:
                self.write(member, f"{own}[{index}]")

    def write_string(self, value: str) -> None:
        local = self.fresh("t")
        self.emit(f"{local} = text({value})")
        self.run.append(("I", f"len({local})"))
        self.flush()
        self.go_dynamic()
        self.emit(f"put({local})")
        self.emit(f"at += len({local})")

    def write_elements(
        self, element: formats.Format, value: str, count: str, dimensions: tuple[int, ...] | None
    ) -> None:
        self.flush()
        if isinstance(element, formats.Primitive) and element.name != "string":
            self.write_numbers(element, value, count, dimensions)
            return
        items, item = self.fresh("v"), self.fresh("v")
        self.emit(f"{items} = {value}")
        self.emit(f"check({items}, {count})")
        self.go_dynamic()
        self.emit(f"for {item} in {items}:")
        self.indent += 1
        self.write(element, item)
        self.flush()
        self.indent -= 1

    def write_numbers(
        self, element: formats.Primitive, value: str, count: str, dimensions: tuple[int, ...] | None
    ) -> None:
        dtype = _DTYPE[element.name]
        local, kind = self.fresh("a"), self.constant("dtype", dtype)
        self.emit(f"{local} = {value}")
        # What nearly always comes needs no call.
        self.emit(f"if {local}.__class__ is not ndarray or {local}.dtype is not {kind} or \\")
        self.emit(f"        {local}.shape != ({count},) or not {local}.flags.c_contiguous:")
        self.emit(f"    {local} = array({local}, {kind}, {count}, {dimensions})")
        if self.offset is not None and dimensions is not None:
            gap = -self.offset % dtype.itemsize
            if gap:
                self.emit(f"put(pad[{gap}])")
            self.emit(f"put({local})")
            self.offset += gap + int(count) * dtype.itemsize
            return
        self.go_dynamic()
        self.emit(f"if {local}.size:")
        self.indent += 1
        if dtype.itemsize > 1:
            self.emit(f"gap = -at % {dtype.itemsize}")
            self.emit("put(pad[gap])")
            self.emit(f"at += gap + {local}.nbytes")
        else:
            self.emit(f"at += {local}.nbytes")
        self.emit(f"put({local}.data)")
        self.indent -= 1

    def write_pointer(self, node: formats.Pointer, value: str) -> None:
        local = self.fresh("v")
        self.emit(f"{local} = {value}")
        self.run.append(("I", f"{local} is not None"))
        self.flush()
        self.go_dynamic()
        self.emit(f"if {local} is not None:")
        self.indent += 1
        self.write(node.target, local)
        self.flush()
        self.indent -= 1


class _Reader(_Generator):
    """Generates the function payload -> value."""

    arguments = "payload"

    def body(self) -> None:
        self.names |= {
            "numbers": np.frombuffer,
            "count_of": struct.Struct("<I").unpack_from,
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
        self.run.append((_LETTER[name], local))
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
        dtype = _DTYPE[element.name]
        boolean = element.name == "boolean"
        kind = self.constant("dtype", _DTYPE["ubyte"] if boolean else dtype)
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


def _array(
    value: Any, dtype: np.dtype[Any], count: int, dimensions: tuple[int, ...] | None
) -> npt.NDArray[Any]:
    """`value` as a flat array; of several dimensions only in the shape that is wanted, if any."""
    if isinstance(value, (bytes, bytearray, memoryview)):
        array = np.frombuffer(value, dtype)
    else:
        # Of a list with numbers on both sides of 2**63 numpy would make floats.
        whole = dtype.kind in "iu" and dtype.itemsize == 8 and not isinstance(value, np.ndarray)
        array = np.ascontiguousarray(value, object if whole else None)
        if array.dtype != dtype:
            array = _cast(array, dtype)
        if array.ndim > 1 and dimensions not in (None, array.shape):
            text = f"an array of shape {array.shape} instead of {dimensions}"
            raise ValueError(text)
    if array.size != count:
        text = f"{array.size} elements instead of {count}"
        raise ValueError(text)
    return array.reshape(-1)


def _cast(array: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """`array` as another kind of number; floats may lose digits, nothing else may be lost."""
    if array.size == 0 or np.can_cast(array.dtype, dtype, "safe"):
        return array.astype(dtype)
    if array.dtype.kind not in "biufO":
        text = f"{array.dtype} elements are no {dtype}"
        raise TypeError(text)
    with np.errstate(invalid="ignore", over="ignore"):
        cast = array.astype(dtype)
    if array.dtype.kind == dtype.kind == "f":
        fits = bool((np.isfinite(cast) | ~np.isfinite(array)).all())
    else:
        fits = np.array_equal(cast, array)
    if not fits:
        text = f"{array.dtype} elements do not fit {dtype}"
        raise ValueError(text)
    return cast


def _flag(value: Any) -> Any:
    if not isinstance(value, (bool, np.bool_)) and value not in (0, 1):
        text = f"{value!r} is neither true nor false"
        raise ValueError(text)
    return value


def _flags(octets: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    """The booleans in these bytes; any other byte than 0 and 1 would be a broken boolean."""
    if octets.size and octets.max() > 1:
        _refuse("a boolean that is neither 0 nor 1")
    return octets.view(np.bool_)


def _text(value: str) -> bytes:
    encoded = value.encode() + b"\0"
    if encoded.find(b"\0") != len(encoded) - 1:
        text = "a string cannot hold the character NUL"
        raise ValueError(text)
    return encoded


def _string(payload: Buffer, start: int, count: int) -> str:
    if count == 0:
        return ""
    raw = bytes(payload[start : start + count])
    if len(raw) != count or raw.find(b"\0") != count - 1:
        _refuse("a string that does not end where it says")
    return raw[:-1].decode()


def _check_length(value: Sequence[Any], count: int) -> None:
    if isinstance(value, (str, bytes)):
        text = f"{type(value).__name__} instead of a sequence of {count} values"
        raise TypeError(text)
    if len(value) != count:
        text = f"{len(value)} values instead of {count}"
        raise ValueError(text)


def _refuse(reason: str) -> None:
    raise ValueError(reason)
