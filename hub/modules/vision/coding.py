"""Pictures to bytes: run lengths, files by Pillow, or the values themselves."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from hub.errors import HandlerFailedError
from hub.gcm import rle
from hub.gcm.vision import NOT_CODED, ImageCoding

_INSTALL = (
    f"{NOT_CODED} as {{0}} here: {{1}}; install Pillow on the robot with "
    "pip install 'robot-user-nexus[camera]', or ask for coding RLE"
)
_OPTIONS: Final[Mapping[ImageCoding, Mapping[str, Any]]] = {
    # A code table of its own makes the picture 20 to 40 % smaller, for 0.05 ms.
    ImageCoding.JPEG: {"optimize": True},
    # The usual 4 takes twice the time of 2 for 8 % fewer bytes.
    ImageCoding.WEBP: {"method": 2},
}


def code(pixels: npt.NDArray[np.uint8], coding: ImageCoding, quality: int) -> npt.NDArray[np.uint8]:
    """The bytes of a picture, shape (length,).

    Args:
        pixels: Shape (height, width, 3) in colour, (height, width) in grey.
        coding: How.
        quality: 1 to 100, as in `ImageRequest`.

    Raises:
        HandlerFailedError: This robot cannot code pictures like this.
    """
    if coding in _OPTIONS:
        return _file(pixels, coding, quality)
    if coding is ImageCoding.RAW:
        return np.ascontiguousarray(pixels).reshape(-1)
    return rle.encode(pixels, quality=quality)


def _file(
    pixels: npt.NDArray[np.uint8], coding: ImageCoding, quality: int
) -> npt.NDArray[np.uint8]:
    file = io.BytesIO()
    try:
        from PIL import Image

        picture = Image.fromarray(np.ascontiguousarray(pixels))
        picture.save(file, coding.name, quality=quality, **_OPTIONS[coding])
    except (ImportError, KeyError) as error:  # Pillow is missing, or was built without this coding
        why = "Pillow is missing" if isinstance(error, ImportError) else "Pillow cannot do it"
        raise HandlerFailedError(_INSTALL.format(coding.name, why)) from error
    return np.frombuffer(file.getbuffer(), np.uint8)
