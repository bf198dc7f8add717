"""A surface that visualizers draw on: pixels with alpha, and characters laid over them."""

from __future__ import annotations

import functools
import unicodedata
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rune_tui.model import theme

Colour = theme.Colour
"""Red, green, blue, alpha, each 0 to 255; alpha 0 shows what is behind."""

REPLACEMENT = "?"
"""Stands for every character that a terminal would not show in exactly one cell."""

_LOW_BITS_OFF = np.uint32(0xFEFEFEFE)
_DROPPED = frozenset({"Mn", "Me"})
# Missing in Python's tables: Hangul vowels and final consonants join the syllable before them;
# symbols that Unicode 16 made wide, and regional indicators, which terminals pair into flags.
_OTHER_WIDTHS = (
    (0x1160, 0x11FF),
    (0xD7B0, 0xD7FF),
    (0xFFA0, 0xFFA0),
    (0x2630, 0x2637),
    (0x268A, 0x268F),
    (0x4DC0, 0x4DFF),
    (0x1D300, 0x1D356),
    (0x1D360, 0x1D376),
    (0x1F1E6, 0x1F1FF),
)


@functools.lru_cache(maxsize=4096)
def printable(character: str) -> str:
    """What a terminal can show of a character in exactly one cell; empty if it takes none.

    Control, unassigned, private and double-width characters become `REPLACEMENT`, any kind of
    blank a space; marks that combine with the character before them are left out.
    """
    category = unicodedata.category(character)
    if category in _DROPPED:
        return ""
    if category == "Zs":
        return " "
    wide = unicodedata.east_asian_width(character) in {"W", "F"}
    wide |= any(first <= ord(character) <= last for first, last in _OTHER_WIDTHS)
    if wide or category[0] == "C" or category in {"Zl", "Zp", "Mc"}:
        return REPLACEMENT
    return character


def printable_text(string: str) -> str:
    """A string in which every character takes exactly one cell; see `printable`."""
    return "".join(map(printable, unicodedata.normalize("NFC", string)))


def halved(fine: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Each two pixels side by side as their mean, rounded down.

    Args:
        fine: Shape (height, 2 * width, 4).

    Returns:
        Shape (height, width, 4).
    """
    words = fine.view(np.uint32)[..., 0]
    left, right = words[:, 0::2], words[:, 1::2]
    # All four bytes at once; none overflows into another.
    means = (left & right) + (((left ^ right) & _LOW_BITS_OFF) >> 1)
    return means[..., None].view(np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Canvas:
    """Pixels and characters; a character covers a cell of 1 x 2 pixels.

    Attributes:
        pixels: Red, green, blue, alpha, shape (height, width, 4).
        glyphs: Code points, shape (ceil(height / 2), width); 0 where there is no character.
        ink: Red, green, blue, alpha of the characters, shape (ceil(height / 2), width, 4).
        fine: A finer picture for where `pixels` stay as it was pasted, shape (height, 2 * width,
            4), its last byte unused; None where nobody could see it.
    """

    pixels: npt.NDArray[np.uint8]
    glyphs: npt.NDArray[np.uint32]
    ink: npt.NDArray[np.uint8]
    fine: npt.NDArray[np.uint8] | None = None

    @classmethod
    def blank(cls, width: int, height: int, *, fine: bool = False) -> Canvas:
        """A canvas through which everything behind it is seen, of this size in pixels.

        Args:
            width: Its width.
            height: Its height.
            fine: Whether a finer picture can be seen.
        """
        rows = (height + 1) // 2
        return cls(
            pixels=np.zeros((height, width, 4), np.uint8),
            glyphs=np.zeros((rows, width), np.uint32),
            ink=np.zeros((rows, width, 4), np.uint8),
            fine=np.zeros((height, 2 * width, 4), np.uint8) if fine else None,
        )

    @property
    def width(self) -> int:
        """Width [pixels], which is also the width in cells."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Height [pixels]."""
        return int(self.pixels.shape[0])

    @property
    def rows(self) -> int:
        """Height in cells; the last one may be half outside."""
        return int(self.glyphs.shape[0])

    def fill(self, colour: Colour) -> None:
        """Give every pixel this colour."""
        self.pixels[...] = colour

    def paste(self, pixels: npt.NDArray[np.uint8], x: int, y: int) -> None:
        """Lay an opaque picture on the canvas, clipped at its edges.

        Args:
            pixels: Red, green, blue, shape (height, width, 3).
            x: Column of its left edge [pixels]; may be outside.
            y: Row of its upper edge [pixels]; may be outside.
        """
        left, top = max(0, x), max(0, y)
        right = min(self.width, x + pixels.shape[1])
        bottom = min(self.height, y + pixels.shape[0])
        if left >= right or top >= bottom:
            return
        target = self.pixels[top:bottom, left:right]
        target[..., :3] = pixels[top - y : bottom - y, left - x : right - x]
        target[..., 3] = 255

    def paste_fine(self, pixels: npt.NDArray[np.uint8], x: int, y: int) -> None:
        """Lay an opaque picture on a canvas that shows finer ones.

        Args:
            pixels: Twice as wide as they are shown, shape (height, 2 * width, 3).
            x: Column of its left edge [pixels of the canvas]; inside, as is all of the picture.
            y: Row of its upper edge [pixels]; in the same way.
        """
        if self.fine is None:
            text = "this canvas shows no finer pictures; make it with fine=True"
            raise ValueError(text)
        place = slice(y, y + len(pixels))
        fine = self.fine[place, 2 * x : 2 * x + pixels.shape[1]]
        fine[..., :3] = pixels
        self.paste(halved(fine)[..., :3], x, y)

    def text(self, column: int, row: int, string: str, colour: Colour) -> None:
        """Write characters, clipped at the edges; the pixels under them stay.

        Args:
            column: Cell column of the first character; may be outside.
            row: Cell row; may be outside.
            string: Shown as `printable_text`.
            colour: Colour of the characters.
        """
        if not 0 <= row < self.rows:
            return
        shown = printable_text(string)
        first = max(0, column)
        end = min(self.width, column + len(shown))
        if first >= end:
            return
        self.glyphs[row, first:end] = [ord(c) for c in shown[first - column : end - column]]
        self.ink[row, first:end] = colour
