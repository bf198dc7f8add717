"""The map of a mission: log-odds of cells in a small file with a checksum; pure."""

from __future__ import annotations

import json
import math
import zlib
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from hub.errors import MissionFileError
from hub.gcm.map_coding import MAX_CELLS
from hub.values import dataclass

STEP = 1.0 / 32.0
"""Of the log-odds that are kept; a scan adds several times as much."""
MAX_BYTES = MAX_CELLS + 4096
_MAGIC = "rune-grid-1"
_MAX_HEAD = 1000
_FARTHEST = 1e5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LogOdds:
    """The known part of an occupancy grid.

    Attributes:
        cells: Log-odds in multiples of `STEP`, 0 where nothing is known; shape (height, width),
            row 0 at the least y.
        resolution: Edge of a cell [m].
        origin_x: Lower left corner of cell (0, 0) in `map` [m].
        origin_y: Lower left corner of cell (0, 0) in `map` [m].
    """

    cells: npt.NDArray[np.int8]
    resolution: float
    origin_x: float
    origin_y: float

    @classmethod
    def of(
        cls, values: npt.NDArray[np.float32], resolution: float, origin_x: float, origin_y: float
    ) -> LogOdds:
        """The part of a grid with known cells.

        Args:
            values: Log-odds of the whole grid, shape (height, width).
            resolution: Edge of a cell [m].
            origin_x: Lower left corner of the grid in `map` [m].
            origin_y: The same [m].
        """
        steps = np.clip(np.rint(values / STEP), -127, 127).astype(np.int8)
        rows, columns = np.flatnonzero(steps.any(axis=1)), np.flatnonzero(steps.any(axis=0))
        bottom, left = (int(rows[0]), int(columns[0])) if len(rows) else (0, 0)
        top, right = (int(rows[-1]) + 1, int(columns[-1]) + 1) if len(rows) else (1, 1)
        return cls(
            cells=steps[bottom:top, left:right].copy(),
            resolution=resolution,
            origin_x=origin_x + left * resolution,
            origin_y=origin_y + bottom * resolution,
        )

    @property
    def values(self) -> npt.NDArray[np.float32]:
        """The log-odds, shape (height, width)."""
        return self.cells.astype(np.float32) * np.float32(STEP)


def encode(grid: LogOdds) -> bytes:
    """The file of a grid: one line of JSON, then the cells, compressed."""
    packed = zlib.compress(grid.cells.tobytes(), 1)
    head = {
        "form": _MAGIC,
        "width": grid.cells.shape[1],
        "height": grid.cells.shape[0],
        "resolution": grid.resolution,
        "origin": [grid.origin_x, grid.origin_y],
        "crc": zlib.crc32(packed),
    }
    return json.dumps(head).encode() + b"\n" + packed


def decode(raw: bytes) -> LogOdds:
    """The grid of a file.

    Raises:
        MissionFileError: It is damaged, or is no file of a grid.
    """
    end = raw.find(b"\n", 0, _MAX_HEAD)
    try:
        head = json.loads(raw[:end]) if end >= 0 else None
    except (ValueError, RecursionError) as error:
        text = f"the map cannot be read: {error}"
        raise MissionFileError(text) from error
    if not isinstance(head, dict) or head.get("form") != _MAGIC:
        _refuse(f"it is no {_MAGIC}")
    width, height = (_number(head.get(key), 1, MAX_CELLS) for key in ("width", "height"))
    resolution = _number(head.get("resolution"), 0.001, 10.0)
    origin = head.get("origin")
    if not isinstance(origin, list) or len(origin) != 2:
        _refuse("it has no origin")
    x, y = (_number(value, -_FARTHEST, _FARTHEST) for value in origin)
    packed = raw[end + 1 :]
    if zlib.crc32(packed) != head.get("crc") or width * height > MAX_CELLS:
        _refuse("it is damaged")
    unpacking = zlib.decompressobj()
    try:
        cells = unpacking.decompress(packed, MAX_CELLS + 1)
    except zlib.error as error:
        text = f"the map cannot be read: {error}"
        raise MissionFileError(text) from error
    if len(cells) != int(width) * int(height):
        _refuse("it has not as many cells as it says")
    return LogOdds(
        cells=np.frombuffer(cells, np.int8).reshape(int(height), int(width)),
        resolution=resolution,
        origin_x=x,
        origin_y=y,
    )


def _number(value: Any, low: float, high: float) -> float:  # noqa: ANN401 - any JSON value
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not low <= value <= high or not math.isfinite(value):
        _refuse(f"it has a number that is not between {low:g} and {high:g}")
    return float(value)


def _refuse(reason: str) -> NoReturn:
    text = f"the map cannot be read: {reason}"
    raise MissionFileError(text)
