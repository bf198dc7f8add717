"""Pictures as PNG files (ISO/IEC 15948), without a library that the hub does not need otherwise."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import numpy.typing as npt

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_COLOUR = 2
"""Type of pictures with red, green and blue for each pixel."""
_UP = 2
"""Filter: each row is written as its difference from the row above."""


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """The file's content for a picture of shape (height, width, 3)."""
    height, width, _ = pixels.shape
    rows = np.full((height, 1 + 3 * width), _UP, dtype=np.uint8)
    rows[:, 1:] = np.diff(pixels.reshape(height, -1), axis=0, prepend=np.uint8(0))
    header = struct.pack(">IIBBBBB", width, height, 8, _COLOUR, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    return _SIGNATURE + b"".join(_chunk(name, data) for name, data in parts)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
