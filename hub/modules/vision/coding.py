"""Pictures to bytes: run lengths, JPEG, or the values themselves; the hub's only use of Pillow."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt

from hub.errors import HandlerFailedError
from hub.gcm import rle
from hub.gcm.vision import ImageCoding

_INSTALL = (
    "pictures cannot be coded as JPEG here: Pillow is missing; install it on the robot with "
    "pip install 'robot-user-nexus[camera]', or ask for coding RLE"
)


def code(pixels: npt.NDArray[np.uint8], coding: ImageCoding, quality: int) -> npt.NDArray[np.uint8]:
    """The bytes of a picture, shape (length,).

    Args:
        pixels: Shape (height, width, 3) in colour, (height, width) in grey.
        coding: How.
        quality: 1 to 100, as in `ImageRequest`.

    Raises:
        HandlerFailedError: It cannot be coded like this on this robot.
    """
    if coding is ImageCoding.JPEG:
        return _jpeg(pixels, quality)
    if coding is ImageCoding.RAW:
        return np.ascontiguousarray(pixels).reshape(-1)
    return rle.encode(pixels, quality=quality)


def _jpeg(pixels: npt.NDArray[np.uint8], quality: int) -> npt.NDArray[np.uint8]:
    try:
        from PIL import Image
    except ImportError as error:
        raise HandlerFailedError(_INSTALL) from error
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=quality)
    return np.frombuffer(file.getbuffer(), np.uint8)
