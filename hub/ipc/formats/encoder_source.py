"""Generates the function from a value of one format to the pieces of its payload."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES, ENCAPSULATION, LETTERS, Buffer, Generator, packed

_SMALL = 1024
"""Longest array that is copied into the struct around it [bytes]."""


def writer(tree: formats.Format) -> Callable[[Any], list[Buffer]]:
    """The function from a value of the format to the pieces of its payload."""
    return _Writer(tree).function()


class _Writer(Generator):
    """Generates the function value -> pieces."""

    arguments = "value"

    def body(self) -> None:
        self.names |= {
            "array": _array,
            "row": _row,
            "ndarray": np.ndarray,
            "text": _text,
            "flag": _flag,
            "index": operator.index,
            "check": _check_length,
            "count_of": _count_of,
            "nodes_of": _nodes_of,
        }
        self.emit(f"parts = [{ENCAPSULATION[self.order]!r}]")
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
                self.run.append((packed(LETTERS[node.name]), given))
        elif isinstance(node, formats.Enum):
            self.emit(f"if not 0 <= {value} <= {node.largest}:")
            self.emit(f"    raise ValueError(f'enum value {{{value}}} is not 0 to {node.largest}')")
            self.run.append((packed("i"), value))
        elif isinstance(node, formats.Struct):
            self.write_struct(node, value)
        elif isinstance(node, formats.FixedArray):
            self.write_elements(node.element, value, str(node.count), node.dimensions)
        elif isinstance(node, formats.Pointer):
            self.write_pointer(node, value)
        else:
            raise AssertionError(node)

    def write_struct(self, node: formats.Struct, value: str) -> None:
        if node.next_place is not None:
            self.write_list(node, value, fewest=1)
            return
        own = self.fresh("v")
        self.emit(f"{own} = {value}")
        length = len(node.members)
        self.emit(f"if {own}.__class__ is not tuple or len({own}) != {length}:")
        self.emit(f"    check({own}, {length})")
        self.write_members(node, own)

    def write_members(self, node: formats.Struct, own: str) -> None:
        for index, member in enumerate(node.members):
            if isinstance(member, formats.VariableArray) and not member.size_members:
                self.write_sequence(member.element, f"{own}[{index}]")
            elif isinstance(member, formats.VariableArray):
                count = self.fresh("n")
                sizes = [f"{own}[{number - 1}]" for number in member.size_members]
                if len(sizes) == 1:
                    self.emit(f"{count} = index({sizes[0]})")
                else:
                    self.emit(f"{count} = count_of({', '.join(sizes)})")
                self.run.append((packed("I"), count))
                self.write_elements(member.element, f"{own}[{index}]", count, None)
            elif not isinstance(member, formats.SelfPointer):
                self.write(member, f"{own}[{index}]")

    def write_sequence(self, element: formats.Format, value: str) -> None:
        """Write elements whose number no other member has."""
        items, count = self.fresh("v"), self.fresh("n")
        if isinstance(element, formats.Primitive) and element.name != "string":
            value = f"row({value}, {self.constant('dtype', DTYPES[element.name])})"
        self.emit(f"{items} = {value}")
        self.emit(f"{count} = len({items})")
        self.run.append((packed("I"), count))
        self.write_elements(element, items, count, None)

    def write_list(self, node: formats.Struct, value: str, fewest: int) -> None:
        nodes, item = self.fresh("v"), self.fresh("v")
        length = len(node.members)
        self.emit(f"{nodes} = nodes_of({value}, {node.next_place}, {length}, {fewest})")
        self.run.append((packed("I"), f"len({nodes})"))
        self.flush()
        self.go_dynamic()
        with self.block(f"for {item} in {nodes}:"):
            self.write_members(node, item)
            self.flush()

    def write_string(self, value: str) -> None:
        local = self.fresh("t")
        self.emit(f"{local} = text({value})")
        self.run.append((packed("I"), f"len({local})"))
        self.flush()
        self.go_dynamic()
        self.emit(f"put({local})")
        self.emit(f"at += len({local})")

    def write_elements(
        self, element: formats.Format, value: str, count: str, dimensions: tuple[int, ...] | None
    ) -> None:
        if isinstance(element, formats.Primitive) and element.name != "string":
            size = DTYPES[element.name].itemsize
            if dimensions is not None and int(count) * size <= _SMALL:
                self.write_small_array(element, value, int(count), dimensions)
            else:
                self.flush()
                self.write_numbers(element, value, count, dimensions)
            return
        self.flush()
        items, item = self.fresh("v"), self.fresh("v")
        self.emit(f"{items} = {value}")
        self.emit(f"check({items}, {count})")
        self.go_dynamic()
        with self.block(f"for {item} in {items}:"):
            self.write(element, item)
            self.flush()

    def write_small_array(
        self, element: formats.Primitive, value: str, count: int, dimensions: tuple[int, ...]
    ) -> None:
        """Write it as bytes among the numbers: one more copy, but fewer pieces to join."""
        dtype = DTYPES[element.name]
        local, kind = self.fresh("a"), self.constant("dtype", dtype)
        self.emit(f"{local} = {value}")
        self.emit(f"if {local}.__class__ is not ndarray or {local}.dtype is not {kind} or \\")
        self.emit(f"        {local}.shape != {dimensions}:")
        self.emit(f"    {local} = array({local}, {kind}, {count}, {dimensions})")
        nbytes = count * dtype.itemsize
        self.run.append(((f"{nbytes}s", dtype.itemsize), f"{local}.tobytes()"))

    def write_numbers(
        self, element: formats.Primitive, value: str, count: str, dimensions: tuple[int, ...] | None
    ) -> None:
        dtype = DTYPES[element.name]
        local, kind = self.fresh("a"), self.constant("dtype", dtype)
        self.emit(f"{local} = {value}")
        # The usual case needs no call.
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
        with self.block(f"if {local}.size:"):
            if dtype.itemsize > 1:
                self.emit(f"gap = -at % {dtype.itemsize}")
                self.emit("put(pad[gap])")
                self.emit(f"at += gap + {local}.nbytes")
            else:
                self.emit(f"at += {local}.nbytes")
            self.emit(f"put({local}.data)")

    def write_pointer(self, node: formats.Pointer, value: str) -> None:
        if isinstance(node.target, formats.Struct) and node.target.next_place is not None:
            self.write_list(node.target, value, fewest=0)
            return
        local = self.fresh("v")
        self.emit(f"{local} = {value}")
        self.run.append((packed("I"), f"{local} is not None"))
        self.flush()
        self.go_dynamic()
        with self.block(f"if {local} is not None:"):
            self.write(node.target, local)
            self.flush()


def _row(value: Any, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """`value` as a flat array of any length."""
    len(value)  # refuses a single number: numpy would make an array of it
    return _array(value, dtype, None, None)


def _array(
    value: Any, dtype: np.dtype[Any], count: int | None, dimensions: tuple[int, ...] | None
) -> npt.NDArray[Any]:
    """`value` as a flat array; an array of several dimensions needs the given shape, if any."""
    if isinstance(value, (bytes, bytearray, memoryview)):
        array = np.frombuffer(value, dtype)
    else:
        # From a list with numbers on both sides of 2**63 numpy would make floats.
        whole = dtype.kind in "iu" and dtype.itemsize == 8 and not isinstance(value, np.ndarray)
        array = np.ascontiguousarray(value, object if whole else None)
        if array.dtype != dtype:
            array = _cast(array, dtype)
        if array.ndim > 1 and dimensions not in (None, array.shape):
            text = f"an array of shape {array.shape} instead of {dimensions}"
            raise ValueError(text)
    if count is not None and array.size != count:
        text = f"{array.size} elements instead of {count}"
        raise ValueError(text)
    return array.reshape(-1)


def _cast(array: npt.NDArray[Any], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """`array` as another kind of number; only floats may lose digits."""
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


def _text(value: str) -> bytes:
    encoded = value.encode() + b"\0"
    if encoded.find(b"\0") != len(encoded) - 1:
        text = "a string cannot hold the character NUL"
        raise ValueError(text)
    return encoded


def _count_of(*sizes: Any) -> int:
    """The number of elements of an array with these sizes."""
    lengths = [operator.index(size) for size in sizes]
    if min(lengths) < 0:
        text = f"sizes of {lengths} elements"
        raise ValueError(text)
    return math.prod(lengths)


def _nodes_of(value: Any, next_place: int, length: int, fewest: int) -> list[Any]:
    """The nodes of a linked list, first to last; `length` values each."""
    nodes: list[Any] = []
    while value is not None:
        if len(nodes) == formats.MAX_NODES:
            text = f"a list longer than {formats.MAX_NODES} nodes, or one that runs in a circle"
            raise ValueError(text)
        _check_length(value, length)
        nodes.append(value)
        value = value[next_place]
    if len(nodes) < fewest:
        text = "None instead of the first node of a list"
        raise ValueError(text)
    return nodes


def _check_length(value: Sequence[Any], count: int) -> None:
    if isinstance(value, (str, bytes)):
        text = f"{type(value).__name__} instead of a sequence of {count} values"
        raise TypeError(text)
    if len(value) != count:
        text = f"{len(value)} values instead of {count}"
        raise ValueError(text)
