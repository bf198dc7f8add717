"""Two-dimensional run-length coding of pictures and maps.

Pixels are compared whole, along rows and with the row above. A coded picture is a byte for
the coding, then for the two run-length codings the runs' lengths (uint8 each, 1 to 255) and pixels:

| first byte | content |
| --- | --- |
| 0 | the pixels |
| 1 | runs of equal pixels, in reading order |
| 2 | the same, after an exclusive or of each row with the row above |

The encoder takes the shortest of the three, so coding never costs more than one byte.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.errors import CodecError
from hub.gcm.runs import cut_runs, run_ends

_RAW, _ROWS, _ABOVE = 0, 1, 2
_LONGEST = 255

_Pixels = npt.NDArray[np.uint8]


def encode(pixels: _Pixels, *, quality: int = 100) -> _Pixels:
    """The coded picture.

    Args:
        pixels: Shape (height, width) or (height, width, channels), 1 to 4 channels.
        quality: 100 is exact; less keeps 8 to 3 bits a channel, for longer runs.

    Returns:
        Coded bytes, shape (n,).

    Raises:
        CodecError: The pixels are no picture of that kind.
    """
    channels = pixels.shape[2] if pixels.ndim == 3 else 1
    wanted = pixels.dtype == np.uint8 and pixels.ndim in (2, 3) and pixels.size > 0
    if not (wanted and channels <= 4):
        text = f"pixels of {pixels.dtype} in shape {pixels.shape} are no picture"
        raise CodecError(text)
    if quality < 100:
        pixels = _quantised(pixels, quality)
    flat = _packed(pixels)
    codings = [(_ROWS, flat), (_ABOVE, _with_row_above(flat))]
    runs = [(coding, image, run_ends(image.reshape(-1))) for coding, image in codings]
    coding, image, ends = min(runs, key=lambda candidate: len(candidate[2]))
    coded = _run_bytes(coding, image.reshape(-1), ends, channels)
    if len(coded) <= pixels.size:
        return coded
    return np.concatenate((np.array([_RAW], np.uint8), pixels.reshape(-1)))


def decode(coded: _Pixels, height: int, width: int, channels: int) -> _Pixels:
    """The picture of a coded one, shape (height, width, channels).

    Raises:
        CodecError: The bytes are no picture of this size.
    """
    count = height * width
    if min(height, width) < 1 or not 1 <= channels <= 4 or len(coded) < 1:
        text = f"{len(coded)} bytes are no picture of {width}x{height}x{channels}"
        raise CodecError(text)
    coding, body = int(coded[0]), coded[1:]
    if coding == _RAW and len(body) == count * channels:
        return body.reshape(height, width, channels)
    runs = len(body) // (1 + channels)
    lengths, values = body[:runs], body[runs:]
    # Checked before any allocation: a few bytes must not cost gigabytes.
    if coding not in (_ROWS, _ABOVE) or len(values) != runs * channels or lengths.sum() != count:
        text = f"{len(coded)} coded bytes do not make {width}x{height}x{channels} pixels"
        raise CodecError(text)
    padded = np.zeros((runs, 4), np.uint8)
    padded[:, :channels] = values.reshape(runs, channels)
    flat = np.repeat(padded.view(np.uint32)[:, 0], lengths).reshape(height, width)
    if coding == _ABOVE:
        np.bitwise_xor.accumulate(flat, axis=0, out=flat)
    return flat.view(np.uint8).reshape(height, width, 4)[:, :, :channels]


def _quantised(pixels: _Pixels, quality: int) -> _Pixels:
    """Fewer shades a channel, each in the middle of those it replaces."""
    dropped = 5 - max(0, min(quality, 99)) * 5 // 100
    shades = np.arange(256) >> dropped << dropped
    table = np.minimum(shades + (1 << dropped >> 1), 255).astype(np.uint8)
    return np.take(table, pixels)


def _packed(pixels: _Pixels) -> npt.NDArray[np.uint32]:
    """One number a pixel, shape (height, width)."""
    height, width = pixels.shape[:2]
    padded = np.zeros((height, width, 4), np.uint8)
    padded[:, :, : 1 if pixels.ndim == 2 else pixels.shape[2]] = pixels.reshape(height, width, -1)
    return padded.view(np.uint32)[:, :, 0]


def _with_row_above(flat: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
    combined = flat.copy()
    combined[1:] ^= flat[:-1]
    return combined


def _run_bytes(
    coding: int, flat: npt.NDArray[np.uint32], ends: npt.NDArray[np.intp], channels: int
) -> _Pixels:
    lengths, values = cut_runs(flat, ends, _LONGEST)
    coded = np.empty(1 + len(lengths) * (1 + channels), np.uint8)
    coded[0] = coding
    coded[1 : 1 + len(lengths)] = lengths
    pixels = np.ascontiguousarray(values).view(np.uint8).reshape(-1, 4)[:, :channels]
    coded[1 + len(lengths) :] = pixels.reshape(-1)
    return coded
