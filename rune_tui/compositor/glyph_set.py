"""Which characters of the terminal's font stand for pixels."""

from __future__ import annotations

import enum
from typing import Final

from rune_tui.compositor.depth import ColourDepth

UPPER_HALF: Final = "▀"
LOWER_HALF: Final = "▄"


class GlyphSet(enum.Enum):
    """The characters that pictures are made of; the values are what `--glyphs` takes.

    They are told apart in truecolour only: with fewer colours, both half blocks are needed.
    """

    HALF = "half"
    """The upper half block: two pixels a cell, in the colours that they have."""
    LOWER = "lower"
    """The lower half block; some fonts draw the upper one with seams."""
    QUADRANTS = "quadrants"
    """Also the quadrant blocks: a camera's picture has two by two pixels a cell, in two colours."""

    @property
    def half(self) -> str:
        """The block that shows a cell's two pixels."""
        return LOWER_HALF if self is GlyphSet.LOWER else UPPER_HALF

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture across and down a cell."""
        return (2, 2) if self is GlyphSet.QUADRANTS else (1, 2)

    def at(self, depth: ColourDepth) -> GlyphSet:
        """What is drawn with these colours; fewer of them leave no choice."""
        return self if depth is ColourDepth.TRUECOLOUR else GlyphSet.HALF
