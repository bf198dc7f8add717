"""Neighbouring pixels of nearly one colour become one, so that fewer colours have to be told."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.looks import Flags, any_channel, packed, unpacked
from rune_tui.compositor.sgr import Words

_LEVELS = 4
_WIDEST = 1 << (_LEVELS - 1)
Bytes = npt.NDArray[np.uint8]


def merged(pixels: Words, tolerance: int) -> Words:
    """Pixels of which none is further than the tolerance from what it was, in any channel.

    The picture is cut into blocks one cell high or half of it, and 8, 4, 2 or 1 pixels wide. The
    widest whose channels range over no more than twice the tolerance become the middle of their
    range, those of a cell's height before halves.

    Args:
        pixels: Shape (2 * rows, columns); the unused byte is zero.
        tolerance: 0 to 127.
    """
    height, width = pixels.shape
    # Columns first, so that neighbours to the right are whole slices; what is missing of the last
    # block repeats the last column, which changes no block's range.
    padded = np.empty((-(-width // _WIDEST) * _WIDEST, 2, height // 2), np.uint32)
    padded[:width] = pixels.reshape(height // 2, 2, width).transpose(2, 1, 0)
    padded[width:] = padded[width - 1]
    return _coloured(unpacked(padded), tolerance)[:width].transpose(2, 1, 0).reshape(height, width)


def _coloured(pixels: Bytes, tolerance: int) -> Words:
    """Colours of shape (columns, 2, rows), of pixels of that shape and four channels."""
    least = greatest = pixels
    levels = [_middles(least, greatest, tolerance)]
    while len(levels) < _LEVELS:
        least = np.minimum(least[0::2], least[1::2])
        greatest = np.maximum(greatest[0::2], greatest[1::2])
        levels.append(_middles(least, greatest, tolerance))
    colours, fits = levels.pop()
    while levels:
        finer, finer_fits = levels.pop()
        # What a wide block is not further from than the tolerance, its parts are not either.
        colours = np.where(fits.repeat(2, axis=0), colours.repeat(2, axis=0), finer)
        fits = finer_fits
    return colours


def _middles(least: Bytes, greatest: Bytes, tolerance: int) -> tuple[Words, Flags]:
    """Colours of blocks of one width and whether they may have them, shape (blocks, 2, rows).

    Args:
        least: Of each channel in each block of half a cell's height, shape (blocks, 2, rows, 4).
        greatest: The same.
        tolerance: How far a channel may be changed.
    """
    half, half_fits = _middle(least, greatest, tolerance)
    whole, whole_fits = _middle(
        np.minimum(least[:, 0], least[:, 1]), np.maximum(greatest[:, 0], greatest[:, 1]), tolerance
    )
    return np.where(whole_fits[:, None], whole[:, None], half), half_fits


def _middle(least: Bytes, greatest: Bytes, tolerance: int) -> tuple[Words, Flags]:
    """The middle of each range, and whether its ends are within the tolerance of it."""
    span = greatest - least
    fits = ~any_channel(span > 2 * tolerance)
    span >>= 1
    span += least
    return packed(span), fits
