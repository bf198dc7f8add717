"""The picture as a terminal can show it: two pixels a cell, and characters laid over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.depth import ColourDepth


@dataclass(frozen=True, slots=True, kw_only=True)
class Cells:
    """A screenful of cells.

    Attributes:
        pixels: Red, green, blue, number; shape (2 * rows, columns, 4). A cell's upper half shows
            row 2r, its lower half row 2r + 1. The number is that of the colour where the depth
            numbers its colours, and unused in truecolour.
        glyphs: Unicode code points, shape (rows, columns); 0 where the cell shows its two pixels.
            A cell with a glyph shows it in `ink` on the mean of its two pixels.
        ink: Red, green, blue, number of the glyphs, shape (rows, columns, 4).
        depth: Which colours there are in `pixels` and `ink`.
    """

    pixels: npt.NDArray[np.uint8]
    glyphs: npt.NDArray[np.uint32]
    ink: npt.NDArray[np.uint8]
    depth: ColourDepth = ColourDepth.TRUECOLOUR

    @property
    def rows(self) -> int:
        """Height in cells."""
        return len(self.glyphs)

    @property
    def columns(self) -> int:
        """Width in cells."""
        return int(self.glyphs.shape[1])
