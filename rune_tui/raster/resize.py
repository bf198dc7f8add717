"""Pictures to the size shown: area average when they shrink, smooth when they grow."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from PIL import Image


def fitted_size(width: int, height: int, room_width: int, room_height: int) -> tuple[int, int]:
    """The largest size of the same aspect that fits into the room, at least 1 x 1 [pixels]."""
    if width * room_height > height * room_width:
        return room_width, max(1, _rounded(height * room_width, width))
    return max(1, _rounded(width * room_height, height)), room_height


def resized(pixels: npt.NDArray[np.uint8], width: int, height: int) -> npt.NDArray[np.uint8]:
    """A picture in another size.

    Args:
        pixels: Grey, shape (h, w), or red, green, blue, shape (h, w, 3).
        width: Width wanted [pixels].
        height: Height wanted [pixels].

    Returns:
        Shape (height, width) or (height, width, 3).
    """
    rows, columns = pixels.shape[:2]
    if (columns, rows) == (width, height):
        return pixels
    image = Image.fromarray(pixels)
    if columns % width == 0 and rows % height == 0:
        return np.asarray(image.reduce((columns // width, rows // height)))
    grows = width >= columns and height >= rows
    method = Image.Resampling.BILINEAR if grows else Image.Resampling.BOX
    return np.asarray(image.resize((width, height), method))


def fitted(
    pixels: npt.NDArray[np.uint8], room_width: int, room_height: int
) -> tuple[npt.NDArray[np.uint8], int, int]:
    """A picture as large as the room allows, its aspect kept.

    Args:
        pixels: Grey, shape (h, w), or red, green, blue, shape (h, w, 3).
        room_width: Width of the room [pixels].
        room_height: Height of the room [pixels].

    Returns:
        The picture as red, green, blue, shape (height, width, 3), and the column and row of its
        upper left corner when it stands in the middle of the room.
    """
    rows, columns = pixels.shape[:2]
    width, height = fitted_size(columns, rows, room_width, room_height)
    picture = resized(pixels, width, height)
    if picture.ndim == 2:
        picture = np.repeat(picture[..., None], 3, axis=2)
    return picture, (room_width - width) // 2, (room_height - height) // 2


def _rounded(numerator: int, denominator: int) -> int:
    return (2 * numerator + denominator) // (2 * denominator)
