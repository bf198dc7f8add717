"""The evidence of a scan of range sensors for the cells around the robot; pure.

The inverse sensor model is that of Thrun, Burgard and Fox (2005, table 9.2) in log-odds, with the
weights of Moravec and Elfes (1985). Evidence falls with the angle from a sensor's axis and with
the range. The evidence of an echo is shared among the cells of its arc by their occupancy so far.

Smooth walls reflect a sonar's beam away, so an echo may come from behind a wall in the cone. So
cells at or behind a known wall get little evidence for free, and none for occupied.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import SENSOR_COUNT
from hub.values import dataclass

Floats = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorModel:
    """The sensor model of one ring of sensors.

    Attributes:
        cone: Opening angle within which a range is evidence [rad].
        least_width: Least width of a cone [m].
        farthest: Cells farther from the centre get no evidence [m].
        depth: Thickness of the arc of an echo [m].
        occupied: Log-odds of an echo on the axis, at a short range.
        free: Log-odds of the space before it, negative.
        silent: Length of the cone that is free without an echo [m]; 0: none.
    """

    cone: float
    least_width: float
    farthest: float
    depth: float
    occupied: float
    free: float
    silent: float


SONAR = SensorModel(
    cone=math.radians(22.0),
    least_width=0.0,
    farthest=3.0,
    depth=0.07,
    occupied=0.85,
    free=-0.4,
    silent=1.0,
)
"""No echo is weak evidence: a wall at more than 25 degrees of incidence gives none."""
INFRARED = SensorModel(
    cone=math.radians(4.0),
    least_width=0.06,
    farthest=1.1,
    depth=0.07,
    occupied=1.5,
    free=-0.5,
    silent=0.0,
)
"""No hit is no evidence: dark surfaces give none."""

WALL = 1.0
"""From these log-odds on a cell counts as a known wall."""
BEHIND_WALL = 0.2
"""Share of the evidence for free space that counts from a known wall on."""
HIDDEN = 0.2
"""An echo comes from no cell that is farther than this behind a wall in the same direction [m]."""

_SECTOR = 2.0 * math.pi / SENSOR_COUNT
_DIRECTIONS = 128
"""Number of directions in the search for hidden cells; a power of two."""
_LEAST_DEPTH_CELLS = 1.4
_NOTHING = 1e-6


class Evidence:
    """Computes the evidence of scans of one ring of sensors; large arrays are allocated once.

    Cells are ordered by their distance from the robot's cell, so a short scan costs little. Each
    cell belongs to the sensor with the nearest axis; cones overlap only a little.

    Attributes:
        reach_cells: Largest distance of a cell from the robot's, along rows or columns.
    """

    def __init__(self, model: SensorModel, resolution: float) -> None:
        """Prepare.

        Args:
            model: Of the sensors.
            resolution: Edge of a cell [m].
        """
        self._model = model
        self._resolution = np.float32(resolution)
        self._half_depth = np.float32(max(model.depth, _LEAST_DEPTH_CELLS * resolution) / 2.0)
        self.reach_cells = math.ceil(model.farthest / resolution) + 1
        span = np.arange(-self.reach_cells, self.reach_cells + 1)
        rows, columns = (axis.ravel() for axis in np.meshgrid(span, span, indexing="ij"))
        away = np.hypot(rows, columns) * resolution
        order = np.argsort(away, kind="stable")
        order = order[: np.searchsorted(away[order], model.farthest + resolution)]
        self._rows, self._columns = rows[order], columns[order]
        self._from_middle: Floats = away[order].astype(np.float32)
        self._x: Floats = (self._columns * resolution).astype(np.float32)
        self._y: Floats = (self._rows * resolution).astype(np.float32)
        count = len(order)
        self._away, self._angle, self._weight, self._fade, self._spare, self._change = np.empty(
            (6, count), np.float32
        )
        self._sensor: Indices = np.empty(count, np.intp)
        self._direction: Indices = np.empty(count, np.intp)

    def offsets(self, width_cells: int) -> Indices:
        """Offset of each cell from the robot's in a flat grid of this width, shape (cells,)."""
        return (self._rows * width_cells + self._columns).astype(np.intp)

    def change(
        self, ranges: Floats, x: float, y: float, theta: float, flat: Floats, cells: Indices
    ) -> Floats:
        """The change of the log-odds by a scan.

        Args:
            ranges: From the robot's centre [m], shape (16,); inf: no echo; NaN: no evidence.
            x: The robot's place in its cell, from the cell's middle [m].
            y: The same [m].
            theta: Heading [rad].
            flat: The log-odds so far, of the whole grid.
            cells: Indices of the cells in it, shape (cells,).

        Returns:
            The change for the first cells of `cells`; the others are out of reach. Valid until
            the next call.
        """
        model = self._model
        echoes = np.where(ranges + self._half_depth <= model.farthest, ranges, np.float32(np.nan))
        ends = np.where(np.isinf(ranges), np.float32(model.silent), ranges - self._half_depth)
        ends = np.nan_to_num(np.minimum(ends, np.float32(model.farthest))).astype(np.float32)
        reach = max(ends.max(), np.nan_to_num(echoes).max() + self._half_depth)
        count = int(np.searchsorted(self._from_middle, reach + self._resolution))
        before = np.take(flat, cells[:count], out=self._spare[:count], mode="clip")
        self._measure(count, x, y, theta)
        change = self._change[:count]
        walls = np.flatnonzero((before > WALL) & (self._weight[:count] > 0.0))
        self._free(count, ends, walls, change)
        self._occupied(count, echoes, before, walls, change)
        return change

    def _measure(self, count: int, x: float, y: float, theta: float) -> None:
        """Compute the range, the sensor and the weight of each cell."""
        model = self._model
        away, angle, weight = self._away[:count], self._angle[:count], self._weight[:count]
        fade, sensor = self._fade[:count], self._sensor[:count]
        direction = self._direction[:count]
        np.subtract(self._x[:count], np.float32(x), out=weight)
        np.subtract(self._y[:count], np.float32(y), out=fade)
        np.hypot(weight, fade, out=away)
        np.arctan2(fade, weight, out=angle)
        angle -= np.float32(theta)
        angle *= np.float32(1.0 / _SECTOR)
        np.multiply(angle, np.float32(_DIRECTIONS / SENSOR_COUNT), out=weight)
        np.copyto(direction, weight, casting="unsafe")
        direction &= _DIRECTIONS - 1
        np.rint(angle, out=weight)
        np.copyto(sensor, weight, casting="unsafe")
        sensor &= SENSOR_COUNT - 1
        angle -= weight
        angle *= np.float32(_SECTOR)
        # Half the cone's angle at each cell; then 1 on the axis and 0 at the cone's edge.
        np.maximum(away, self._resolution, out=weight)
        np.divide(np.float32(model.least_width / 2.0), weight, out=weight)
        np.maximum(weight, np.float32(model.cone / 2.0), out=weight)
        np.divide(angle, weight, out=weight)
        np.multiply(weight, weight, out=weight)
        np.subtract(np.float32(1.0), weight, out=weight)
        np.maximum(weight, np.float32(0.0), out=weight)
        np.multiply(away, np.float32(-1.0 / model.farthest), out=fade)
        fade += np.float32(1.0)
        np.maximum(fade, np.float32(0.0), out=fade)

    def _free(self, count: int, ends: Floats, walls: Indices, change: Floats) -> None:
        """Evidence for the free space of the beams."""
        away, weight = self._away[:count], self._weight[:count]
        sensor, limit = self._sensor[:count], self._angle[:count]
        np.multiply(weight, self._fade[:count], out=change)
        change *= np.float32(self._model.free)
        np.take(ends, sensor, out=limit, mode="clip")
        change *= away < limit
        first = np.full(SENSOR_COUNT, np.inf, np.float32)
        np.minimum.at(first, sensor[walls], away[walls])
        first -= self._half_depth
        np.take(first, sensor, out=limit, mode="clip")
        np.multiply(change, np.float32(BEHIND_WALL), out=change, where=away > limit)

    def _occupied(
        self, count: int, echoes: Floats, before: Floats, walls: Indices, change: Floats
    ) -> None:
        """Evidence for the arcs of the echoes; the likeliest cell of each arc gets all of it."""
        away, weight = self._away[:count], self._weight[:count]
        sensor, beyond = self._sensor[:count], self._angle[:count]
        np.take(echoes, sensor, out=beyond, mode="clip")
        beyond -= away
        np.abs(beyond, out=beyond)
        arc = np.flatnonzero((beyond <= self._half_depth) & (weight > 0.0))
        if not len(arc):
            return
        owner = sensor[arc]
        share = weight[arc] / (1.0 + np.exp(-before[arc]))
        best = np.full(SENSOR_COUNT, _NOTHING, np.float32)
        np.maximum.at(best, owner, share)
        share /= best[owner]
        hidden = np.full(_DIRECTIONS, np.inf, np.float32)
        np.minimum.at(hidden, self._direction[walls], away[walls] + np.float32(HIDDEN))
        share[away[arc] > hidden[self._direction[arc]]] = 0.0
        change[arc] = np.float32(self._model.occupied) * share * share * self._fade[arc]
