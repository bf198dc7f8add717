"""A small picture in each set of characters, in which people see how their font draws it."""

from __future__ import annotations

import numpy as np

from rune_tui.compositor.ansi import encoded_rows
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.raster.canvas import halved

_COLUMNS, _ROWS = 28, 4
_BARS = 12
"""Number of columns with bars; the others have a disc."""
_BRIGHT, _DARK = (236, 178, 60), (24, 62, 120)

ADVICE = """\
Bars and discs are of two plain colours. Where thin lines run through them,
the font draws that set with seams: choose another one with --glyphs, or
another font.
"""


def specimens() -> str:
    """Bars and a disc in truecolour, each row behind the name of the set that draws it."""
    text = []
    for glyphs in GlyphSet:
        names = [glyphs.value] + [""] * (_ROWS - 1)
        rows = encoded_rows(_picture(fine=glyphs.fine), glyphs.half)
        text += [f"{name:<13} {row}\n" for name, row in zip(names, rows, strict=True)]
        text.append("\n")
    return "".join(text) + ADVICE


def _picture(*, fine: bool) -> Cells:
    """Every bar crosses from one row of cells into the next, where seams are.

    Args:
        fine: Whether there are two pixels across a cell.
    """
    wide = 2 if fine else 1
    down, across = np.mgrid[0 : 2 * _ROWS, 0 : wide * _COLUMNS] + 0.5
    middle = (_COLUMNS + _BARS) / 2
    disc = (across / wide - middle) ** 2 + (down - _ROWS) ** 2 < (_ROWS - 0.3) ** 2
    bright = np.where(across < wide * _BARS, (down + 1) // 2 % 2 == 1, disc)
    pixels = np.zeros((*bright.shape, 4), np.uint8)
    pixels[..., :3] = np.where(bright[..., None], _BRIGHT, _DARK)
    return Cells(
        pixels=halved(pixels) if fine else pixels,
        fine=pixels if fine else None,
        glyphs=np.zeros((_ROWS, _COLUMNS), np.uint32),
        ink=np.zeros((_ROWS, _COLUMNS, 4), np.uint8),
    )
