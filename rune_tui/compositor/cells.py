"""The picture as a terminal can show it: two pixels a cell, and characters laid over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True, kw_only=True)
class Cells:
    """A screenful of cells.

    Attributes:
        pixels: Red, green, blue, unused; shape (2 * rows, columns, 4). A cell's upper half shows
            row 2r in its foreground colour, its lower half row 2r + 1 in its background colour.
        glyphs: Unicode code points, shape (rows, columns); 0 where the cell shows its two pixels.
            A cell with a glyph shows it in `ink` on the mean of its two pixels.
        ink: Red, green, blue, unused of the glyphs, shape (rows, columns, 4).
    """

    pixels: npt.NDArray[np.uint8]
    glyphs: npt.NDArray[np.uint32]
    ink: npt.NDArray[np.uint8]

    @property
    def rows(self) -> int:
        """Height in cells."""
        return len(self.glyphs)

    @property
    def columns(self) -> int:
        """Width in cells."""
        return int(self.glyphs.shape[1])
