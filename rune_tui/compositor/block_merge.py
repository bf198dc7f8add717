"""Merges neighbouring pixels of similar colour, so that a frame needs fewer colour codes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.looks import Flags, any_channel, packed, unpacked
from rune_tui.compositor.sgr import Words

_LEVELS = 4
_WIDEST = 1 << (_LEVELS - 1)
Bytes = npt.NDArray[np.uint8]


def merged(pixels: Words, tolerance: int) -> Words:
    """Pixels with similar neighbours merged; no channel changes by more than the tolerance.

    Blocks are one cell or half a cell high, and 8, 4, 2 or 1 pixels wide. A block takes the middle
    of its range if no channel's range exceeds twice the tolerance. The widest such blocks win, and
    whole cells before halves.

    Args:
        pixels: Shape (2 * rows, columns); the unused byte is zero.
        tolerance: 0 to 127.
    """
    height, width = pixels.shape
    # Columns first, so that right-hand neighbours are whole slices. The last column pads the last
    # block, which keeps the range of the block.
    padded = np.empty((-(-width // _WIDEST) * _WIDEST, 2, height // 2), np.uint32)
    padded[:width] = pixels.reshape(height // 2, 2, width).transpose(2, 1, 0)
    padded[width:] = padded[width - 1]
    return _coloured(unpacked(padded), tolerance)[:width].transpose(2, 1, 0).reshape(height, width)


def _coloured(pixels: Bytes, tolerance: int) -> Words:
    """Merged colours, shape (columns, 2, rows); pixels have that shape and four channels."""
    least = greatest = pixels
    levels = [_middles(least, greatest, tolerance)]
    while len(levels) < _LEVELS:
        least = np.minimum(least[0::2], least[1::2])
        greatest = np.maximum(greatest[0::2], greatest[1::2])
        levels.append(_middles(least, greatest, tolerance))
    colours, fits = levels.pop()
    while levels:
        finer, finer_fits = levels.pop()
        # A colour within the tolerance of a wide block is within that of its parts.
        colours = np.where(fits.repeat(2, axis=0), colours.repeat(2, axis=0), finer)
        fits = finer_fits
    return colours


def _middles(least: Bytes, greatest: Bytes, tolerance: int) -> tuple[Words, Flags]:
    """Colours of blocks of one width, and whether each is allowed; shape (blocks, 2, rows).

    Args:
        least: Minima of channels in blocks half a cell high, shape (blocks, 2, rows, 4).
        greatest: Maxima, same shape.
        tolerance: Largest change of a channel.
    """
    half, half_fits = _middle(least, greatest, tolerance)
    whole, whole_fits = _middle(
        np.minimum(least[:, 0], least[:, 1]), np.maximum(greatest[:, 0], greatest[:, 1]), tolerance
    )
    return np.where(whole_fits[:, None], whole[:, None], half), half_fits


def _middle(least: Bytes, greatest: Bytes, tolerance: int) -> tuple[Words, Flags]:
    """The middle of each range, and whether its ends are within the tolerance."""
    span = greatest - least
    fits = ~any_channel(span > 2 * tolerance)
    span >>= 1
    span += least
    return packed(span), fits
