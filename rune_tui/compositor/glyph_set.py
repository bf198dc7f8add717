"""Characters of the terminal's font that show pixels."""

from __future__ import annotations

import enum
from typing import Final

from rune_tui.compositor.depth import ColourDepth

UPPER_HALF: Final = "▀"
LOWER_HALF: Final = "▄"


class GlyphSet(enum.Enum):
    """Characters that show pictures; the values are those of `--glyphs`.

    They differ in truecolour only: fewer colours need both half blocks.
    """

    HALF = "half"
    """The upper half block: two pixels a cell."""
    LOWER = "lower"
    """The lower half block; some fonts draw the upper one with seams."""
    QUADRANTS = "quadrants"
    """Also the quadrant blocks: a camera's picture has 2 x 2 pixels a cell, in two colours."""

    @property
    def half(self) -> str:
        """The half block of this set."""
        return LOWER_HALF if self is GlyphSet.LOWER else UPPER_HALF

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture across and down a cell."""
        return (2, 2) if self is GlyphSet.QUADRANTS else (1, 2)

    def at(self, depth: ColourDepth) -> GlyphSet:
        """The set to use at a colour depth: `HALF` below truecolour."""
        return self if depth is ColourDepth.TRUECOLOUR else GlyphSet.HALF
