"""The visible content of cells as words of four bytes, so that frames compare quickly."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.compositor.blend import RGB_MASK
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.quadrants import quarters_of, quarters_with, split
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.compositor.sgr import Words

Flags = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.intp]

SPACE = 32
_REPLACEMENT = 0x3F  # question mark
_LOW_BITS_OFF = np.uint32(0xFEFEFEFE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Looks:
    """Visible content of cells; cells that look the same have the same words in all planes.

    Attributes:
        pixels: Upper and lower colours, shape (2 * rows, columns); behind a character, both are
            its ground. In truecolour the unused byte is zero.
        shapes: Quarters with the upper colour, as in `quadrants`; 0 for two halves; shape
            (rows, columns).
        glyphs: Characters that a terminal may get, shape (rows, columns); 0 for pixels.
        ink: Colours of the characters, shape (rows, columns); 0 for no visible character.
        written: Whether any cell has a character.
        depth: Colour depth.
    """

    pixels: Words
    shapes: npt.NDArray[np.uint8]
    glyphs: Words
    ink: Words
    written: bool
    depth: ColourDepth

    @property
    def upper(self) -> Words:
        """The cells' upper colours, shape (rows, columns)."""
        return self.pixels[0::2]

    @property
    def lower(self) -> Words:
        """The cells' lower colours, shape (rows, columns)."""
        return self.pixels[1::2]

    @property
    def quarters(self) -> Words:
        """The colour of each quarter of a cell, shape (2 * rows, 2 * columns)."""
        return quarters_of(self.pixels, self.shapes)

    def differs(self, other: Looks) -> Flags:
        """Which cells look different, shape (rows, columns)."""
        pixels = self.pixels != other.pixels
        differs: Flags = pixels[0::2] | pixels[1::2]
        differs |= self.shapes != other.shapes
        if self.written or other.written:
            differs |= self.glyphs != other.glyphs
            differs |= self.ink != other.ink
        return differs

    def replaced(self, newer: Looks, where: Flags) -> Looks:
        """These looks, with the flagged cells of newer ones; flags of shape (rows, columns)."""
        pixels = np.where(where.repeat(2, axis=0), newer.pixels, self.pixels)
        shapes = np.where(where, newer.shapes, self.shapes)
        if not (self.written or newer.written):
            return dataclasses.replace(self, pixels=pixels, shapes=shapes)
        glyphs = np.where(where, newer.glyphs, self.glyphs)
        ink = np.where(where, newer.ink, self.ink)
        written = bool(glyphs.any())
        return dataclasses.replace(
            newer, pixels=pixels, shapes=shapes, glyphs=glyphs, ink=ink, written=written
        )

    def part(self, row: int, start: int, end: int) -> Looks:
        """One row's columns `start` to `end`."""
        place = slice(row, row + 1), slice(start, end)
        glyphs = self.glyphs[place]
        return dataclasses.replace(
            self,
            pixels=self.pixels[2 * row : 2 * row + 2, start:end],
            shapes=self.shapes[place],
            glyphs=glyphs,
            ink=self.ink[place],
            written=self.written and bool(glyphs.any()),
        )

    def taken(self, numbers: Numbers) -> Looks:
        """Cells by their numbers in reading order; each becomes a row of one column."""
        columns = self.glyphs.shape[1]
        upper = numbers + numbers // columns * columns
        colours = self.pixels.ravel()
        pixels = np.stack([colours.take(upper), colours.take(upper + columns)], axis=1)
        glyphs = self.glyphs.take(numbers)[:, None]
        return dataclasses.replace(
            self,
            pixels=pixels.reshape(-1, 1),
            shapes=self.shapes.take(numbers)[:, None],
            glyphs=glyphs,
            ink=self.ink.take(numbers)[:, None],
            written=self.written and bool(glyphs.any()),
        )


def looks_of(cells: Cells, pictures: Collection[SeenPicture] = ()) -> Looks:
    """Looks of cells in half blocks, with pictures in quadrants.

    Args:
        cells: The cells.
        pictures: Pictures in them with two pixels per column; in truecolour only.
    """
    pixels, glyphs, ink = packed(cells.pixels), cells.glyphs, packed(cells.ink)
    masked = cells.depth is ColourDepth.TRUECOLOUR
    # A copy in either case: this function changes it, and it outlives the cells.
    halves = pixels = pixels & RGB_MASK if masked else pixels.copy()
    shapes = np.zeros(glyphs.shape, np.uint8)
    if pictures:
        pixels, shapes = split(halves, quarters_with(halves, pictures))
    written = bool(glyphs.any())
    shown, inked = np.zeros_like(glyphs, np.uint32), np.zeros_like(ink)
    if written:
        place = np.nonzero(glyphs)
        upper, lower = pixels[0::2], pixels[1::2]
        first, second = halves[0::2][place], halves[1::2][place]
        upper[place] = lower[place] = (first & second) + (((first ^ second) & _LOW_BITS_OFF) >> 1)
        shapes[place] = 0
        shown[place] = _allowed(glyphs[place])
        colours = ink[place] & RGB_MASK if masked else ink[place]
        inked[place] = np.where(shown[place] == SPACE, np.uint32(0), colours)
    return Looks(
        pixels=pixels, shapes=shapes, glyphs=shown, ink=inked, written=written, depth=cells.depth
    )


def packed(pixels: npt.NDArray[np.uint8]) -> Words:
    """Pixels of shape (h, w, 4) as words of shape (h, w)."""
    words: Words = np.ascontiguousarray(pixels).view(np.uint32)[..., 0]
    return words


def any_channel(flags: Flags) -> Flags:
    """Which pixels have a flag in one of their four channels; flags of shape (h, w, 4)."""
    found: Flags = flags.view(np.uint32)[..., 0] != 0
    return found


def unpacked(colours: Words) -> npt.NDArray[np.uint8]:
    """Words of shape (h, w) as pixels of shape (h, w, 4)."""
    return np.ascontiguousarray(colours).view(np.uint8).reshape(*colours.shape, 4)


def _allowed(code_points: Words) -> Words:
    """Code points; a question mark replaces those that a terminal must not get."""
    points = code_points.astype(np.uint32)
    control = (points < SPACE) | ((points >= 0x7F) & (points < 0xA0))
    surrogate = (points >= 0xD800) & (points < 0xE000)
    points[control | surrogate | (points > 0x10FFFF)] = _REPLACEMENT
    return points
