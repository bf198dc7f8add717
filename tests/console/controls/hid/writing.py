"""Writes report descriptors and reports, to be read by the code under test."""

from __future__ import annotations

from collections.abc import Iterable

PAGE, MINIMUM, MAXIMUM, SIZE, REPORT_ID, COUNT, PUSH, POP = (
    0x04,
    0x14,
    0x24,
    0x74,
    0x84,
    0x94,
    0xA4,
    0xB4,
)
USAGE, USAGE_MINIMUM, USAGE_MAXIMUM, DELIMITER = 0x08, 0x18, 0x28, 0xA8
INPUT, COLLECTION, END = 0x80, 0xA0, 0xC0
CONSTANT, VARIABLE, RELATIVE, NULL = 1, 2, 4, 64
APPLICATION, LOGICAL = 1, 2


def item(prefix: int, value: int | None = None, size: int | None = None) -> bytes:
    """An item with the shortest data that holds the value, or with so many bytes; without none."""
    if value is None:
        return bytes([prefix])
    for code, length in ((1, 1), (2, 2), (3, 4)):
        if size in (None, length):
            try:
                data = value.to_bytes(length, "little", signed=value < 0)
            except OverflowError:
                continue
            return bytes([prefix | code]) + data
    raise OverflowError(value)


def signed_item(prefix: int, value: int) -> bytes:
    """An item whose data is read as a two's complement, so with room for the sign."""
    for code, length in ((1, 1), (2, 2), (3, 4)):
        try:
            return bytes([prefix | code]) + value.to_bytes(length, "little", signed=True)
        except OverflowError:
            continue
    raise OverflowError(value)


def application(*parts: bytes, usage: int = 4, page: int = 1) -> bytes:
    """A collection that is a joystick, or what else the usage says."""
    start = item(PAGE, page) + item(USAGE, usage) + item(COLLECTION, APPLICATION)
    return start + b"".join(parts) + item(END)


def axis(
    usage: int = 0x30,
    *,
    size: int = 8,
    minimum: int = 0,
    maximum: int = 255,
    flags: int = VARIABLE,
    page: int = 1,
) -> bytes:
    """One field of one element."""
    return b"".join(
        (
            item(PAGE, page),
            signed_item(MINIMUM, minimum),
            item(MAXIMUM, maximum) if minimum >= 0 else signed_item(MAXIMUM, maximum),
            item(SIZE, size),
            item(COUNT, 1),
            item(USAGE, usage),
            item(INPUT, flags),
        )
    )


def padding(size: int) -> bytes:
    return item(SIZE, size) + item(COUNT, 1) + item(INPUT, CONSTANT)


def report(values: Iterable[tuple[int, int]], report_id: int | None = None) -> bytes:
    """Values with their lengths [bits] one after the other, from the lowest bit on."""
    bits = length = 0
    for value, size in values:
        bits |= (value & (1 << size) - 1) << length
        length += size
    start = b"" if report_id is None else bytes([report_id])
    return start + bits.to_bytes((length + 7) // 8, "little")
