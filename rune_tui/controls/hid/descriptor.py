"""Report descriptors: the fields of input reports, as bits.

Sections 5 and 6.2.2 of the Device Class Definition for HID 1.11. What it leaves open is read as
Linux does, because devices are tried with that: unknown items are skipped, the fewer usages than
elements the more often the last one counts, of alternative usages the first one counts.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from typing import NoReturn

from hub.values import dataclass
from rune_tui.errors import DescriptorError

MAX_BYTES = 4096
"""Longest report descriptor; Linux reads no longer ones either [bytes]."""
MAX_REPORT_BYTES = 16384
"""Longest report that may be described [bytes]."""
MAX_DEPTH = 32
"""How deep collections, and pushed states, may be nested."""

_MAIN, _GLOBAL, _LOCAL = 0, 1, 2
_LONG_ITEM = 0xFE
_APPLICATION = 1
_CONSTANT, _VARIABLE, _RELATIVE, _NULL = 0x01, 0x02, 0x04, 0x40

Range = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class InputField:
    """Elements side by side in one input report; padding is no field.

    Attributes:
        report_id: Which report; 0 where reports have no ids.
        bit: Where the first element begins, after the byte of the report id [bits].
        size: Length of an element [bits].
        count: How many elements.
        usages: First and last usage of each range, as page * 65536 + usage: of the elements one
            after the other, or, in an array, what the values stand for.
        minimum: Least value that means something.
        maximum: Greatest one.
        application: Usage of the application collection around it; 0 if there is none.
        array: Whether the elements hold which of the usages are on, not a value each.
        relative: Whether values are changes since the last report.
        nullable: Whether values out of range mean "no value".
    """

    report_id: int
    bit: int
    size: int
    count: int
    usages: tuple[Range, ...]
    minimum: int
    maximum: int
    application: int
    array: bool
    relative: bool
    nullable: bool

    def usages_of_elements(self) -> Iterator[int]:
        """The usage of each element; for arrays that of each value from the minimum on."""
        wanted = self.count if not self.array else self.maximum - self.minimum + 1
        given, last = 0, 0
        for first, last in self.usages:
            for usage in range(first, min(last, first + wanted - given - 1) + 1):
                yield usage
                given += 1
        if not self.array:
            for _ in range(wanted - given):
                yield last


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportDescriptor:
    """The input reports of a device, by its descriptor.

    Attributes:
        fields: All fields in the descriptor's order.
        numbered: Whether each report begins with a byte that holds its id.
        bits: Length of each report without that byte, by id [bits].
    """

    fields: tuple[InputField, ...]
    numbered: bool
    bits: Mapping[int, int]


def parse(descriptor: bytes) -> ReportDescriptor:
    """Reads a descriptor of any bytes.

    Bytes behind the last collection are ignored: some devices pad there.

    Raises:
        DescriptorError: It cannot be read, or describes more than any real device has.
    """
    if len(descriptor) > MAX_BYTES:
        message = f"a report descriptor of {len(descriptor)} bytes, more than {MAX_BYTES}"
        raise DescriptorError(message)
    parser = _Parser()
    for place, kind, tag, data in _items(descriptor):
        parser.place = place
        if data is None:
            break
        parser.take(kind, tag, data)
    if parser.collections:
        message = f"the report descriptor ends within {len(parser.collections)} open collections"
        raise DescriptorError(message)
    return ReportDescriptor(
        fields=tuple(parser.fields),
        numbered=parser.numbered,
        bits=parser.bits,
    )


def _items(descriptor: bytes) -> Iterator[tuple[int, int, int, bytes | None]]:
    """Place, type, tag and data of each item; data None: the descriptor ends too early."""
    place, end = 0, len(descriptor)
    while place < end:
        prefix = descriptor[place]
        if prefix == _LONG_ITEM:
            place += 3 + descriptor[place + 1] if place + 1 < end else 3
            continue
        size = (0, 1, 2, 4)[prefix & 3]
        data = descriptor[place + 1 : place + 1 + size]
        yield place, prefix >> 2 & 3, prefix >> 4, data if len(data) == size else None
        place += 1 + size


def _signed(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)


def _unsigned(data: bytes) -> int:
    return int.from_bytes(data, "little")


@dataclass(slots=True)
class _Global:
    """Items that hold until they are set again."""

    page: int = 0
    minimum: int = 0
    maximum: bytes = b""
    size: int = 0
    count: int = 0
    report_id: int = 0


@dataclass(slots=True)
class _Local:
    """The state until the next main item; usages without a page have page None."""

    usages: list[tuple[int | None, int, int]] = field(default_factory=list)
    least: tuple[int | None, int] | None = None
    delimited: int = 0


class _Parser:
    """The state of a parse."""

    def __init__(self) -> None:
        self.fields: list[InputField] = []
        self.bits: dict[int, int] = {}
        self.collections: list[int] = []
        self.numbered = False
        self.place = 0
        self._global = _Global()
        self._pushed: list[_Global] = []
        self._local = _Local()
        self._takers: dict[tuple[int, int], Callable[[bytes], None]] = {
            (_MAIN, 8): self._input,
            (_MAIN, 10): self._collection,
            (_MAIN, 12): self._end_collection,
            (_GLOBAL, 0): self._page,
            (_GLOBAL, 1): self._minimum,
            (_GLOBAL, 2): self._maximum,
            (_GLOBAL, 7): self._size,
            (_GLOBAL, 8): self._report_id,
            (_GLOBAL, 9): self._count,
            (_GLOBAL, 10): self._push,
            (_GLOBAL, 11): self._pop,
            (_LOCAL, 0): self._usage,
            (_LOCAL, 1): self._usage_minimum,
            (_LOCAL, 2): self._usage_maximum,
            (_LOCAL, 10): self._delimiter,
        }

    def take(self, kind: int, tag: int, data: bytes) -> None:
        """Takes the next item."""
        taker = self._takers.get((kind, tag))
        if taker is not None:
            taker(data)
        if kind == _MAIN:
            self._local = _Local()

    def _fail(self, what: str) -> NoReturn:
        message = f"byte {self.place} of the report descriptor: {what}"
        raise DescriptorError(message)

    def _page(self, data: bytes) -> None:
        self._global.page = _unsigned(data) & 0xFFFF

    def _minimum(self, data: bytes) -> None:
        self._global.minimum = _signed(data)

    def _maximum(self, data: bytes) -> None:
        self._global.maximum = data

    def _size(self, data: bytes) -> None:
        self._global.size = _unsigned(data)

    def _count(self, data: bytes) -> None:
        self._global.count = _unsigned(data)

    def _report_id(self, data: bytes) -> None:
        self._global.report_id = _unsigned(data)
        if not 1 <= self._global.report_id <= 255:
            self._fail(f"report id {self._global.report_id} is not one of 1 to 255")
        self.numbered = True

    def _push(self, _: bytes) -> None:
        if len(self._pushed) >= MAX_DEPTH:
            self._fail(f"more than {MAX_DEPTH} pushed states")
        self._pushed.append(copy.copy(self._global))

    def _pop(self, _: bytes) -> None:
        if not self._pushed:
            self._fail("a pop without a push")
        self._global = self._pushed.pop()

    def _usage(self, data: bytes) -> None:
        page, usage = _paged(data)
        self._name(page, usage, usage)

    def _usage_minimum(self, data: bytes) -> None:
        self._local.least = _paged(data)

    def _usage_maximum(self, data: bytes) -> None:
        if self._local.least is not None:
            page, least = self._local.least
            self._local.least = None
            self._name(page, least, _unsigned(data) & 0xFFFF)

    def _name(self, page: int | None, first: int, last: int) -> None:
        if self._local.delimited == 0:
            self._local.usages.append((page, first, last))
        elif self._local.delimited == 1:
            self._local.usages.append((page, first, last))
            self._local.delimited = 2

    def _delimiter(self, data: bytes) -> None:
        self._local.delimited = 1 if _unsigned(data) else 0

    def _usages(self) -> tuple[Range, ...]:
        """The page is that of the main item, unless the usage itself has one."""
        bound = []
        for page, first, last in self._local.usages:
            upper = (self._global.page if page is None else page) << 16
            bound.append((upper | first, upper | last))
        return tuple(each for each in bound if each[0] <= each[1])

    def _collection(self, data: bytes) -> None:
        if len(self.collections) >= MAX_DEPTH:
            self._fail(f"collections are nested more than {MAX_DEPTH} deep")
        application = self.collections[-1] if self.collections else 0
        if _unsigned(data) == _APPLICATION:
            usages = self._usages()
            application = usages[0][0] if usages else 0
        self.collections.append(application)

    def _end_collection(self, _: bytes) -> None:
        if not self.collections:
            self._fail("the end of a collection that has not begun")
        self.collections.pop()

    def _input(self, data: bytes) -> None:
        state, flags = self._global, _unsigned(data)
        bit = self.bits.get(state.report_id, 0)
        end = bit + state.size * state.count
        if end > MAX_REPORT_BYTES * 8:
            self._fail(
                f"a report of {end} bits, more than {MAX_REPORT_BYTES * 8}: "
                f"{state.count} elements of {state.size} bits"
            )
        self.bits[state.report_id] = end
        usages = self._usages()
        if end == bit or flags & _CONSTANT or not usages:
            return
        # A maximum such as FF in one byte is meant without sign where no value is below zero.
        maximum = _unsigned(state.maximum) if state.minimum >= 0 else _signed(state.maximum)
        self.fields.append(
            InputField(
                report_id=state.report_id,
                bit=bit,
                size=state.size,
                count=state.count,
                usages=usages,
                minimum=state.minimum,
                maximum=maximum,
                application=self.collections[-1] if self.collections else 0,
                array=not flags & _VARIABLE,
                relative=bool(flags & _RELATIVE),
                nullable=bool(flags & _NULL),
            )
        )


def _paged(data: bytes) -> tuple[int | None, int]:
    """Page, if the item has one of its own, and usage."""
    number = _unsigned(data)
    return (number >> 16 if len(data) == 4 else None), number & 0xFFFF
