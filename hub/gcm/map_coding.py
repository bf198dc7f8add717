"""Coding of grid maps: runs of equal cells, then deflate, which finds repeated rows.

A coded map is a byte for the coding, then a zlib stream of one of these:

| first byte | deflated data |
| --- | --- |
| 0 | the cells, 1 byte each |
| 1 | the runs' lengths (uint16, little-endian, 1 to 65,535), then the runs' cells (1 byte each) |

The encoder takes the runs if they are shorter. zlib is in the standard library, and no coding is
much shorter for maps of a few levels.
"""

from __future__ import annotations

import zlib

import numpy as np
import numpy.typing as npt

from hub.errors import CodecError
from hub.gcm.runs import cut_runs, run_ends

MAX_CELLS = 1 << 24
"""Most cells of a map."""

_CELLS, _RUNS = 0, 1
_LONGEST = 65_535
_LEVEL = {_CELLS: 1, _RUNS: 6}
"""Level of deflate: runs are few, so more work pays; noise stays long at any level."""

_Map = npt.NDArray[np.int8]
_Coded = npt.NDArray[np.uint8]


def encode(cells: _Map) -> _Coded:
    """The coded map.

    Args:
        cells: Shape (height, width), for instance -1 unknown to 100 occupied.

    Returns:
        Coded bytes, shape (n,).

    Raises:
        CodecError: The cells are no map.
    """
    if cells.dtype != np.int8 or cells.ndim != 2 or not 1 <= cells.size <= MAX_CELLS:
        text = f"cells of {cells.dtype} in shape {cells.shape} are no map"
        raise CodecError(text)
    flat = np.ascontiguousarray(cells).reshape(-1)
    lengths, levels = cut_runs(flat, run_ends(flat), _LONGEST)
    way, raw = _RUNS, lengths.astype("<u2").tobytes() + levels.tobytes()
    if len(raw) > flat.size:
        way, raw = _CELLS, flat.tobytes()
    return np.frombuffer(bytes([way]) + zlib.compress(raw, _LEVEL[way]), np.uint8)


def decode(coded: _Coded, height: int, width: int) -> _Map:
    """The map of a coded one, shape (height, width).

    Raises:
        CodecError: The bytes are no map of this size.
    """
    count = int(height) * int(width)
    if min(height, width) < 1 or count > MAX_CELLS or len(coded) < 1:
        text = f"{len(coded)} bytes are no map of {width}x{height}"
        raise CodecError(text)
    way, raw = int(coded[0]), _inflated(coded[1:].tobytes(), count)
    if way == _CELLS and len(raw) == count:
        return np.frombuffer(raw, np.int8).reshape(height, width)
    runs = len(raw) // 3
    lengths = np.frombuffer(raw, "<u2", runs)
    # Checked before any allocation: a few bytes must not cost gigabytes.
    if way != _RUNS or len(raw) % 3 or lengths.sum(dtype=np.int64) != count:
        text = f"{len(coded)} coded bytes do not make {width}x{height} cells"
        raise CodecError(text)
    cells = np.frombuffer(raw, np.int8, runs, 2 * runs)
    return np.repeat(cells, lengths).reshape(height, width)


def _inflated(stream: bytes, most: int) -> bytes:
    """The inflated data, `most` bytes at most; neither coding is longer."""
    inflate = zlib.decompressobj()
    try:
        raw = inflate.decompress(stream, most)
        # At exactly this limit, the final check sum may still wait.
        raw += inflate.decompress(inflate.unconsumed_tail, 1)
    except zlib.error as error:
        text = f"a coded map of {len(stream)} bytes is damaged: {error}"
        raise CodecError(text) from error
    if not inflate.eof or inflate.unused_data or len(raw) > most:
        text = f"a coded map of {len(stream)} bytes does not end where it should"
        raise CodecError(text)
    return raw
