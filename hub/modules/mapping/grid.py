"""The occupancy grid: log-odds of cells in `map`, and grids of occupancy made from it; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beams import Beams
from hub.gcm.map_coding import MAX_CELLS
from hub.gcm.occupancy_map import OccupancyMap
from hub.missions.log_odds import LogOdds
from hub.modules.mapping.evidence import Evidence, Floats
from hub.pose import Pose, wrapped

LOADED = 1.5
"""Start value of free (minus) and occupied (plus) cells of a loaded map [log-odds]."""
KNOWN = 0.1
"""A cell with less evidence than this, for either side, is unknown [log-odds]."""
BORDER = 0.5
"""Width of the unknown border around a picture of the whole map [m]."""
MAX_EDGE_CELLS = math.isqrt(MAX_CELLS)

_PERCENT = 100.0
_ALIGNED = 1e-3
"""Two grids are aligned if their shift is a smaller part of a cell."""
_STEP = 5
"""Shown occupancies are multiples of this [percent]: coded maps are a quarter shorter."""


class OccupancyGrid:
    """A square of cells, fixed in `map`, with the origin (the robot's start) in the middle.

    A hidden frame of cells, as wide as sensors reach, surrounds it. So all cells around a robot
    within the square exist. Nothing beyond the square is mapped.

    Attributes:
        resolution: Edge of a cell [m].
        edge_cells: Cells along each side of the square.
        low: Least x and y of the square [m].
        outside: Number of scans left out because the robot was outside of the square.
    """

    def __init__(self, resolution: float, size: float, beams: Beams | None = None) -> None:
        """Make an empty map.

        Args:
            resolution: Edge of a cell [m].
            size: Extent in both directions [m]; no more than `MAX_EDGE_CELLS` cells are made.
            beams: The robot's beams; None: it has none.
        """
        self.resolution = resolution
        half = max(1, min(math.ceil(size / resolution / 2.0), MAX_EDGE_CELLS // 2))
        self.edge_cells = 2 * half
        self.low = -half * resolution
        self.outside = 0
        self._groups: list[tuple[slice, Evidence]] = []
        if beams is not None:
            groups = beams.groups.values()
            self._groups = [(each, Evidence(beams, each, resolution)) for each in groups]
        reach = max((evidence.reach for _, evidence in self._groups), default=0.0)
        self._frame = math.ceil(reach / resolution) + 1
        self._width = self.edge_cells + 2 * self._frame
        self._flat: Floats = np.zeros(self._width * self._width, np.float32)

    @property
    def log_odds(self) -> Floats:
        """A view of the square, shape (edge_cells, edge_cells), row 0 at the least y."""
        inner = slice(self._frame, self._frame + self.edge_cells)
        return self._flat.reshape(self._width, self._width)[inner, inner]

    def clear(self) -> None:
        """Forget everything."""
        self._flat[:] = 0.0
        self.outside = 0

    def add(self, pose: Pose, ranges: Floats) -> bool:
        """Add a scan.

        Args:
            pose: The robot's pose in `map` at the scan.
            ranges: The range of each beam [m], shape (beams,); inf: no echo; NaN: no evidence.

        Returns:
            Whether it was used: the robot is within the square and its heading is finite.
        """
        within = self.low <= pose.x < -self.low and self.low <= pose.y < -self.low
        if not (within and math.isfinite(pose.theta)):
            self.outside += 1
            return False
        corner = self.low - self._frame * self.resolution
        inside = Pose(x=pose.x - corner, y=pose.y - corner, theta=wrapped(pose.theta))
        for group, evidence in self._groups:
            evidence.add(ranges[group], inside, self._flat, self._width)
        return True

    def whole(self) -> OccupancyMap:
        """The known part, with a border; a few unknown cells for an empty map."""
        known = np.abs(self.log_odds) >= KNOWN
        rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
        middle = [self.edge_cells // 2]
        rows, columns = (rows, columns) if len(rows) else (np.array(middle), np.array(middle))
        border = math.ceil(BORDER / self.resolution)
        return self._picture(
            int(rows[0]) - border,
            int(rows[-1]) + border + 1,
            int(columns[0]) - border,
            int(columns[-1]) + border + 1,
        )

    def window(self, x: float, y: float, width: float, height: float) -> OccupancyMap | None:
        """A part of the map, clipped to the square.

        Args:
            x: Its middle in `map` [m].
            y: The same [m].
            width: Extent along x [m].
            height: Extent along y [m].

        Returns:
            None if nothing of it lies within the square.
        """
        high = self.low + self.edge_cells * self.resolution
        left, right = max(x - width / 2, self.low), min(x + width / 2, high)
        bottom, top = max(y - height / 2, self.low), min(y + height / 2, high)
        if not (left < right and bottom < top):
            return None
        return self._picture(
            math.floor((bottom - self.low) / self.resolution),
            math.ceil((top - self.low) / self.resolution),
            math.floor((left - self.low) / self.resolution),
            math.ceil((right - self.low) / self.resolution),
        )

    def paint(self, picture: OccupancyMap, log_odds: float) -> int:
        """Replace the map by a picture.

        Where cells of the two differ in place, those of the picture go where their middle
        is; a cell that gets several is occupied if one of them is.

        Args:
            picture: Any resolution and origin; below 50 is free, above occupied.
            log_odds: New value of free and occupied cells, minus or plus.

        Returns:
            The number of the picture's known cells outside of the square.
        """
        self.clear()
        lost = 0
        for sign, wanted in (
            (-1.0, (picture.cells >= 0) & (picture.cells < 50)),
            (1.0, picture.cells > 50),
        ):
            rows, columns = np.nonzero(wanted)
            x = picture.origin_x + (columns + 0.5) * picture.resolution
            y = picture.origin_y + (rows + 0.5) * picture.resolution
            columns = np.floor((x - self.low) / self.resolution).astype(np.intp)
            rows = np.floor((y - self.low) / self.resolution).astype(np.intp)
            inside = (rows >= 0) & (rows < self.edge_cells)
            inside &= (columns >= 0) & (columns < self.edge_cells)
            lost += len(rows) - int(inside.sum())
            self.log_odds[rows[inside], columns[inside]] = sign * log_odds
        return lost

    def kept(self) -> LogOdds:
        """The known part, for a mission."""
        return LogOdds.of(self.log_odds, self.resolution, self.low, self.low)

    def restore(self, kept: LogOdds) -> int:
        """Replace the map by a stored one.

        Returns:
            The number of its known cells outside of the square.
        """
        left = (kept.origin_x - self.low) / self.resolution
        bottom = (kept.origin_y - self.low) / self.resolution
        column, row = round(left), round(bottom)
        height, width = kept.cells.shape
        aligned = math.isclose(kept.resolution, self.resolution) and (
            max(abs(left - column), abs(bottom - row)) < _ALIGNED
        )
        within = min(row, column) >= 0 and max(row + height, column + width) <= self.edge_cells
        if aligned and within:
            self.clear()
            self.log_odds[row : row + height, column : column + width] = kept.values
            return 0
        shown = np.where(kept.cells == 0, -1, np.where(kept.cells > 0, 100, 0)).astype(np.int8)
        picture = OccupancyMap(
            cells=shown,
            resolution=kept.resolution,
            origin_x=kept.origin_x,
            origin_y=kept.origin_y,
        )
        return self.paint(picture, LOADED)

    def _picture(self, bottom: int, top: int, left: int, right: int) -> OccupancyMap:
        """Rows from `bottom` and columns from `left` on."""
        bottom, left = max(bottom, 0), max(left, 0)
        top, right = min(top, self.edge_cells), min(right, self.edge_cells)
        part = self.log_odds[bottom:top, left:right]
        shown = _PERCENT / _STEP / (1.0 + np.exp(-part))
        cells = np.rint(shown).astype(np.int8) * np.int8(_STEP)
        cells[np.abs(part) < KNOWN] = -1
        return OccupancyMap(
            cells=cells,
            resolution=self.resolution,
            origin_x=self.low + left * self.resolution,
            origin_y=self.low + bottom * self.resolution,
        )
