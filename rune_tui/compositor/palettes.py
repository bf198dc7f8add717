"""Numbered colours of terminals, and the nearest of them to given colours.

A distance combines the differences of brightness and of blue and red less brightness, in sRGB.
Chroma weighs enough to keep a brick wall different from the floor. OKLab would turn panels that
are nearly black into grey.
"""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt

Bytes = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.integer]

LUMA: Final = (77, 150, 29)
"""Share of red, green and blue in brightness, of 256 (ITU-R BT.601)."""

_CHROMA = 0.8
"""Weight of a difference in chroma, relative to brightness."""
_CUBE_LEVELS = np.array([0.0, 95.0, 135.0, 175.0, 215.0, 255.0])
_GREYS = np.arange(8.0, 239.0, 10.0)
_FIRST_CUBE = 16
_VGA = np.array(
    [
        *((0, 0, 0), (170, 0, 0), (0, 170, 0), (170, 85, 0)),
        *((0, 0, 170), (170, 0, 170), (0, 170, 170), (170, 170, 170)),
        *((85, 85, 85), (255, 85, 85), (85, 255, 85), (255, 255, 85)),
        *((85, 85, 255), (255, 85, 255), (85, 255, 255), (255, 255, 255)),
    ]
)
_BITS = 5
"""Bits of each channel in the table of nearest colours."""
_VIVID = 2.5
"""Gain of chroma before the choice among 16 colours; most colours of a camera would become grey."""
_BAYER = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]], np.int16)
_DITHER = _BAYER - 8
"""Added to pictures before the choice among 16 colours (B. Bayer, 1973): gives a floor more than
one grey, but no grain to a wall."""


def _grid(values: Floats) -> Floats:
    """All triples of the values, the last channel fastest, shape (n ** 3, 3)."""
    return np.stack(np.meshgrid(*[values] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def _palette(colours: Floats, first: int = 0) -> Bytes:
    """Red, green, blue and number of each colour, by number; shape (first + n, 4)."""
    palette = np.zeros((first + len(colours), 4), np.uint8)
    palette[first:, :3] = colours
    palette[:, 3] = np.arange(len(palette))
    return palette


PALETTE_256: Final = _palette(
    np.concatenate([_grid(_CUBE_LEVELS), np.repeat(_GREYS[:, None], 3, axis=1)]), _FIRST_CUBE
)
PALETTE_16: Final = _palette(_VGA.astype(np.float64))
PALETTE_MONO: Final = _palette(np.array([[0.0] * 3, [255.0] * 3]))
"""Ground and ink of a dark terminal."""


def nearest_of_256(colours: Bytes) -> Bytes:
    """Number of the nearest colour of cube and greys; colours of shape (..., 4)."""
    return _looked_up(_table_of_256(), colours[..., :3] >> (8 - _BITS))


def nearest_of_16(colours: Bytes) -> Bytes:
    """Number of the nearest colour; colours of shape (..., 4)."""
    return _looked_up(_table_of_16(1.0), colours[..., :3] >> (8 - _BITS))


def dithered_16(pixels: Bytes) -> Bytes:
    """Numbers of dithered colours, with the chroma of the pixels raised.

    Args:
        pixels: Shape (h, w, 4).
    """
    rows, columns = pixels.shape[:2]
    pattern = np.tile(_DITHER, (-(-rows // 4), -(-columns // 4)))[:rows, :columns, None]
    shifted = pixels[..., :3] + pattern
    np.clip(shifted, 0, 255, out=shifted)
    shifted >>= 8 - _BITS
    return _looked_up(_table_of_16(_VIVID), shifted)


def _looked_up(table: Bytes, parts: Integers) -> Bytes:
    place = parts[..., 0].astype(np.intp)
    for channel in (1, 2):
        place <<= _BITS
        place |= parts[..., channel]
    found: Bytes = table.take(place)
    return found


@cache
def _table_of_256() -> Bytes:
    return _FIRST_CUBE + _nearest(PALETTE_256[_FIRST_CUBE:, :3], 1.0)


@cache
def _table_of_16(vivid: float) -> Bytes:
    return _nearest(PALETTE_16[:, :3], vivid)


def _nearest(palette: Bytes, vivid: float) -> Bytes:
    """Number of the palette's nearest colour to each colour of `_BITS`, after a gain of chroma."""
    colours = _grid(np.linspace(0.0, 255.0, 1 << _BITS))
    grey = _brightness(colours)
    wanted = _weighted(np.clip(grey + vivid * (colours - grey), 0.0, 255.0))
    offered = _weighted(palette.astype(np.float64))
    # All distances leave out the square of the wanted colour, a constant.
    numbers = [
        ((offered**2).sum(axis=1) - 2.0 * part @ offered.T).argmin(axis=1)
        for part in np.array_split(wanted, 64)  # parts fit the processor's cache
    ]
    return np.concatenate(numbers).astype(np.uint8)


def _weighted(colours: Floats) -> Floats:
    """Weighted brightness and chroma; colours and result of shape (n, 3)."""
    grey = _brightness(colours)
    chroma = _CHROMA * (colours[:, ::2] - grey)
    return np.concatenate([grey, chroma], axis=1)


def _brightness(colours: Floats) -> Floats:
    """Brightness, shape (n, 1), of colours of shape (n, 3)."""
    return colours @ (np.array(LUMA)[:, None] / sum(LUMA))
