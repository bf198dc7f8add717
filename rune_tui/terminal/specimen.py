"""A small picture in each set of characters, in which people see how their font draws it."""

from __future__ import annotations

import numpy as np

from rune_tui.compositor.ansi import encoded_rows
from rune_tui.compositor.blend import Layer, compose
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.compositor.looks import Looks, looks_of
from rune_tui.compositor.seen_pictures import seen_pictures
from rune_tui.raster.canvas import Canvas

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
        rows = encoded_rows(_picture(glyphs), glyphs.half)
        text += [f"{name:<13} {row}\n" for name, row in zip(names, rows, strict=True)]
        text.append("\n")
    return "".join(text) + ADVICE


def _picture(glyphs: GlyphSet) -> Looks:
    """Every bar crosses from one row of cells into the next, where seams are."""
    wide, _ = glyphs.pixels_per_cell
    down, across = np.mgrid[0 : 2 * _ROWS, 0 : wide * _COLUMNS] + 0.5
    middle = (_COLUMNS + _BARS) / 2
    disc = (across / wide - middle) ** 2 + (down - _ROWS) ** 2 < (_ROWS - 0.3) ** 2
    bright = np.where(across < wide * _BARS, (down + 1) // 2 % 2 == 1, disc)
    pixels = np.where(bright[..., None], _BRIGHT, _DARK).astype(np.uint8)
    canvas = Canvas.blank(_COLUMNS, 2 * _ROWS, scale=(wide, 1))
    canvas.place_picture(pixels, 0, 0, (_COLUMNS, 2 * _ROWS))
    layers = [Layer(canvas=canvas, x=0, y=0)]
    cells = compose(_COLUMNS, _ROWS, (0, 0, 0), layers)
    return looks_of(cells, seen_pictures(cells, layers))
