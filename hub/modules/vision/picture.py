"""Turning what the camera gives into what was asked for; pure."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.vision import ImageKind

_GREY_WEIGHTS = np.array([77, 150, 29], np.uint16)
"""Rec. 601 luma weights of red, green and blue, in 256ths."""


def prepare(pixels: npt.NDArray[np.uint8], kind: ImageKind) -> npt.NDArray[np.uint8]:
    """The picture in the colours wanted.

    Args:
        pixels: Red, green, blue, shape (height, width, 3).
        kind: Colours wanted.

    Returns:
        Shape (height, width, 3) in colour, (height, width) in grey.
    """
    if kind is ImageKind.COLOUR:
        return pixels
    return (pixels @ _GREY_WEIGHTS + 128 >> 8).astype(np.uint8)
