"""A screen of cells: two pixels a cell, and characters over them."""

from __future__ import annotations

import zlib

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.compositor.depth import ColourDepth


@dataclass(frozen=True, slots=True, kw_only=True)
class Cells:
    """A screen of cells.

    Attributes:
        pixels: Red, green, blue, palette number; shape (2 * rows, columns, 4). Row 2r is the upper
            half of a cell, row 2r + 1 the lower. Truecolour does not use the number.
        glyphs: Unicode code points, shape (rows, columns); 0 where the cell shows its two pixels.
            A cell with a glyph shows it in `ink` on the mean of its two pixels.
        ink: Red, green, blue, palette number of the glyphs, shape (rows, columns, 4).
        depth: Colour depth of `pixels` and `ink`.
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

    @property
    def checksum(self) -> int:
        """CRC-32 of all that is shown."""
        found = 0
        for part in (self.pixels, self.glyphs, self.ink):
            found = zlib.crc32(np.ascontiguousarray(part).data, found)
        return found
