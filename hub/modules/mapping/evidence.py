"""The evidence of range sensors for the cells around the robot; pure.

The inverse sensor model is that of Thrun, Burgard and Fox (2005, table 9.2) in log-odds, with the
weights of Moravec and Elfes (1985). A narrow beam is one ray. A wide cone is a fan of rays, and its
evidence falls with the angle from the axis and with the range. The evidence of an echo is shared
among the cells of its arc by their occupancy so far.

Smooth walls reflect a sonar's beam away, so an echo may come from behind a wall in the cone. So
cells at or behind a known wall get little evidence for free, and none for occupied.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from hub.gcm.beams import Beams
from hub.gcm.body import RangeKind
from hub.pose import Pose
from hub.values import dataclass

Floats = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorModel:
    """What ranges of one kind of sensor say.

    Attributes:
        cone: Share of the opening angle within which a range is evidence.
        widest: Cells where the cone is wider than this get no evidence [m].
        occupied: Log-odds of an echo on the axis, at a short range.
        free: Log-odds of the space before it, negative.
        fade: Share of the evidence that is lost at the largest range.
        silent: Share of the largest range that is free without an echo.
        behind_wall: Share of the evidence for free space that counts from a known wall on;
            1: known walls do not matter.
    """

    cone: float
    widest: float = math.inf
    occupied: float
    free: float
    fade: float
    silent: float
    behind_wall: float


_SONAR = SensorModel(
    cone=0.815,
    widest=1.15,
    occupied=0.85,
    free=-0.4,
    fade=1.0,
    silent=1.0 / 3.0,
    behind_wall=0.2,
)
"""No echo is weak evidence: a wall at more than 25 degrees of incidence gives none."""
MODELS: Mapping[RangeKind, SensorModel] = {
    RangeKind.SONAR: _SONAR,
    RangeKind.ECHO_SOUNDER: _SONAR,
    # No hit is no evidence: dark surfaces give none.
    RangeKind.INFRARED: SensorModel(
        cone=1.0, occupied=1.5, free=-0.5, fade=0.9, silent=0.0, behind_wall=0.2
    ),
    # A black surface, which reflects a tenth of a white one's light, is seen a third as far.
    RangeKind.LASER: SensorModel(
        cone=0.0, occupied=1.5, free=-0.5, fade=0.0, silent=1.0 / 3.0, behind_wall=1.0
    ),
}

FARTHEST = 10.0
"""Cells farther from a sensor get no evidence [m]: each metre costs time."""
LEAST, MOST = -2.0, 3.5
"""Bounds of the log-odds, so that some scans are enough to learn a change."""
WALL = 1.0
"""From these log-odds on a cell counts as a known wall."""
HIDDEN = 0.4
"""An echo comes from no cell that is farther than this behind a wall in the same direction [m]."""

_BEFORE = 0.035
"""Space before an echo that gets no evidence [m]."""
_APART = 0.75
"""Largest distance between two rays of a fan [cells]."""
_ROUNDING = 1e-3
"""Largest error of a range by its coding [m]."""


class Evidence:
    """Adds the evidence of one group of equal beams to a grid.

    Attributes:
        reach: Largest distance of a cell that gets evidence, from the robot's origin [m].
    """

    def __init__(self, beams: Beams, group: slice, resolution: float) -> None:
        """Prepare.

        Args:
            beams: All beams of the body.
            group: Those of the group.
            resolution: Edge of a cell [m].
        """
        one = group.start
        self._model = model = MODELS[RangeKind(int(beams.kind[one]))]
        self._resolution = resolution
        self._x, self._y = beams.x[group], beams.y[group]
        self._nearest = np.float32(beams.nearest[one] - _ROUNDING)
        self._farthest = np.float32(beams.farthest[one] + _ROUNDING)
        cone = model.cone * float(beams.opening[one])
        self._limit = min(
            float(beams.farthest[one]), FARTHEST, model.widest / cone if cone else math.inf
        )
        self.reach = self._limit + math.hypot(self._x[0], self._y[0])
        # From the edges of the cone to its axis: of the rays through a cell the last one counts.
        half = max(0, math.ceil((cone * self._limit / resolution / _APART - 1.0) / 2.0))
        offsets = np.append(np.repeat(np.arange(half, 0, -1), 2), 0) / (half + 0.5)
        offsets[1::2] *= -1.0
        self._bearings = beams.bearing[group, None] + offsets * (cone / 2.0)
        self._weights: Floats = (1.0 - np.square(offsets)).astype(np.float32)
        away = (np.arange(math.ceil(self._limit / resolution) + 1) + 0.5) * resolution
        self._away: Floats = away.astype(np.float32)
        free = model.free * (1.0 - model.fade * away / self._limit)
        self._free: Floats = np.minimum(free, 0.0).astype(np.float32)

    def add(self, ranges: Floats, robot: Pose, flat: Floats, width: int) -> None:
        """Add the evidence of a scan.

        Args:
            ranges: Range of each beam [m], shape (beams,); inf: no echo; NaN: no evidence.
            robot: The robot's pose, from the corner of the grid.
            flat: The log-odds of the grid, row by row; they change.
            width: Cells of a row.
        """
        model = self._model
        valid = (ranges >= self._nearest) & (ranges <= self._farthest)
        free = np.where(valid, np.minimum(ranges - _BEFORE, self._limit), 0.0)
        free[np.isposinf(ranges)] = model.silent * self._limit
        used = np.flatnonzero(free > 0.0)
        if not len(used):
            return
        rays = self._rays(used, robot)
        fan = len(self._weights)
        counts = np.repeat((free[used] / self._resolution + 0.5).astype(np.intp), fan)
        step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        away = self._away[step]
        cells = rays.cells(away, width, counts)
        before = flat[cells]
        walls = np.full(len(counts), np.inf, np.float32)
        change = self._free[step]
        if fan > 1:
            change *= np.repeat(np.tile(self._weights, len(used)), counts)
        if model.behind_wall < 1.0:
            known = np.flatnonzero(before > WALL)
            ray = np.repeat(np.arange(len(counts)), counts)
            np.minimum.at(walls, ray[known], away[known])
            nearest = walls.reshape(-1, fan).min(axis=1).repeat(fan) - np.float32(_BEFORE)
            change[away > np.repeat(nearest, counts)] *= np.float32(model.behind_wall)
        arcs, after = self._arcs(rays, ranges[used], walls, flat, width)
        change += before
        flat[cells] = np.maximum(change, np.float32(LEAST), out=change)
        flat[arcs] = after

    def _arcs(
        self, rays: _Rays, ranges: Floats, walls: Floats, flat: Floats, width: int
    ) -> tuple[Indices, Floats]:
        """The cells of the echoes, and their new log-odds; the likeliest of an arc gets most.

        Args:
            rays: The rays of the beams.
            ranges: Range of each beam [m], shape (beams,).
            walls: Distance of the first known wall on each ray [m], shape (rays,); inf: none.
            flat: As in `add`.
            width: As in `add`.
        """
        away = np.repeat(ranges, len(self._weights))
        met = (away <= self._limit).astype(np.intp)
        cells = rays.cells(away[met > 0], width, met)
        away, walls = away[met > 0], walls[met > 0]
        before = flat[cells].reshape(-1, len(self._weights))
        share = self._weights / (1.0 + np.exp(-before))
        share = (share / share.max(axis=1, keepdims=True)).ravel()
        share[away > walls + HIDDEN] = 0.0
        fade = 1.0 - self._model.fade * away / self._limit
        after = before.ravel() + self._model.occupied * np.square(share) * fade
        return cells, np.minimum(after, MOST).astype(np.float32)

    def _rays(self, used: Indices, robot: Pose) -> _Rays:
        """The rays of some beams."""
        x, y = robot.outward(self._x[used], self._y[used])
        directions = (self._bearings[used] + robot.theta).ravel()
        per_metre = 1.0 / self._resolution
        return _Rays(
            x=np.repeat(x * per_metre, len(self._weights)).astype(np.float32),
            y=np.repeat(y * per_metre, len(self._weights)).astype(np.float32),
            along_x=(np.cos(directions) * per_metre).astype(np.float32),
            along_y=(np.sin(directions) * per_metre).astype(np.float32),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Rays:
    """Rays in a grid; arrays of the shape (rays,).

    Attributes:
        x: Begin [cells].
        y: Begin [cells].
        along_x: Direction [cells per metre].
        along_y: Direction [cells per metre].
    """

    x: Floats
    y: Floats
    along_x: Floats
    along_y: Floats

    def cells(self, away: Floats, width: int, counts: Indices) -> Indices:
        """The cells of points on the rays, in a flat grid, ray by ray.

        Args:
            away: Distance of each point from the begin of its ray [m], shape (n,).
            width: Cells of a row.
            counts: Number of points on each ray, shape (rays,).
        """
        columns = np.repeat(self.along_x, counts)
        columns *= away
        columns += np.repeat(self.x, counts)
        rows = np.repeat(self.along_y, counts)
        rows *= away
        rows += np.repeat(self.y, counts)
        return (rows.astype(np.int32) * np.int32(width) + columns.astype(np.int32)).astype(np.intp)
