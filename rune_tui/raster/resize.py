"""Resizes pictures: area average to shrink, bilinear to enlarge."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from PIL import Image


def fitted_size(width: int, height: int, room_width: int, room_height: int) -> tuple[int, int]:
    """The largest size of the same aspect that fits into the room, at least 1 x 1 [pixels]."""
    if width * room_height > height * room_width:
        return room_width, max(1, _rounded(height * room_width, width))
    return max(1, _rounded(width * room_height, height)), room_height


def covering_size(width: int, height: int, room_width: int, room_height: int) -> tuple[int, int]:
    """The smallest size of the same aspect that covers the room [pixels]."""
    if width * room_height > height * room_width:
        return _rounded(width * room_height, height), room_height
    return room_width, _rounded(height * room_width, width)


def resized(
    pixels: npt.NDArray[np.uint8],
    width: int,
    height: int,
    part: tuple[float, float, float, float] | None = None,
) -> npt.NDArray[np.uint8]:
    """A picture in another size.

    Args:
        pixels: Grey, shape (h, w), or red, green, blue, shape (h, w, 3).
        width: New width [pixels].
        height: New height [pixels].
        part: Left, upper, right and lower edge of the part to use [pixels]; None: all.

    Returns:
        Shape (height, width) or (height, width, 3).
    """
    rows, columns = pixels.shape[:2]
    if part is None and (columns, rows) == (width, height):
        return pixels
    image = Image.fromarray(pixels)
    if part is None and columns % width == 0 and rows % height == 0:
        return np.asarray(image.reduce((columns // width, rows // height)))
    left, top, right, bottom = part or (0.0, 0.0, float(columns), float(rows))
    shrinks = width <= right - left, height <= bottom - top
    if all(shrinks):
        return np.asarray(image.resize((width, height), Image.Resampling.BOX, part))
    if any(shrinks):
        # One direction shrinks and the other grows: two steps, each with its own filter.
        least = (width, rows) if shrinks[0] else (columns, height)
        box = (left, 0.0, right, float(rows)) if shrinks[0] else (0.0, top, float(columns), bottom)
        image = image.resize(least, Image.Resampling.BOX, box)
        part = (0.0, top, float(width), bottom) if shrinks[0] else (left, 0.0, right, float(height))
    return np.asarray(image.resize((width, height), Image.Resampling.BILINEAR, part))


def _rounded(numerator: int, denominator: int) -> int:
    return (2 * numerator + denominator) // (2 * denominator)
