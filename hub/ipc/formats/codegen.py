"""Common parts of the generators of a format's encoder and decoder.

`codec` describes the payloads; a generator turns a Format tree into Python source.
"""

from __future__ import annotations

import abc
import contextlib
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from hub.ipc.formats import grammar as formats

Buffer = bytes | bytearray | memoryview
Order = Literal["<", ">"]
"""Little-endian or big-endian, as `struct` spells it."""

ENCAPSULATION: Mapping[Order, bytes] = {"<": b"\x00\x01\x00\x00", ">": b"\x00\x00\x00\x00"}
"""The first bytes of a payload, by byte order."""

LETTERS = {
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
DTYPES = {
    name: np.dtype(np.bool_ if letter == "?" else "<" + letter) for name, letter in LETTERS.items()
}


Packed = tuple[str, int]
"""Letters of a `struct` for a number or for the bytes of several, and their alignment [bytes]."""


def packed(letter: str) -> Packed:
    """A number in a struct, aligned to its size."""
    return letter, struct.calcsize("<" + letter)


class Generator(abc.ABC):
    """Lines, constants, and the position as far as it is constant.

    `self.offset` is the position behind the encapsulation header. After the first part of variable
    length it is None, and the generated code keeps the position in the local variable `at`.
    `self.run` holds numbers for one struct call, and `self.afterwards` the lines behind that call.
    """

    arguments = ""

    def __init__(self, tree: formats.Format, order: Order = "<") -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = {"pad": [bytes(n) for n in range(8)]}
        self.indent = 1
        self.offset: int | None = 0
        self.run: list[tuple[Packed, str]] = []
        self.counter = 0
        self.afterwards: list[str] = []
        self.root = tree
        self.order = order

    def function(self) -> Callable[[Any], Any]:
        """The finished function."""
        self.body()
        source = f"def generated({self.arguments}):\n" + "\n".join(self.lines)
        exec(compile(source, "<codec>", "exec"), self.names)
        generated: Callable[[Any], Any] = self.names["generated"]
        return generated

    @abc.abstractmethod
    def body(self) -> None:
        """Generate all lines."""

    def emit(self, line: str) -> None:
        """Add one line."""
        self.lines.append("    " * self.indent + line)

    @contextlib.contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Indent the lines under a `for` or an `if`."""
        self.emit(head)
        self.indent += 1
        yield
        self.indent -= 1

    def fresh(self, stem: str) -> str:
        """An unused name."""
        self.counter += 1
        return f"{stem}{self.counter}"

    def constant(self, stem: str, value: Any) -> str:
        """The function's name for a value."""
        name = self.fresh(stem)
        self.names[name] = value
        return name

    def go_dynamic(self) -> None:
        """Keep the position at run time from here on."""
        if self.offset is not None:
            self.emit(f"at = {self.offset}")
            self.offset = None

    def run_struct(self) -> str:
        """A constant with the struct of the pending run, or with one per position modulo 8."""
        run = [each for each, _ in self.run]
        if self.offset is not None:
            compact = struct.Struct(self.order + _padded(run, self.offset))
            self.offset += compact.size
            return self.constant("run", compact)
        each = [struct.Struct(self.order + _padded(run, start)) for start in range(8)]
        return self.constant("run", each)


def flat_letters(tree: formats.Format) -> str | None:
    """The padded letters of a body of numbers and structs of numbers; None for any other body."""
    letters = _number_letters(tree)
    return None if letters is None else _padded([packed(letter) for letter in letters], 0)


def _number_letters(node: formats.Format) -> list[str] | None:
    if isinstance(node, formats.Primitive) and node.name not in ("boolean", "string"):
        return [LETTERS[node.name]]
    if not isinstance(node, formats.Struct):
        return None
    letters: list[str] = []
    for member in node.members:
        inner = _number_letters(member)
        if inner is None:
            return None
        letters += inner
    return letters


def _padded(run: Sequence[Packed], start: int) -> str:
    """The letters of these numbers, with padding, from position `start`."""
    text, at = "", start
    for letters, alignment in run:
        gap = -at % alignment
        text += "x" * gap + letters
        at += gap + struct.calcsize("<" + letters)
    return text
