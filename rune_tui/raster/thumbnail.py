"""Makes small JPEG pictures of a clicked place, for an interest point."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from PIL import Image

MOST_BYTES = 4096
"""Largest file; a hub drops larger ones [bytes]."""

_SHARE = 0.4
"""Share of the picture's width and height that is cut out."""
_LEAST = 32
"""Shortest edge of the cut, in a larger picture [pixels]."""
_MOST = 96
"""Longest edge of the thumbnail [pixels]."""
_QUALITIES = (85, 70, 50, 30)


def thumbnail(pixels: npt.NDArray[np.uint8], centre: tuple[float, float]) -> npt.NDArray[np.uint8]:
    """A JPEG file of the area around a point of a picture.

    Args:
        pixels: Red, green, blue, shape (height, width, 3).
        centre: The point, as shares of width and height, 0 to 1; a cut at the edge moves inwards.

    Returns:
        At most `MOST_BYTES`, shape (length,).
    """
    height, width = pixels.shape[:2]
    left, right = _cut(width, centre[0])
    top, bottom = _cut(height, centre[1])
    image = Image.fromarray(np.ascontiguousarray(pixels[top:bottom, left:right]))
    image.thumbnail((_MOST, _MOST))
    while True:
        for quality in _QUALITIES:
            file = io.BytesIO()
            image.save(file, "JPEG", quality=quality)
            if file.tell() <= MOST_BYTES:
                return np.frombuffer(file.getvalue(), np.uint8)
        image = image.reduce(2)


def _cut(length: int, share: float) -> tuple[int, int]:
    """First and one past last pixel of a cut around a share of a length."""
    size = min(length, max(_LEAST, round(_SHARE * length)))
    first = min(max(0, round(share * length - size / 2)), length - size)
    return first, first + size
