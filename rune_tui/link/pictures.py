"""Pictures and maps as robots send them, decoded; untrusted, so every size is checked."""

from __future__ import annotations

import io
import struct

import numpy as np
import numpy.typing as npt
from PIL import Image as PillowImage

from hub.errors import CodecError
from hub.gcm import rle
from hub.gcm.vision import Image, ImageCoding
from rune_tui.model.robot_state import Picture

MOST_PIXELS = 1 << 22
"""Pixels of the largest picture that is decoded; no terminal shows half as many."""
LONGEST_SIDE = 1 << 13
"""Longest side of a picture [pixels]."""
PILLOW_FAULTS = (
    OSError,
    ValueError,
    SyntaxError,
    EOFError,
    struct.error,
    PillowImage.DecompressionBombError,
)
"""What Pillow raises where a file is damaged."""
_CHANNELS = (1, 3)
_FILES = frozenset({ImageCoding.JPEG, ImageCoding.WEBP})


def picture_of(image: Image, interval: float | None = None) -> Picture:
    """The picture in a message, and the usual time until the next one [s]; None: not known.

    Raises:
        CodecError: It is damaged.
    """
    shape = image.height_px, image.width_px, image.channels
    sized = image.height_px >= 1 and image.width_px >= 1
    small = shape[0] * shape[1] <= MOST_PIXELS and max(shape[:2]) <= LONGEST_SIDE
    if not sized or not small or image.channels not in _CHANNELS:
        text = f"a picture of {image.width_px}x{image.height_px} in {image.channels} channels"
        raise CodecError(text)
    if image.coding in _FILES:
        pixels = _file(image, shape)
    elif image.coding is ImageCoding.RAW:
        if image.data.size != shape[0] * shape[1] * shape[2]:
            text = f"{image.data.size} bytes are no picture of {image.width_px}x{image.height_px}"
            raise CodecError(text)
        pixels = image.data.reshape(shape)
    else:
        pixels = rle.decode(image.data, *shape)
    if image.channels == 1:
        pixels = pixels.repeat(3, axis=2)
    return Picture(pixels=pixels, camera=image.camera, interval_s=interval or 0.0)


def _file(image: Image, shape: tuple[int, int, int]) -> npt.NDArray[np.uint8]:
    kind = image.coding.name
    try:
        with PillowImage.open(io.BytesIO(image.data.tobytes()), formats=(kind,)) as opened:
            if opened.size != (shape[1], shape[0]):
                text = f"a {kind} of {opened.size} in a picture of {shape[1]}x{shape[0]}"
                raise CodecError(text)
            wanted = opened.convert("RGB" if shape[2] == _CHANNELS[1] else "L")
            return np.asarray(wanted, np.uint8).reshape(shape)
    except PILLOW_FAULTS as error:
        text = f"the picture is no {kind}: {error}"
        raise CodecError(text) from error
