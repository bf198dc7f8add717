"""Converts cells to the colours of a terminal: 256, 16 or none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.blend import mean
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.contrast import contrast, luminance
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.palettes import (
    LUMA,
    PALETTE_16,
    PALETTE_256,
    PALETTE_MONO,
    dithered_16,
    nearest_of_16,
    nearest_of_256,
)
from rune_tui.model.theme import LEAST_CONTRAST

Bytes = npt.NDArray[np.uint8]

_STRONG = 96
"""Least difference between the channels of a strong colour, of 255."""
_SHADE_BITS = 5
"""Bits of brightness in the table of patterns."""
# Patterns of a cell without colours: share of ink in its upper and lower half, and the two
# pixels or the character that show it.
_PATTERNS = np.array(
    [
        *((0.0, 0.0, 0, 0, 0), (1.0, 1.0, 1, 1, 0), (1.0, 0.0, 1, 0, 0), (0.0, 1.0, 0, 1, 0)),
        *((0.25, 0.25, 0, 0, 0x2591), (0.5, 0.5, 0, 0, 0x2592), (0.75, 0.75, 0, 0, 0x2593)),
    ]
)


_BLACK_AND_WHITE = np.array([[0, 0, 0, 0], [255, 255, 255, 0]], np.uint8)

# Per depth: the palette, and functions that choose numbers for text and for pictures.
_INDEXED: Mapping[ColourDepth, tuple[Bytes, Callable[[Bytes], Bytes], Callable[[Bytes], Bytes]]] = {
    ColourDepth.INDEXED_256: (PALETTE_256, nearest_of_256, nearest_of_256),
    ColourDepth.INDEXED_16: (PALETTE_16, nearest_of_16, dithered_16),
}


def at_depth(cells: Cells, depth: ColourDepth) -> Cells:
    """Cells in the colours of a depth.

    Both pixels of a cell with a character become one colour. A character with little contrast to it
    becomes black or white. Without colours, pixels become half blocks and shades, and characters
    are inverted on a strong colour and on a brighter ground.

    Args:
        cells: In truecolour.
        depth: The terminal's colours.
    """
    if depth is ColourDepth.TRUECOLOUR:
        return cells
    written = np.nonzero(cells.glyphs)
    behind = mean(cells.pixels[0::2][written], cells.pixels[1::2][written])
    if depth is ColourDepth.MONO:
        palette = PALETTE_MONO
        numbers, glyphs = _patterns(cells)
        ground = _inverted(behind, cells.ink[written]).astype(np.uint8)
        ink = 1 - ground
    else:
        palette, nearest, nearest_pixels = _INDEXED[depth]
        numbers, glyphs = nearest_pixels(cells.pixels), cells.glyphs
        if nearest_pixels is not nearest:
            between = _between_words(cells)
            plain = nearest(cells.pixels[0::2][between])
            numbers[0::2][between] = numbers[1::2][between] = plain
        ground = nearest(behind)
        ink = nearest(cells.ink[written])
        faint = _faint_pairs(depth)[ink, ground]
        ink[faint] = _extremes(depth)[ground[faint]]
    numbers[0::2][written] = ground
    numbers[1::2][written] = ground
    inks = (glyphs != 0).astype(np.uint8)
    inks[written] = ink
    return Cells(
        pixels=palette.take(numbers, axis=0),
        glyphs=glyphs,
        ink=palette.take(inks, axis=0),
        depth=depth,
    )


def _between_words(cells: Cells) -> npt.NDArray[np.bool_]:
    """Cells without a character on a ground of one colour that has characters in the same row.

    Patterns there would look like characters.
    """
    upper, lower = cells.pixels[0::2], cells.pixels[1::2]
    written = cells.glyphs != 0
    flat = (upper == lower).all(axis=2)
    begins = np.ones(flat.shape, np.bool_)
    begins[:, 1:] = (upper[:, 1:] != upper[:, :-1]).any(axis=2) | ~flat[:, 1:] | ~flat[:, :-1]
    runs = np.cumsum(begins.ravel()) - 1
    with_words = np.bincount(runs, weights=written.ravel()) > 0.0
    found: npt.NDArray[np.bool_] = with_words[runs].reshape(flat.shape) & flat & ~written
    return found


def _patterns(cells: Cells) -> tuple[Bytes, npt.NDArray[np.uint32]]:
    """Pixels of ink (1) and ground (0), and the characters, including shades."""
    brightness = _brightness(cells.pixels) >> (8 - _SHADE_BITS)
    chosen = _table_of_patterns()[brightness[0::2], brightness[1::2]]
    numbers = np.zeros(brightness.shape, np.uint8)
    numbers[0::2] = _PATTERNS[:, 2].astype(np.uint8).take(chosen)
    numbers[1::2] = _PATTERNS[:, 3].astype(np.uint8).take(chosen)
    glyphs = _PATTERNS[:, 4].astype(np.uint32).take(chosen)
    np.copyto(glyphs, cells.glyphs, where=cells.glyphs != 0)
    return numbers, glyphs


@cache
def _table_of_patterns() -> npt.NDArray[np.intp]:
    """The pattern nearest to the brightness of an upper and a lower pixel."""
    shares = np.linspace(0.0, 1.0, 1 << _SHADE_BITS)
    upper = (shares[:, None] - _PATTERNS[:, 0]) ** 2
    lower = (shares[:, None] - _PATTERNS[:, 1]) ** 2
    nearest: npt.NDArray[np.intp] = (upper[:, None] + lower[None]).argmin(axis=2)
    return nearest


def _inverted(behind: Bytes, ink: Bytes) -> npt.NDArray[np.bool_]:
    """Which characters are inverted; colours of shape (n, 4)."""
    channels = behind[:, :3]
    strong = channels.max(axis=1) - channels.min(axis=1) >= _STRONG
    turned: npt.NDArray[np.bool_] = strong | (_brightness(behind) > _brightness(ink))
    return turned


@cache
def _faint_pairs(depth: ColourDepth) -> npt.NDArray[np.bool_]:
    """Whether the contrast of an ink to a ground is too low, by the numbers of both."""
    light = luminance(_INDEXED[depth][0])
    faint: npt.NDArray[np.bool_] = contrast(light[:, None], light) < LEAST_CONTRAST
    return faint


@cache
def _extremes(depth: ColourDepth) -> Bytes:
    """Number of black or white, the one with more contrast, by the ground's number."""
    palette, nearest, _ = _INDEXED[depth]
    black, white = nearest(_BLACK_AND_WHITE)
    light = luminance(palette)
    brighter = contrast(light, light[white]) >= contrast(light, light[black])
    extremes: Bytes = np.where(brighter, white, black).astype(np.uint8)
    return extremes


def _brightness(colours: Bytes) -> npt.NDArray[np.int32]:
    """0 to 255, of colours of shape (..., 4)."""
    total = colours[..., 0] * np.int32(LUMA[0])
    total += colours[..., 1] * np.int32(LUMA[1])
    total += colours[..., 2] * np.int32(LUMA[2])
    total >>= 8
    return total
