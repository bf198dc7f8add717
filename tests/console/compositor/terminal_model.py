"""A strict terminal: knows moves and colours, refuses everything else, and wraps no line."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.looks import Looks, unpacked

Colour = tuple[int, ...] | int | None
"""Red, green, blue; the number of a colour; or the terminal's own."""


class Mark(NamedTuple):
    """What stands in a cell; without colours, ink is 1 and ground is 0."""

    character: str
    ink: Colour
    ground: Colour

    @property
    def halves(self) -> tuple[Colour, Colour]:
        """The colours of its upper and lower half."""
        return {
            "▀": (self.ink, self.ground),
            "▄": (self.ground, self.ink),
            "█": (self.ink, self.ink),
            " ": (self.ground, self.ground),
        }[self.character]

    @property
    def quarters(self) -> tuple[Colour, ...]:
        """The colours of its upper left, upper right, lower left and lower right quarter."""
        inked = {
            "▀": (1, 1, 0, 0),
            "▄": (0, 0, 1, 1),
            "█": (1, 1, 1, 1),
            " ": (0, 0, 0, 0),
            "▘": (1, 0, 0, 0),
            "▚": (1, 0, 0, 1),
            "▌": (1, 0, 1, 0),
            "▙": (1, 0, 1, 1),
            "▜": (1, 1, 0, 1),
            "▛": (1, 1, 1, 0),
        }[self.character]
        return tuple(self.ink if has else self.ground for has in inked)


class Terminal:
    """Cells by row and column; `touched` are those of the last bytes, `order` as they came."""

    def __init__(self, columns: int, rows: int, *, coloured: bool = True) -> None:
        self.columns, self.rows = columns, rows
        self.marks: dict[tuple[int, int], Mark] = {}
        self.order: list[tuple[int, int]] = []
        self._coloured = coloured

    @property
    def touched(self) -> set[tuple[int, int]]:
        return set(self.order)

    def feed(self, text: str) -> None:
        """Take what was sent, which must leave the attributes reset."""
        self.order = []
        self._reset()
        row = column = 0
        end = 0
        for match in re.finditer(r"\x1b\[([\d;]*)([HCm])|([^\x00-\x1f\x7f-\x9f])", text):
            assert match.start() == end, f"{text[end : match.start()]!r} is none of ours"
            end = match.end()
            numbers, final, character = match.groups()
            if character:
                assert row < self.rows, "written below the last row"
                assert column < self.columns, "written behind the last column"
                self._write(row, column, character)
                column += 1
            elif final == "H":
                row, column = (int(number) - 1 for number in numbers.split(";"))
                assert 0 <= row < self.rows
                assert 0 <= column < self.columns
            elif final == "C":
                column += int(numbers or 1)
                assert column < self.columns, "moved behind the last column"
            else:
                self._colour([int(number) for number in numbers.split(";")])
        assert end == len(text), f"{text[end:]!r} is none of ours"
        assert (self._ink, self._ground, self._turned) == (None, None, False), "not reset"

    def scribble(self, row: int, column: int) -> None:
        """Something else writes into a cell."""
        self.marks[row, column] = Mark("☠", 13, 13)

    def _write(self, row: int, column: int, character: str) -> None:
        ink, ground = self._ink, self._ground
        if not self._coloured:
            ink, ground = int(not self._turned), int(self._turned)
        self.marks[row, column] = Mark(character, ink, ground)
        self.order.append((row, column))

    def _reset(self) -> None:
        self._ink: Colour = None
        self._ground: Colour = None
        self._turned = False

    def _colour(self, numbers: list[int]) -> None:
        while numbers:
            code = numbers.pop(0)
            if code == 0:
                self._reset()
            elif not self._coloured:
                assert code in {7, 27}
                self._turned = code == 7
            elif code in {38, 48}:
                length = {2: 3, 5: 1}[numbers.pop(0)]
                colour = tuple(numbers[:length])
                assert len(colour) == length
                assert max(colour) < 256
                del numbers[:length]
                self._set(code == 38, colour if length == 3 else colour[0])
            else:
                first, brighter = next(
                    place
                    for place in ((30, 0), (40, 0), (90, 8), (100, 8))
                    if 0 <= code - place[0] < 8
                )
                self._set(first in {30, 90}, code - first + brighter)

    def _set(self, ink: bool, colour: Colour) -> None:  # noqa: FBT001 - private
        if ink:
            self._ink = colour
        else:
            self._ground = colour


def colour(pixel: np.ndarray, depth: ColourDepth) -> Colour:
    """A pixel as a terminal of that depth knows it."""
    return tuple(pixel[:3].tolist()) if depth is ColourDepth.TRUECOLOUR else int(pixel[3])


def assert_shows(terminal: Terminal, frame: Cells | Looks, *, off: int = 0) -> None:
    """Every cell is as it should be, or at most so far off where it has no character."""
    for row, column in np.ndindex(frame.glyphs.shape):
        assert_cell(terminal.marks[row, column], frame, row, column, off=off)


def assert_cell(mark: Mark, frame: Cells | Looks, row: int, column: int, *, off: int = 0) -> None:
    """A cell is as it should be, or at most so far off if it has no character."""
    pixels, ink = frame.pixels[2 * row : 2 * row + 2, column], frame.ink[row, column]
    halves = [True, True, False, False]
    if isinstance(frame, Looks):
        pixels, ink = unpacked(pixels), unpacked(ink)
        shape = int(frame.shapes[row, column])
        halves = [bool(shape & quarter) for quarter in (8, 4, 2, 1)] if shape else halves
    upper, lower = pixels.astype(int)
    glyph = int(frame.glyphs[row, column])
    if glyph:
        assert mark.character == chr(glyph)
        assert mark.ground == colour((upper + lower) // 2, frame.depth)
        assert mark.character == " " or mark.ink == colour(ink, frame.depth)
    else:
        wanted = np.array([upper if has_upper else lower for has_upper in halves])
        if off:
            assert np.abs(np.array(mark.quarters) - wanted[:, :3]).max() <= off
        else:
            assert mark.quarters == tuple(colour(pixel, frame.depth) for pixel in wanted)
