"""Contrast of text after WCAG 2.2, and the correction of text with too little of it."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.blend import mean
from rune_tui.compositor.cells import Cells
from rune_tui.model.theme import LEAST_CONTRAST

Bytes = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float32]

_SHARES: Final = (0.2126, 0.7152, 0.0722)
"""Shares of linear red, green and blue in luminance (ITU-R BT.709)."""
_FLARE: Final = np.float32(0.05)
"""Light that a screen reflects, after WCAG."""
_SPACE: Final = 32
_STEPS: Final = (0.25, 0.5, 0.75, 1.0)
_NO_TINT: Final = (255, 255, 255)


def luminance(colours: Bytes, tint: tuple[int, int, int] = _NO_TINT) -> Floats:
    """Relative luminance of colours under a tint, 0 to 1; shape (..., 3 or more) to (...)."""
    red, green, blue = _tables(tint)
    found: Floats = red.take(colours[..., 0])
    found += green.take(colours[..., 1])
    found += blue.take(colours[..., 2])
    return found


def contrast(first: Floats, second: Floats) -> Floats:
    """Contrast of two luminances, 1 to 21."""
    ratio = (np.maximum(first, second) + _FLARE) / (np.minimum(first, second) + _FLARE)
    return ratio.astype(np.float32)


def make_legible(cells: Cells, tint: tuple[int, int, int] = _NO_TINT) -> None:
    """Raise the contrast of text that is hard to read, so that text can lie over any picture.

    The ink moves in steps towards white or black, the one with more contrast. If the last step is
    not enough, the ground changes too.

    Args:
        cells: In truecolour; changed in place.
        tint: Tint that is applied later, as in `tinted`.
    """
    row, column = np.nonzero(cells.glyphs > _SPACE)
    if not len(row):
        return
    ground = mean(cells.pixels[2 * row, column], cells.pixels[2 * row + 1, column])
    ink = cells.ink[row, column]
    behind = luminance(ground, tint)
    poor = np.flatnonzero(contrast(behind, luminance(ink, tint)) < LEAST_CONTRAST)
    if not len(poor):
        return
    row, column, ink, behind = row[poor], column[poor], ink[poor], behind[poor]
    white = luminance(np.full((1, 3), 255, np.uint8), tint)
    brighter = contrast(behind, white) >= contrast(behind, np.zeros_like(white))
    aim = np.where(brighter, 255, 0)[:, None].astype(np.float32)
    changed = ink.copy()
    lacking = np.arange(len(ink))
    for share in _STEPS:
        old = ink[lacking, :3]
        changed[lacking, :3] = (old + (aim[lacking] - old) * share).astype(np.uint8)
        now = contrast(behind[lacking], luminance(changed[lacking], tint))
        lacking = lacking[now < LEAST_CONTRAST]
        if not len(lacking):
            break
    cells.ink[row, column] = changed
    if len(lacking):
        plate = np.uint8(255) - changed[lacking, :3]
        row, column = row[lacking], column[lacking]
        for half in (0, 1):
            cells.pixels[2 * row + half, column, :3] = plate


@cache
def _tables(tint: tuple[int, int, int]) -> Floats:
    """Share of each channel's value in the luminance, shape (3, 256)."""
    values = np.arange(256) / 255.0 * np.array(tint)[:, None] / 255.0
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    tables: Floats = (linear * np.array(_SHARES)[:, None]).astype(np.float32)
    return tables
