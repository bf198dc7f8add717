"""Cells to terminal bytes: half blocks and characters, every row complete in itself.

A frame is laid out as a matrix of four-byte words, one token of the escape sequence each, padded
with zero bytes; one `bytes.translate` takes the padding and what was left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.blend import RGB_MASK
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.sgr import FORMS, NO_COLOUR, Form, Words, words

Flags = npt.NDArray[np.bool_]

_SPACE = 32
_REPLACEMENT = 0x3F  # question mark


_ROW_END = words([b"\x1b[0m", b"\n"])
_UPPER, _LOWER, _FULL, _BLANK = words(["▀".encode(), "▄".encode(), "█".encode(), b" "])
_LOW_BITS_OFF = np.uint32(0xFEFEFEFE)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Planes:
    """What is written; all of shape (rows, columns).

    Attributes:
        foreground: Colours, only the bytes that count.
        background: The same.
        marks: The characters in UTF-8.
        ink_shows: Where the foreground can be seen.
        ground_shows: Where the background can be seen.
    """

    foreground: Words
    background: Words
    marks: Words
    ink_shows: Flags
    ground_shows: Flags


class RowEncoder:
    """Turns cells into rows of bytes; keeps its buffers between frames of the same size.

    A row begins and ends with the terminal's attributes reset, does not move the cursor, and takes
    exactly as many cells as the frame has columns.
    """

    def __init__(self) -> None:
        self._buffer: Words = np.zeros((0, 0), np.uint32)
        self._order: npt.NDArray[np.intp] = np.zeros(0, np.intp)

    def encode(
        self, cells: Cells, numbers: npt.NDArray[np.intp] | Sequence[int] | None = None
    ) -> list[bytes]:
        """One piece of bytes a row, UTF-8.

        Args:
            cells: The frame.
            numbers: Which rows, in this order; None for all.
        """
        return self._joined(cells, numbers).split(b"\n")[:-1]

    def encode_text(
        self, cells: Cells, numbers: npt.NDArray[np.intp] | Sequence[int] | None = None
    ) -> list[str]:
        """The rows of `encode` as strings."""
        return self._joined(cells, numbers).decode().split("\n")[:-1]

    def _joined(self, cells: Cells, numbers: npt.NDArray[np.intp] | Sequence[int] | None) -> bytes:
        """All rows, each ended by a line feed, which no cell can hold."""
        form = FORMS[cells.depth]
        planes = _planes(cells, numbers, form)
        rows, columns = (int(length) for length in planes.marks.shape)
        if not rows or not columns:
            return b"\x1b[0m\n" * rows
        length = len(form.cell)
        self._fit(rows, columns, length)
        told = planes.ink_shows & (form.foreground != slice(0))
        new_ink = self._new(planes.foreground, told, NO_COLOUR)
        new_ground = self._new(planes.background, planes.ground_shows, form.at_start)
        cell = self._buffer[:, : -len(_ROW_END)].reshape(rows, columns, length)
        cell[...] = form.cell
        cell[..., form.ink] = _told(planes.foreground, form.ink_words, form.counts)
        cell[..., form.ground] = _told(planes.background, form.ground_words, form.counts)
        cell[..., -1] = planes.marks
        _clear(cell, ~new_ink, form.foreground)
        _clear(cell, ~new_ground, form.background)
        _clear(cell, ~(new_ink | new_ground), slice(0, length - 1, length - 2))
        reset = planes.background[:, -1] != form.at_start
        self._buffer[:, -len(_ROW_END)] = np.where(reset, _ROW_END[0], 0)
        joined: bytes = self._buffer.tobytes().translate(None, b"\0")
        return joined

    def _fit(self, rows: int, columns: int, length: int) -> None:
        width = columns * length + len(_ROW_END)
        if self._buffer.shape != (rows, width) or len(self._order) != columns:
            self._buffer = np.zeros((rows, width), np.uint32)
            self._buffer[:, -len(_ROW_END) :] = _ROW_END
            self._order = np.arange(columns)

    def _new(self, colours: Words, shows: Flags, at_start: np.uint32) -> Flags:
        """Where a colour must be set: cells that show none leave the last one in force."""
        new = shows.copy()
        before = colours[:, :-1]
        if not shows.all():
            colours[~shows[:, 0], 0] = at_start
            last = np.where(shows, self._order, 0)
            np.maximum.accumulate(last, axis=1, out=last)
            before = np.take_along_axis(colours, last, axis=1)[:, :-1]
        new[:, 0] &= colours[:, 0] != at_start
        new[:, 1:] &= colours[:, 1:] != before
        return new


def changed_rows(previous: Cells | None, current: Cells) -> npt.NDArray[np.intp]:
    """Numbers of the rows that look different, all when there was no frame of the same kind."""
    if (
        previous is None
        or previous.depth is not current.depth
        or previous.glyphs.shape != current.glyphs.shape
    ):
        return np.arange(current.rows)
    same_rows = 2 * current.columns
    pixels = (_packed(previous.pixels) ^ _packed(current.pixels)) & RGB_MASK
    differs = pixels.reshape(current.rows, same_rows).any(axis=1)
    differs |= (previous.glyphs != current.glyphs).any(axis=1)
    ink = (_packed(previous.ink) ^ _packed(current.ink)) & RGB_MASK
    differs |= ((ink != 0) & (current.glyphs != 0)).any(axis=1)
    return np.flatnonzero(differs)


def _planes(
    cells: Cells, numbers: npt.NDArray[np.intp] | Sequence[int] | None, form: Form
) -> _Planes:
    pixels = _packed(cells.pixels)
    upper, lower, glyphs, ink = pixels[0::2], pixels[1::2], cells.glyphs, _packed(cells.ink)
    if numbers is not None:
        chosen = np.asarray(numbers, np.intp)
        upper, lower, glyphs, ink = (plane[chosen] for plane in (upper, lower, glyphs, ink))
    first, second = upper & form.mask, lower & form.mask
    foreground, background = first, second
    ink_shows = first != second
    ground_shows = np.ones_like(ink_shows)
    marks = np.where(ink_shows, _UPPER, _BLANK)
    if cells.depth is not ColourDepth.TRUECOLOUR:
        # With few colours, the same two often lie the other way round in the next cell.
        foreground, background = np.maximum(first, second), np.minimum(first, second)
        marks[first < second] = _LOWER
        full = ~ink_shows & (first >= form.bright)
        marks[full] = _FULL
        ink_shows[full] = True
        background[full] = 0
        ground_shows[full] = form.at_start != NO_COLOUR
    place = np.nonzero(glyphs)
    if place[0].size:
        above, below = first[place], second[place]
        background[place] = (above & below) + (((above ^ below) & _LOW_BITS_OFF) >> 1)
        foreground[place] = ink[place] & form.mask
        ink_shows[place] = glyphs[place] != _SPACE
        ground_shows[place] = True
        marks[place] = _utf8(glyphs[place])
    return _Planes(
        foreground=foreground,
        background=background,
        marks=marks,
        ink_shows=ink_shows,
        ground_shows=ground_shows,
    )


def _packed(pixels: npt.NDArray[np.uint8]) -> Words:
    """Pixels of shape (h, w, 4) as words of shape (h, w)."""
    words: Words = np.ascontiguousarray(pixels).view(np.uint32)[..., 0]
    return words


def _told(colours: Words, told: Words, counts: slice) -> Words:
    """What tells each byte that counts of every colour, shape (rows, columns, bytes)."""
    parts = np.ascontiguousarray(colours).view(np.uint8).reshape(*colours.shape, 4)
    return told.take(parts[..., counts], mode="clip")


def _clear(cell: Words, where: Flags, parts: slice) -> None:
    rows, columns = np.nonzero(where)
    if rows.size:
        cell[rows, columns, parts] = 0


def _utf8(code_points: Words) -> Words:
    """Each code point in UTF-8, padded with zero bytes; "?" for what a terminal must not get."""
    points = code_points.astype(np.uint32)
    control = (points < _SPACE) | ((points >= 0x7F) & (points < 0xA0))
    surrogate = (points >= 0xD800) & (points < 0xE000)
    points[control | surrogate | (points > 0x10FFFF)] = _REPLACEMENT
    coded = np.zeros((points.size, 4), np.uint8)
    limits = (0, 0x80, 0x800, 0x10000, 0x110000)
    for length, lead in enumerate((0x00, 0xC0, 0xE0, 0xF0), start=1):
        chosen = np.flatnonzero((points >= limits[length - 1]) & (points < limits[length]))
        for index in range(length):
            bits = points[chosen] >> (6 * (length - 1 - index))
            coded[chosen, index] = (lead | bits) if index == 0 else (0x80 | (bits & 0x3F))
    return coded.view(np.uint32)[:, 0]
