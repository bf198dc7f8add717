"""Cells to terminal bytes: exact truecolour half blocks, every row complete in itself.

A frame is laid out as a matrix of four-byte words, one token of the escape sequence each, padded
with zero bytes; one `bytes.translate` takes the padding and what was left out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.blend import RGB_MASK
from rune_tui.compositor.cells import Cells

Words = npt.NDArray[np.uint32]

_SPACE = 32
_UPPER_HALF = 0x2580
_REPLACEMENT = 0x3F  # question mark


def _words(tokens: Sequence[bytes]) -> Words:
    """Tokens of up to four bytes as words that read the same in memory."""
    return np.frombuffer(b"".join(token.ljust(4, b"\0") for token in tokens), np.uint32)


_DIGITS = _words([b";%d" % value for value in range(256)])
# Where the parts of a cell stand: ESC[ 38;2 ;R ;G ;B ; 48;2 ;R ;G ;B m glyph
_CELL = _words([b"\x1b[", b"38;2", b"", b"", b"", b";", b"48;2", b"", b"", b"", b"m", b""])
# The semicolon between the colours goes with either of them.
_FOREGROUND, _BACKGROUND = slice(1, 6), slice(5, 10)
_FOREGROUND_DIGITS, _BACKGROUND_DIGITS = slice(2, 5), slice(7, 10)
_AROUND = slice(0, 11, 10)  # the introducer and the final letter
_GLYPH = 11
_ROW_END = _words([b"\x1b[0m", b"\n"])
_HALF_BLOCK, _BLANK = _words(["▀".encode(), b" "])
_NO_COLOUR = np.uint32(0xFFFFFFFF)
_LOW_BITS_OFF = np.uint32(0xFEFEFEFE)


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
        foreground, background, marks, blank = _planes(cells, numbers)
        rows, columns = (int(length) for length in foreground.shape)
        if not rows or not columns:
            return b"\x1b[0m\n" * rows
        self._fit(rows, columns)
        new_ink = self._new_foreground(foreground, blank)
        new_ground = np.ones((rows, columns), bool)
        np.not_equal(background[:, 1:], background[:, :-1], out=new_ground[:, 1:])
        words = self._buffer[:, : -len(_ROW_END)].reshape(rows, columns, len(_CELL))
        words[...] = _CELL
        words[..., _FOREGROUND_DIGITS] = _digits(foreground)
        words[..., _BACKGROUND_DIGITS] = _digits(background)
        words[..., _GLYPH] = marks
        _clear(words, ~new_ink, _FOREGROUND)
        _clear(words, ~new_ground, _BACKGROUND)
        _clear(words, ~(new_ink | new_ground), _AROUND)
        joined: bytes = self._buffer.tobytes().translate(None, b"\0")
        return joined

    def _fit(self, rows: int, columns: int) -> None:
        width = columns * len(_CELL) + len(_ROW_END)
        if self._buffer.shape != (rows, width):
            self._buffer = np.zeros((rows, width), np.uint32)
            self._buffer[:, -len(_ROW_END) :] = _ROW_END
            self._order = np.arange(columns)

    def _new_foreground(
        self, foreground: Words, blank: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Where the foreground must be set: blanks show none and leave the last one in force."""
        new = ~blank
        before = foreground[:, :-1]
        if blank.any():
            foreground[blank[:, 0], 0] = _NO_COLOUR
            last = np.where(blank, 0, self._order)
            np.maximum.accumulate(last, axis=1, out=last)
            before = np.take_along_axis(foreground, last, axis=1)[:, :-1]
        new[:, 1:] &= foreground[:, 1:] != before
        return new


def changed_rows(previous: Cells | None, current: Cells) -> npt.NDArray[np.intp]:
    """Numbers of the rows that look different, all when there was no frame of the same size."""
    if previous is None or previous.glyphs.shape != current.glyphs.shape:
        return np.arange(current.rows)
    same_rows = 2 * current.columns
    pixels = (_packed(previous.pixels) ^ _packed(current.pixels)) & RGB_MASK
    differs = pixels.reshape(current.rows, same_rows).any(axis=1)
    differs |= (previous.glyphs != current.glyphs).any(axis=1)
    ink = (_packed(previous.ink) ^ _packed(current.ink)) & RGB_MASK
    differs |= ((ink != 0) & (current.glyphs != 0)).any(axis=1)
    return np.flatnonzero(differs)


def _planes(
    cells: Cells, numbers: npt.NDArray[np.intp] | Sequence[int] | None
) -> tuple[Words, Words, Words, npt.NDArray[np.bool_]]:
    """Foreground, background, what is written, and where only the background shows."""
    pixels = _packed(cells.pixels)
    upper, lower, glyphs, ink = pixels[0::2], pixels[1::2], cells.glyphs, _packed(cells.ink)
    if numbers is not None:
        chosen = np.asarray(numbers, np.intp)
        upper, lower, glyphs, ink = (plane[chosen] for plane in (upper, lower, glyphs, ink))
    foreground, background = upper & RGB_MASK, lower & RGB_MASK
    blank = foreground == background
    marks = np.where(blank, _BLANK, _HALF_BLOCK)
    place = np.nonzero(glyphs)
    if place[0].size:
        first, second = foreground[place], background[place]
        background[place] = (first & second) + (((first ^ second) & _LOW_BITS_OFF) >> 1)
        foreground[place] = ink[place] & RGB_MASK
        blank[place] = glyphs[place] == _SPACE
        marks[place] = _utf8(glyphs[place])
    return foreground, background, marks, blank


def _packed(pixels: npt.NDArray[np.uint8]) -> Words:
    """Pixels of shape (h, w, 4) as words of shape (h, w)."""
    words: Words = np.ascontiguousarray(pixels).view(np.uint32)[..., 0]
    return words


def _digits(colours: Words) -> Words:
    """The parts ;R ;G ;B of every colour, shape (rows, columns, 3)."""
    parts = np.ascontiguousarray(colours).view(np.uint8).reshape(*colours.shape, 4)
    return np.take(_DIGITS, parts[..., :3])


def _clear(words: Words, where: npt.NDArray[np.bool_], parts: slice) -> None:
    rows, columns = np.nonzero(where)
    if rows.size:
        words[rows, columns, parts] = 0


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
