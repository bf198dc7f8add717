"""What generating the writer and the reader of one format's payloads has in common.

`codec` says what the payloads look like; a generator turns a Format tree into Python source.
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
"""What a payload starts with in each order of bytes."""

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
    """What writer and reader generation share: lines, constants, and the position as far as known.

    `self.offset` is the position behind the encapsulation header while it is the same for all
    values; from the first part of variable length on it is None and the generated code keeps it in
    the local variable `at`. `self.run` are numbers that wait for one struct call, and
    `self.afterwards` the lines that follow it.
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
        """Generate the whole of it."""

    def emit(self, line: str) -> None:
        """Add one line."""
        self.lines.append("    " * self.indent + line)

    @contextlib.contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Lines that belong under a `for` or an `if`."""
        self.emit(head)
        self.indent += 1
        yield
        self.indent -= 1

    def fresh(self, stem: str) -> str:
        """A name that is not in use."""
        self.counter += 1
        return f"{stem}{self.counter}"

    def constant(self, stem: str, value: Any) -> str:
        """The name under which the function knows a value."""
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
        run = [each for each, _ in self.run]
        if self.offset is not None:
            compact = struct.Struct(self.order + _padded(run, self.offset))
            self.offset += compact.size
            return self.constant("run", compact)
        each = [struct.Struct(self.order + _padded(run, start)) for start in range(8)]
        return self.constant("run", each)


def flat_letters(tree: formats.Format) -> str | None:
    """The padded letters of a whole body of nothing but numbers and structs of them, else None."""
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
    """The letters of these numbers when the first byte free for them has position `start`."""
    text, at = "", start
    for letters, alignment in run:
        gap = -at % alignment
        text += "x" * gap + letters
        at += gap + struct.calcsize("<" + letters)
    return text
