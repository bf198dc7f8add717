"""Which characters of the terminal's font stand for pixels."""

from __future__ import annotations

import enum
from typing import Final

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
    def fine(self) -> bool:
        """Whether a camera's picture has two pixels across a cell."""
        return self is GlyphSet.QUADRANTS
