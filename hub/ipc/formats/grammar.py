"""The format-string grammar of CMU IPC: text to a Format tree and back.

format   := primitive | LENGTH | struct | enum | array | pointer
struct   := '{' [member {',' member}] '}'        member := format | sequence | '*!'
enum     := '{' 'enum' ':' LARGEST '}' | '{' 'enum' NAME {',' NAME} '}'
array    := '[' format ':' N {',' N} ']' | '[' N ':' format ']'
sequence := '<' format [':' I {',' I}] '>'       I: 1-based number of an integer member before it;
                                                 its length is the product of those members, or
                                                 any; only in Rune it may stand without them
pointer  := '*' format                           null or a value

'*!' makes its struct the node of a linked list: it is the next node, or null at the end.
LENGTH stands for [ubyte:LENGTH].
"""

from __future__ import annotations

import math
import re
from typing import NoReturn

from hub.errors import MessageFormatError
from hub.nearest import did_you_mean
from hub.values import dataclass

MAX_TEXT = 4096
MAX_DEPTH = 16
MAX_ELEMENTS = 1 << 24
MAX_DIMENSIONS = 8
MAX_NODES = 10_000
"""Most nodes of one linked list in a message."""
MAX_ITEMS = 1 << 20
"""Most elements of arrays in a message that are no numbers; each takes far more memory there."""

INTEGERS = ("byte", "ubyte", "char", "short", "ushort", "int", "uint", "long", "ulong")
PRIMITIVES = (*INTEGERS, "float", "double", "boolean", "string")

_TOKEN = re.compile(r"[ \t\n\r\f]*(?:(\*!|[{}\[\]<>,:*])|([A-Za-z_]\w*)|(\d+))", re.ASCII)
_BLANK = re.compile(r"[ \t\n\r\f]*")


@dataclass(frozen=True, slots=True)
class Primitive:
    """A number, a boolean or a string; `name` is one of `PRIMITIVES`."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class Enum:
    """A number from 0 to `largest`, with or without names."""

    largest: int
    names: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "{enum " + ",".join(self.names) + "}" if self.names else f"{{enum:{self.largest}}}"


@dataclass(frozen=True, slots=True)
class Struct:
    """Members in sequence."""

    members: tuple[Format, ...]

    @property
    def next_place(self) -> int | None:
        """Index of the self pointer; None: the struct is no node of a linked list."""
        return self.members.index(SelfPointer()) if SelfPointer() in self.members else None

    def __str__(self) -> str:
        return "{" + ",".join(map(str, self.members)) + "}"


@dataclass(frozen=True, slots=True)
class FixedArray:
    """Elements, as many as the product of `dimensions`, last index fastest."""

    element: Format
    dimensions: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of elements."""
        return math.prod(self.dimensions)

    def __str__(self) -> str:
        return f"[{self.element}:{','.join(map(str, self.dimensions))}]"


@dataclass(frozen=True, slots=True)
class VariableArray:
    """Elements, as many as the product of the struct's members numbered in `size_members`.

    Without size members it has any number of elements: a sequence as ROS 2 has them.
    """

    element: Format
    size_members: tuple[int, ...]

    def __str__(self) -> str:
        sizes = ",".join(map(str, self.size_members))
        return f"<{self.element}:{sizes}>" if sizes else f"<{self.element}>"


@dataclass(frozen=True, slots=True)
class Pointer:
    """Null, or one value of `target`."""

    target: Format

    def __str__(self) -> str:
        return f"*{self.target}"


@dataclass(frozen=True, slots=True)
class SelfPointer:
    """Null, or the next node: another value of the same struct."""

    def __str__(self) -> str:
        return "*!"


Format = Primitive | Enum | Struct | FixedArray | VariableArray | Pointer | SelfPointer


def parse(text: str) -> Format:
    """The tree of a format string. Trees of equal formats are equal, however they are written.

    Raises:
        MessageFormatError: With the position and the reason.
    """
    parser = _Parser(text)
    tree = parser.format(1)
    if parser.token:
        parser.fail("a complete format must end here")
    if len(str(tree)) > MAX_TEXT:
        parser.fail(f"spelt out, it is longer than {MAX_TEXT} characters")
    return tree


class _Parser:
    """Recursive descent over the tokens of one text."""

    def __init__(self, text: str) -> None:
        if len(text) > MAX_TEXT:
            raise MessageFormatError(text, MAX_TEXT, f"longer than {MAX_TEXT} characters")
        self.text = text
        self.end = 0
        self.start = 0
        self.token = ""
        self.advance()

    def advance(self) -> str:
        """Return the present token, and move to the next."""
        passed = self.token
        match = _TOKEN.match(self.text, self.end)
        if match is None:
            blank = _BLANK.match(self.text, self.end)
            self.start = self.end = blank.end() if blank else self.end
            self.token = ""
            if self.start < len(self.text):
                self.fail(f"unexpected character {self.text[self.start]!r}")
            return passed
        self.token = match.group(match.lastindex or 0)
        self.end = match.end()
        self.start = self.end - len(self.token)
        return passed

    def fail(self, reason: str) -> NoReturn:
        raise MessageFormatError(self.text, self.start, reason)

    def expect(self, wanted: str) -> None:
        if self.token != wanted:
            self.fail(f"expected {wanted!r}, found {self.token or 'the end'!r}")
        self.advance()

    def format(self, depth: int) -> Format:
        if depth > MAX_DEPTH:
            self.fail(f"nested deeper than {MAX_DEPTH}")
        if self.token == "{":
            return self.braces(depth)
        if self.token == "[":
            return self.fixed_array(depth)
        if self.token == "*":
            self.advance()
            return Pointer(self.format(depth + 1))
        if self.token.isdigit():
            return FixedArray(Primitive("ubyte"), (self.number(1, MAX_ELEMENTS),))
        if self.token not in PRIMITIVES:
            self.fail_without_type()
        return Primitive(self.advance())

    def fail_without_type(self) -> NoReturn:
        if self.token in ("<", "*!"):
            what = "variable array" if self.token == "<" else "self pointer"
            self.fail(f"a {what} stands directly inside a struct")
        hint = did_you_mean(self.token, PRIMITIVES)
        self.fail(f"expected a type, found {self.token[:20] or 'the end'!r}{hint}")

    def braces(self, depth: int) -> Format:
        start = self.start
        self.expect("{")
        if self.token == "enum":
            self.advance()
            return self.enum()
        members: list[Format] = []
        while self.token != "}":
            if members:
                self.expect(",")
            members.append(self.member(depth, members))
        struct = Struct(tuple(members))
        if struct.next_place is not None:
            self.refuse_empty(struct, start)
        self.advance()
        return struct

    def member(self, depth: int, before: list[Format]) -> Format:
        if self.token == "<":
            return self.variable_array(depth, before)
        if self.token != "*!":
            return self.format(depth + 1)
        if SelfPointer() in before:
            self.fail("a struct with two self pointers would be no list")
        self.advance()
        return SelfPointer()

    def enum(self) -> Enum:
        if self.token == ":":
            self.advance()
            largest = self.number(0, 2**31 - 1)
            self.expect("}")
            return Enum(largest)
        names: list[str] = []
        while not names or self.token == ",":
            if names:
                self.advance()
            if not self.token.isidentifier():
                self.fail(f"expected a name of the enum, found {self.token or 'the end'!r}")
            if self.token in names:
                self.fail(f"the enum names {self.token!r} twice")
            names.append(self.advance())
        self.expect("}")
        return Enum(len(names) - 1, tuple(names))

    def fixed_array(self, depth: int) -> Format:
        self.expect("[")
        dimensions: list[int] = []
        if self.token.isdigit():
            dimensions.append(self.number(1, MAX_ELEMENTS))
            self.expect(":")
        start = self.start
        element = self.format(depth + 1)
        self.refuse_empty(element, start)
        if not dimensions:
            self.expect(":")
            dimensions.append(self.number(1, MAX_ELEMENTS))
            while self.token == ",":
                self.next_dimension(len(dimensions))
                dimensions.append(self.number(1, MAX_ELEMENTS))
        if math.prod(dimensions) * elements_of(element) > MAX_ELEMENTS:
            self.fail(f"more than {MAX_ELEMENTS} elements")
        self.expect("]")
        return FixedArray(element, tuple(dimensions))

    def variable_array(self, depth: int, before: list[Format]) -> Format:
        self.expect("<")
        start = self.start
        element = self.format(depth + 1)
        self.refuse_empty(element, start)
        if self.token == ">":
            self.advance()
            return VariableArray(element, ())
        self.expect(":")
        sizes = [self.size_member(before)]
        while self.token == ",":
            self.next_dimension(len(sizes))
            sizes.append(self.size_member(before))
        self.expect(">")
        return VariableArray(element, tuple(sizes))

    def next_dimension(self, count: int) -> None:
        if count == MAX_DIMENSIONS:
            self.fail(f"an array has at most {MAX_DIMENSIONS} dimensions")
        self.advance()

    def size_member(self, before: list[Format]) -> int:
        start = self.start
        number = self.number(1, 4096)
        if number > len(before) or not _is_integer(before[number - 1]):
            self.start = start
            self.fail(f"member {number} is no integer that stands before the array")
        return number

    def refuse_empty(self, element: Format, start: int) -> None:
        if elements_of(element) == 0:
            self.start = start
            self.fail("an array or a list of empty structs has no meaning")

    def number(self, smallest: int, largest: int) -> int:
        if not self.token.isdigit() or len(self.token) > 10:
            self.fail(f"expected a number, found {self.token[:20] or 'the end'!r}")
        if not smallest <= int(self.token) <= largest:
            self.fail(f"{self.token} is not between {smallest} and {largest}")
        return int(self.advance())


def _is_integer(node: Format) -> bool:
    return isinstance(node, Primitive) and node.name in INTEGERS


def elements_of(node: Format) -> int:
    """The least number of values in this format; 0 only for empty structs."""
    if isinstance(node, Struct):
        return sum(elements_of(member) for member in node.members)
    if isinstance(node, FixedArray):
        return node.count * elements_of(node.element)
    return 0 if isinstance(node, SelfPointer) else 1


def is_fixed_length(node: Format) -> bool:
    """Whether all values take the same space: no strings, pointers or variable arrays."""
    if isinstance(node, Struct):
        return all(is_fixed_length(member) for member in node.members)
    if isinstance(node, FixedArray):
        return is_fixed_length(node.element)
    if isinstance(node, Primitive):
        return node.name != "string"
    return isinstance(node, Enum)
