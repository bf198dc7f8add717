"""Decodes pictures of ROS, raw or packed, in the size that is asked for."""

from __future__ import annotations

import io
import struct
from typing import Final

import numpy as np

from hub.errors import CameraError, RosMessageError
from hub.robots.cropping import Size, scaled_size, size_within
from hub.ros.images import LONGEST_SIDE, MOST_PIXELS, Pixels, pixels_of, shaded
from hub.ros.values import RosValue

_FORMATS: Final = ("JPEG", "PNG", "WEBP")
_INSTALL: Final = (
    "packed pictures need Pillow; install it on the robot with: "
    "pip install 'robot-user-nexus[camera]'"
)


def decoded(value: RosValue, wanted: Size) -> tuple[Pixels, Size]:
    """The middle of a picture as red, green, blue, and the size of the whole one.

    Args:
        value: A sensor_msgs/Image or CompressedImage.
        wanted: Its largest width and height [px].

    Raises:
        RosMessageError: It cannot be decoded.
        CameraError: What decodes it is not installed.
    """
    packed = value.field("format") is not None
    pixels, whole = _unpacked(value, wanted) if packed else _raw(value)
    return _middle(pixels, size_within(*wanted, whole)), whole


def _raw(value: RosValue) -> tuple[Pixels, Size]:
    pixels = pixels_of(value)
    return pixels, (pixels.shape[1], pixels.shape[0])


def _unpacked(value: RosValue, wanted: Size) -> tuple[Pixels, Size]:
    try:
        from PIL import Image
    except ImportError as error:
        raise CameraError(_INSTALL) from error

    kind = str(value.get("format"))
    if "compressedDepth" in kind:
        text = "it has packed depths; name a topic of colours"
        raise RosMessageError(text)
    file = io.BytesIO(np.asarray(value.get("data"), np.uint8).tobytes())
    try:
        with Image.open(file, formats=_FORMATS) as picture:
            whole = picture.size
            if max(whole) > LONGEST_SIDE or whole[0] * whole[1] > MOST_PIXELS:
                text = f"it has {whole[0]}x{whole[1]} pixels, which is too many"
                raise RosMessageError(text)
            picture.draft("RGB", scaled_size(size_within(*wanted, whole), whole))
            if picture.mode.startswith("I"):
                return shaded(np.asarray(picture)), whole
            return np.asarray(picture.convert("RGB")), whole
    except (
        OSError,
        ValueError,
        SyntaxError,
        EOFError,
        struct.error,
        Image.DecompressionBombError,
    ) as error:
        text = f"its format {kind[:40]!r} cannot be read: {error}"
        raise RosMessageError(text) from error


def _middle(pixels: Pixels, size: Size) -> Pixels:
    """The middle of a picture, scaled so that it has a size."""
    own = pixels.shape[1], pixels.shape[0]
    width, height = scaled_size(size, own)
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    if (width, height) != own:
        pixels = _scaled(pixels, (width, height))
    return np.ascontiguousarray(pixels[top : top + size[1], left : left + size[0]])


def _scaled(pixels: Pixels, size: Size) -> Pixels:
    try:
        from PIL import Image
    except ImportError:  # some pixels stand for all
        rows = np.arange(size[1]) * pixels.shape[0] // size[1]
        columns = np.arange(size[0]) * pixels.shape[1] // size[0]
        picked: Pixels = pixels[rows[:, None], columns]
        return picked
    picture = Image.fromarray(np.ascontiguousarray(pixels))
    return np.asarray(picture.resize(size, Image.Resampling.BOX))
