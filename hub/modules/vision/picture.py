"""Converts pictures of the camera into the requested form; pure."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.vision import ImageKind

_GREY_WEIGHTS = np.array([77, 150, 29], np.uint16)
"""Rec. 601 luma weights of red, green and blue, in 256ths."""
_LEAP = 4
"""Brightness is measured at one pixel in this many, along both sides."""


def prepare(pixels: npt.NDArray[np.uint8], kind: ImageKind) -> npt.NDArray[np.uint8]:
    """The picture in the requested colours.

    Args:
        pixels: Red, green, blue, shape (height, width, 3).
        kind: The requested colours.

    Returns:
        Shape (height, width, 3) in colour, (height, width) in grey.
    """
    if kind is ImageKind.COLOUR:
        return pixels
    return (pixels @ _GREY_WEIGHTS + 128 >> 8).astype(np.uint8)


def brightness(pixels: npt.NDArray[np.uint8]) -> float:
    """Mean brightness of a picture, 0 (black) to 255 (white).

    Args:
        pixels: Red, green, blue, shape (height, width, 3).
    """
    few = pixels[_LEAP // 2 :: _LEAP, _LEAP // 2 :: _LEAP]
    means = (few if few.size else pixels).mean(axis=(0, 1))
    return float(means @ _GREY_WEIGHTS) / 256.0


def brightened(pixels: npt.NDArray[np.uint8], gain: float) -> npt.NDArray[np.uint8]:
    """The picture times `gain`, limited to white."""
    if gain == 1.0:
        return pixels
    table = np.minimum(np.rint(np.arange(256) * gain), 255).astype(np.uint8)
    return np.take(table, pixels)
