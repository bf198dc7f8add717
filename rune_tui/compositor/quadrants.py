"""Cells of 2 x 2 pixels in two colours, for Unicode's quadrant blocks.

A shape is the sum of the quarters with the cell's upper colour: 8 upper left (always), 4 upper
right, 2 lower left, 1 lower right. Shape 0 means two halves.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.compositor.sgr import Words

Bytes = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float32]

BLOCKS: Final = {8: "▘", 9: "▚", 10: "▌", 11: "▙", 13: "▜", 14: "▛"}
"""Characters of the shapes."""

_QUARTERS: Final = np.array([8, 4, 2, 1], np.uint8)
_LUMA: Final = np.array([77, 150, 29, 0], np.float32)
"""Share of red, green and blue in brightness (ITU-R BT.601); the fourth byte has none."""
_GAIN: Final = 192.0
"""Least gain of quadrants over halves, as a sum of squares over a cell's twelve values; a smaller
gain is invisible and flickers with a camera's noise."""
_STEP: Final = 8
"""Largest difference to the next value that needs no check: it gains at most 6 * 8 * 8 / 2."""


def split(halves: Words, quarters: Words) -> tuple[Words, Bytes]:
    """The two colours and the shape of each cell that are near to its four pixels.

    Quarters brighter than the mean of all four get one colour, their mean; the rest get another
    (block truncation coding: E. J. Delp and O. R. Mitchell, 1979). Cells that gain little stay two
    halves.

    Args:
        halves: Pixels of the cells' halves, shape (2 * rows, columns).
        quarters: Pixels of the cells' quarters, shape (2 * rows, 2 * columns). The unused byte of
            both is zero.

    Returns:
        Upper and lower colours, shape (2 * rows, columns), and shapes, shape (rows, columns).
    """
    colours, shapes = halves.copy(), np.zeros((len(halves) // 2, halves.shape[1]), np.uint8)
    left, right = _values(quarters[:, 0::2]), _values(quarters[:, 1::2])
    # Four flags read as one word.
    steps = (np.maximum(left, right) - np.minimum(left, right) > _STEP).view(np.uint32)[..., 0]
    place = np.nonzero(steps[0::2] | steps[1::2])
    corners = [quarters[down::2, across::2][place] for down in (0, 1) for across in (0, 1)]
    values = _values(np.stack(corners)).astype(np.float32)
    light = values @ _LUMA
    bright = 4.0 * light > light.sum(axis=0)
    has_upper = bright == bright[0]
    first = (values * has_upper[..., None]).sum(axis=0)
    whole, top = values.sum(axis=0), values[0] + values[1]
    count = has_upper.sum(axis=0, dtype=np.float32)
    rest = np.maximum(4.0 - count, 1.0)  # avoids a division by zero in cells of one colour
    gain = _squares(first) / count + _squares(whole - first) / rest
    gain -= (_squares(top) + _squares(whole - top)) / 2.0
    better = gain > _GAIN
    taken = place[0][better], place[1][better]
    shapes[taken] = (has_upper * _QUARTERS[:, None]).sum(axis=0, dtype=np.uint8)[better]
    colours[0::2][taken] = _rounded(first[better] / count[better, None])
    colours[1::2][taken] = _rounded((whole - first)[better] / rest[better, None])
    return colours, shapes


def quarters_with(halves: Words, pictures: Iterable[SeenPicture]) -> Words:
    """Quarters of cells, with the pixels of pictures where these are visible.

    Args:
        halves: Pixels of the cells' halves, shape (2 * rows, columns).
        pictures: Pictures with two pixels per column, from back to front.

    Returns:
        Shape (2 * rows, 2 * columns).
    """
    quarters = halves.repeat(2, axis=1)
    for each in pictures:
        picture = each.picture
        height, width = picture.means.shape[:2]
        down = slice(picture.y, picture.y + height)
        seen = each.seen[:, picture.x : picture.x + width].repeat(2, axis=0)[down]
        target = quarters[down, 2 * picture.x : 2 * (picture.x + width)]
        pixels = picture.pixels.view(np.uint32)[..., 0]
        np.copyto(target, pixels, where=seen.repeat(2, axis=1))
    return quarters


def quarters_of(colours: Words, shapes: Bytes) -> Words:
    """Colour of each quarter, shape (2 * rows, 2 * columns).

    Args:
        colours: Upper and lower colours, shape (2 * rows, columns).
        shapes: Shape (rows, columns).
    """
    quarters = colours.repeat(2, axis=1)
    cut = np.nonzero(shapes)
    upper, lower, shape = colours[0::2][cut], colours[1::2][cut], shapes[cut]
    for number, quarter in enumerate(_QUARTERS):
        quarters[number // 2 :: 2, number % 2 :: 2][cut] = np.where(shape & quarter, upper, lower)
    return quarters


def _values(colours: Words) -> Bytes:
    """Red, green, blue, unused; one axis more than the colours."""
    return np.ascontiguousarray(colours).view(np.uint8).reshape(*colours.shape, 4)


def _squares(colours: Floats) -> Floats:
    """Sums of squared channels, shape (n,), of colours of shape (n, 4)."""
    squares: Floats = np.einsum("cv,cv->c", colours, colours)
    return squares


def _rounded(colours: Floats) -> Words:
    """Colours of shape (n, 4) as words, shape (n,)."""
    rounded: Words = (colours + np.float32(0.5)).astype(np.uint8).view(np.uint32)[:, 0]
    return rounded
