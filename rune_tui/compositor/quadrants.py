"""Cells of two by two pixels in two colours, as Unicode's quadrant blocks show them.

A shape says which quarters of a cell have its upper colour, as a sum: 8 the upper left one, which
always has it, 4 the upper right, 2 the lower left and 1 the lower right one; the others have its
lower colour. It is 0 where the cell shows two halves.
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
"""The characters of the shapes."""

_QUARTERS: Final = np.array([8, 4, 2, 1], np.uint8)
_LUMA: Final = np.array([77, 150, 29, 0], np.float32)
"""Share of red, green and blue in brightness (ITU-R BT.601); the fourth byte has none."""
_GAIN: Final = 192.0
"""Least gain of quadrants over halves, as a sum of squares over a cell's twelve values: what is
less, nobody sees, and a camera's noise makes it come and go."""
_STEP: Final = 8
"""Where no value differs by more from the one beside it, the gain is at most 6 * 8 * 8 / 2."""


def split(halves: Words, quarters: Words) -> tuple[Words, Bytes]:
    """The two colours and the shape of each cell that come near to its four pixels.

    The quarters that are brighter than the mean of all four share one colour, their mean, and the
    others another (after block truncation coding: E. J. Delp and O. R. Mitchell, 1979). Cells to
    which two halves come about as near show these.

    Args:
        halves: What the cells show as two halves, shape (2 * rows, columns).
        quarters: Their pixels, shape (2 * rows, 2 * columns). The unused byte of both is zero.

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
    rest = np.maximum(4.0 - count, 1.0)  # of cells of one colour: nothing, of none
    gain = _squares(first) / count + _squares(whole - first) / rest
    gain -= (_squares(top) + _squares(whole - top)) / 2.0
    better = gain > _GAIN
    taken = place[0][better], place[1][better]
    shapes[taken] = (has_upper * _QUARTERS[:, None]).sum(axis=0, dtype=np.uint8)[better]
    colours[0::2][taken] = _rounded(first[better] / count[better, None])
    colours[1::2][taken] = _rounded((whole - first)[better] / rest[better, None])
    return colours, shapes


def quarters_with(halves: Words, pictures: Iterable[SeenPicture]) -> Words:
    """The pixels of cells, with those of pictures where these are seen.

    Args:
        halves: What the cells show as two halves, shape (2 * rows, columns).
        pictures: With two pixels across one of the cells', from back to front.

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
    """The colour of each quarter, shape (2 * rows, 2 * columns).

    Args:
        colours: Upper and lower, shape (2 * rows, columns).
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
    """The sum over the values of each, shape (n,), of colours of shape (n, 4)."""
    squares: Floats = np.einsum("cv,cv->c", colours, colours)
    return squares


def _rounded(colours: Floats) -> Words:
    """Shape (n,), of colours of shape (n, 4)."""
    rounded: Words = (colours + np.float32(0.5)).astype(np.uint8).view(np.uint32)[:, 0]
    return rounded
