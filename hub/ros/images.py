"""Pictures of ROS 2 as red, green and blue: sensor_msgs/Image in its usual encodings.

Depths and heat have no colours: they are shown as shades, from the least (dark) to the largest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.ros.values import RosValue

Pixels = npt.NDArray[np.uint8]
Shades = npt.NDArray[np.float32]

MOST_PIXELS: Final = 1 << 24
LONGEST_SIDE: Final = 1 << 14
"""Largest picture: all of it, and one side [pixels]."""
_LARGE: Final = 1280
"""A picture with a longer side is shown with fewer pixels: no terminal shows as many."""

_COLOURS: Final = {
    "rgb8": (3, (0, 1, 2)),
    "bgr8": (3, (2, 1, 0)),
    "rgba8": (4, (0, 1, 2)),
    "bgra8": (4, (2, 1, 0)),
    "8uc3": (3, (2, 1, 0)),
    "8uc4": (4, (2, 1, 0)),
    "mono8": (1, (0, 0, 0)),
    "8uc1": (1, (0, 0, 0)),
}
"""Bytes of a pixel, and the places of red, green and blue in it."""
_SHADES: Final = {
    "mono16": "u2",
    "16uc1": "u2",
    "16sc1": "i2",
    "32fc1": "f4",
    "64fc1": "f8",
    "32sc1": "i4",
}
"""Encodings of one number for each pixel, and their types."""
_YUV: Final = {"yuv422": (1, 0, 2), "uyvy": (1, 0, 2), "yuv422_yuy2": (0, 1, 3), "yuyv": (0, 1, 3)}
"""Places of the first brightness, of blue and of red, in the four bytes of two pixels."""
_BAYER: Final = {"rggb": (0, 3), "bggr": (3, 0), "gbrg": (2, 1), "grbg": (1, 2)}
"""Places of red and blue in a square of four pixels, row by row."""

ENCODINGS: Final = (
    *_COLOURS,
    "rgb16",
    "bgr16",
    *_SHADES,
    *_YUV,
    "nv12",
    "nv21",
    "bayer_*8",
    "bayer_*16",
)
"""All encodings that are shown."""


def pixels_of(image: RosValue) -> Pixels:
    """Red, green and blue of a sensor_msgs/Image, shape (height, width, 3).

    Raises:
        RosMessageError: The encoding is not known, or the sizes do not match the data.
    """
    height, width = int(image.get("height")), int(image.get("width"))
    encoding = str(image.get("encoding")).lower()
    if (
        not (0 < height <= LONGEST_SIDE and 0 < width <= LONGEST_SIDE)
        or height * width > MOST_PIXELS
    ):
        text = f"a picture of {width}x{height} pixels is not shown"
        raise RosMessageError(text)
    step, data = int(image.get("step")), _bytes_of(image)
    raw = RawPicture(height, width, step, "<>"[bool(image.get("is_bigendian"))], data)
    return _reader(encoding)(raw)


def _bytes_of(image: RosValue) -> Pixels:
    """The bytes of a picture, of any type that its definition gives them.

    Raises:
        RosMessageError: They are no bytes.
    """
    data = image.get("data")
    if not (isinstance(data, np.ndarray) and data.ndim == 1 and data.dtype.kind in "iu"):
        text = "the data of a picture are no bytes"
        raise RosMessageError(text)
    made: Pixels = np.ascontiguousarray(data, np.uint8)
    return made


def shaded(values: npt.NDArray[np.generic]) -> Pixels:
    """Shades of numbers (height, width), from their least to their largest; not finite: black."""
    numbers = values.astype(np.float32)
    known = np.isfinite(numbers) & (numbers != 0.0)
    if not known.any():
        return np.zeros((*numbers.shape, 3), np.uint8)
    low, high = np.percentile(numbers[known], (1.0, 99.0))
    scale = 215.0 / max(float(high - low), 1e-9)
    with np.errstate(invalid="ignore", over="ignore"):
        grey = np.clip((numbers - low) * scale, 0.0, 215.0) + 40.0
    grey[~known] = 0.0
    shades: Pixels = grey.astype(np.uint8)[..., None].repeat(3, axis=2)
    return shades


class RawPicture:
    """The bytes of a picture."""

    def __init__(self, height: int, width: int, step: int, order: str, data: Pixels) -> None:
        self.height, self.width, self.order = height, width, order
        self._step, self._data = step, data
        self.every = max(1, -(-max(height, width) // _LARGE))

    def rows(self, bytes_wide: int, height: int | None = None, first: int = 0) -> Pixels:
        """Its rows, shape (height, bytes_wide)."""
        rows = self.height if height is None else height
        step = self._step or bytes_wide
        if step < bytes_wide or len(self._data) < step * (first + rows - 1) + bytes_wide:
            text = f"{len(self._data)} bytes are no picture of {self.width}x{self.height}"
            raise RosMessageError(text)
        whole: Pixels = np.lib.stride_tricks.as_strided(
            self._data[step * first :], (rows, bytes_wide), (step, 1), writeable=False
        )
        return whole


def _reader(encoding: str) -> Callable[[RawPicture], Pixels]:
    if encoding in _COLOURS:
        return lambda raw: _colours(raw, *_COLOURS[encoding])
    if encoding in ("rgb16", "bgr16"):
        return lambda raw: _deep(raw, (0, 1, 2) if encoding == "rgb16" else (2, 1, 0))
    if encoding in _SHADES:
        return lambda raw: _numbers(raw, _SHADES[encoding], grey=encoding == "mono16")
    if encoding in _YUV:
        return lambda raw: _packed_yuv(raw, *_YUV[encoding])
    if encoding in ("nv12", "nv21"):
        return lambda raw: _half_yuv(raw, swapped=encoding == "nv21")
    pattern, bits = encoding.removeprefix("bayer_")[:4], encoding[10:]
    if encoding.startswith("bayer_") and pattern in _BAYER and bits in ("8", "16"):
        return lambda raw: _bayer(raw, *_BAYER[pattern], size=int(bits) // 8)
    text = f"pictures of the encoding {encoding[:40]!r} are not shown"
    raise RosMessageError(text)


def _colours(raw: RawPicture, size: int, places: tuple[int, int, int]) -> Pixels:
    every = raw.every
    pixels: Pixels = raw.rows(size * raw.width).reshape(raw.height, raw.width, size)[
        ::every, ::every
    ]
    if size == 3 and places == (0, 1, 2):
        return pixels
    turned: Pixels = pixels[..., places]
    return turned


def _deep(raw: RawPicture, places: tuple[int, int, int]) -> Pixels:
    high = 1 if raw.order == "<" else 0
    bytes_of = raw.rows(6 * raw.width).reshape(raw.height, raw.width, 3, 2)
    made: Pixels = bytes_of[:: raw.every, :: raw.every, places, high]
    return made


def _numbers(raw: RawPicture, kind: str, *, grey: bool) -> Pixels:
    size = int(kind[1])
    rows = np.ascontiguousarray(raw.rows(size * raw.width))
    values = rows.view(raw.order + kind)[:: raw.every, :: raw.every]
    if grey:
        return (values >> 8).astype(np.uint8)[..., None].repeat(3, axis=2)
    return shaded(values)


def _packed_yuv(raw: RawPicture, first: int, blue: int, red: int) -> Pixels:
    pairs = raw.rows(2 * (raw.width // 2 * 2)).reshape(raw.height, raw.width // 2, 4)
    light = pairs[..., (first, first + 2)].reshape(raw.height, -1)
    return _from_yuv(
        light[:: raw.every, :: raw.every],
        pairs[..., blue].repeat(2, axis=1)[:: raw.every, :: raw.every],
        pairs[..., red].repeat(2, axis=1)[:: raw.every, :: raw.every],
    )


def _half_yuv(raw: RawPicture, *, swapped: bool) -> Pixels:
    height, width = raw.height // 2 * 2, raw.width // 2 * 2
    light = raw.rows(width)[:height]
    pairs = raw.rows(width, height // 2, raw.height).reshape(height // 2, width // 2, 2)
    whole = pairs.repeat(2, axis=0).repeat(2, axis=1)
    blue, red = (whole[..., 1], whole[..., 0]) if swapped else (whole[..., 0], whole[..., 1])
    part = np.s_[:: raw.every, :: raw.every]
    return _from_yuv(light[part], blue[part], red[part])


def _from_yuv(light: Pixels, blue: Pixels, red: Pixels) -> Pixels:
    """ITU-R BT.601 with the full range, as JPEG has it."""
    y, u, v = (each.astype(np.int32) for each in (light, blue, red))
    u, v = u - 128, v - 128
    colours = (y + (359 * v >> 8), y - (88 * u + 183 * v >> 8), y + (454 * u >> 8))
    made: Pixels = np.clip(np.stack(colours, axis=-1), 0, 255).astype(np.uint8)
    return made


def _bayer(raw: RawPicture, red: int, blue: int, *, size: int) -> Pixels:
    """Half as many pixels across and down: each square of four pixels becomes one."""
    rows = raw.rows(size * raw.width)
    values = rows if size == 1 else rows[:, 1 if raw.order == "<" else 0 :: 2]
    height, width = raw.height // 2 * 2, raw.width // 2 * 2
    if not height or not width:
        text = f"a picture of {raw.width}x{raw.height} pixels is not shown"
        raise RosMessageError(text)
    squares = values[:height, :width].reshape(height // 2, 2, width // 2, 2)
    four = squares.transpose(0, 2, 1, 3).reshape(height // 2, width // 2, 4)
    greens = [place for place in range(4) if place not in (red, blue)]
    green = four[..., greens].astype(np.uint16).sum(axis=2) >> 1
    every = max(1, raw.every // 2)
    colours = (four[..., red], green.astype(np.uint8), four[..., blue])
    made: Pixels = np.stack(colours, axis=-1)[::every, ::every]
    return made
