"""Where the known free ground ends.

Source: B. Yamauchi, A Frontier-Based Approach for Autonomous Exploration, 1997.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.grids.clearance import clearance
from hub.grids.costs import SQUEEZE
from hub.grids.grid import Grid, Mask
from hub.grids.reach import ways
from hub.grids.wavefront import Costs
from hub.values import dataclass

SOLID_CELLS = 4
"""Least number of unknown cells among the 9 around an unknown one; fewer are specks."""

ROOM = 0.75
"""Unknown ground counts where this share of the radius is clear of obstacles."""
GAIN_REACH = 1.5
"""Unknown ground farther behind a frontier does not count as its gain [m]."""

Numbers = npt.NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class Frontier:
    """Free cells side by side that border on the unknown.

    Attributes:
        x: A place from which the robot sees it, in `map` [m].
        y: The same [m].
        length: Number of cells, times their width [m].
        distance: Length of the robot's path to that place [m]; inf: it cannot be reached, and x and
            y are the middle of the frontier's cell nearest to its centre of gravity.
        gain: Unknown ground close behind it where the robot may be able to stand [m^2].
    """

    x: float
    y: float
    length: float
    distance: float
    gain: float = 0.0


def frontiers(
    grid: Grid,
    start: tuple[float, float],
    *,
    radius: float,
    reach: float = 0.3,
    squeeze: float = SQUEEZE,
    shortest: float = 0.0,
    in_sight: bool = True,
) -> tuple[Frontier, ...]:
    """All frontiers of a map, the longest first; those of equal length in reading order.

    Args:
        grid: The map.
        start: The robot's place [m].
        radius: The robot's, with the margin it must keep [m].
        reach: A frontier is reached within this distance, beyond the radius [m].
        squeeze: Places that keep only this share of the radius free cost ten times as much.
        shortest: Shorter frontiers are left out [m].
        in_sight: Whether occupied cells hide a frontier from the robot.

    Returns:
        The frontiers; none if the robot is outside the map.
    """
    if not (all(map(math.isfinite, start)) and grid.contains(*grid.cell(*start))):
        return ()
    edge = np.argwhere(edge_cells(grid))
    if not edge.size:
        return ()
    costs = ways(grid, start, radius=radius, squeeze=squeeze)
    reach_cells = (radius + reach) / grid.resolution
    opaque = grid.occupied if in_sight else np.zeros_like(grid.occupied)
    places, lengths = _standing_places(costs, opaque, edge, reach_cells)
    names = groups(edge, grid.cells.shape)
    ground = _Ground(grid, ROOM * radius)
    found = []
    for name in range(int(names.max()) + 1):
        members = np.flatnonzero(names == name)
        if members.size * grid.resolution >= shortest:
            gain = ground.behind(edge[members])
            found.append(_frontier(grid, edge[members], places[members], lengths[members], gain))
    return tuple(sorted(found, key=lambda frontier: -frontier.length))


def edge_cells(grid: Grid) -> Mask:
    """Free cells beside unknown ones, without specks, shape (height, width)."""
    unknown = np.pad(grid.unknown, 2, constant_values=True)
    count = unknown.astype(np.uint8)
    count[1:-1] = count[:-2] + count[1:-1] + count[2:]
    count[:, 1:-1] = count[:, :-2] + count[:, 1:-1] + count[:, 2:]
    solid = (unknown & (count >= SOLID_CELLS))[1:-1, 1:-1]
    beside = solid[:-2, 1:-1] | solid[2:, 1:-1] | solid[1:-1, :-2] | solid[1:-1, 2:]
    return grid.free & beside


def groups(cells: Numbers, shape: tuple[int, int]) -> Numbers:
    """The group of each cell; cells that touch at a side or a corner are in one group.

    Args:
        cells: Rows and columns, shape (count, 2), in reading order, at least one.
        shape: Rows and columns of the grid.

    Returns:
        Numbers from 0, in the order of each group's first cell, shape (count,).
    """
    index = np.full((shape[0] + 2, shape[1] + 2), -1, np.intp)
    rows, columns = cells[:, 0] + 1, cells[:, 1] + 1
    index[rows, columns] = np.arange(len(cells))
    neighbours = [index[rows + down, columns + 1 - left] for down, left in _AHEAD]
    own = np.tile(np.arange(len(cells)), len(_AHEAD))
    other = np.concatenate(neighbours)
    own, other = own[other >= 0], other[other >= 0]
    label = np.arange(len(cells))
    while True:
        # Each pair hands the smaller label to the root of the larger; then all look up their root.
        low = np.minimum(label[own], label[other])
        high = np.maximum(label[own], label[other])
        if np.array_equal(low, high):
            break
        np.minimum.at(label, high, low)
        while not np.array_equal(label, label[label]):
            label = label[label]
    return np.unique(label, return_inverse=True)[1]


_AHEAD = ((0, 0), (1, 0), (1, 1), (1, 2))
"""Half of a cell's neighbours; the others have it among theirs."""


def _standing_places(
    costs: Costs, opaque_cells: Mask, edge: Numbers, reach_cells: float
) -> tuple[Numbers, npt.NDArray[np.float64]]:
    """For each cell of the edge, the nearest place that sees it, and the path length there.

    Returns:
        Rows and columns, shape (count, 2), and path lengths [cells], shape (count,); inf: no place.
    """
    reach = math.ceil(reach_cells)
    span = np.arange(-reach, reach + 1)
    down, right = (part.reshape(-1) for part in np.meshgrid(span, span, indexing="ij"))
    away = np.hypot(down, right)
    near = np.flatnonzero(away <= reach_cells)
    near = near[np.argsort(away[near], kind="stable")]
    edged = np.pad(costs, reach, constant_values=np.inf)
    stride = edged.shape[1]
    flat = edged.reshape(-1)
    opaque = np.pad(opaque_cells, reach).reshape(-1)
    own = (edge[:, 0] + reach) * stride + edge[:, 1] + reach
    place = own.copy()
    open_ = np.flatnonzero(~np.isfinite(flat[own]))
    for rows, columns in zip(down[near].tolist(), right[near].tolist(), strict=True):
        if not open_.size:
            break
        there = own[open_] + rows * stride + columns
        found = np.isfinite(flat[there])
        if found.any():
            between = _between(rows, columns, stride)
            found &= ~opaque[own[open_][:, None] + between].any(axis=1)
        place[open_[found]] = there[found]
        open_ = open_[~found]
    cells = np.stack((place // stride - reach, place % stride - reach), axis=1)
    return cells, flat[place]


def _between(rows: int, columns: int, stride: int) -> Numbers:
    """Offsets of the cells on the straight line to a cell at this offset, without both ends."""
    steps = max(abs(rows), abs(columns))
    parts = np.arange(1, steps) / max(steps, 1)
    offsets: Numbers = (np.rint(parts * rows) * stride + np.rint(parts * columns)).astype(np.intp)
    return offsets


class _Ground:
    """Unknown ground in which the robot may be able to stand."""

    def __init__(self, grid: Grid, room: float) -> None:
        """Find the unknown ground of a map.

        Args:
            grid: The map; beyond it nothing is known.
            room: Distance of the robot's middle from obstacles [m].
        """
        self._reach = math.ceil(GAIN_REACH / grid.resolution)
        self._cell = grid.resolution**2
        away = clearance(grid.occupied, grid.resolution, room + grid.resolution)
        frame = self._reach + 2
        self._open = np.pad(grid.unknown & (away >= room), frame, constant_values=True)
        self._frame = frame

    def behind(self, edge: Numbers) -> float:
        """The area of it that is connected to a frontier's cells within GAIN_REACH [m^2]."""
        low = edge.min(axis=0)
        high = edge.max(axis=0) + 2 * self._frame + 1
        ground = self._open[low[0] : high[0], low[1] : high[1]]
        come = np.zeros_like(ground)
        rows, columns = (edge - low + self._frame).T
        come[rows, columns] = True
        beside = come = _wider(_wider(come)) & ground
        for step in range(self._reach):
            # Every other step includes the corners: the reach is nearly round.
            wider = (_wider(come) if step % 2 else _beside(come)) & ground
            if np.array_equal(wider, come):
                break
            come = wider
        return float(np.count_nonzero(come)) * self._cell if beside.any() else 0.0


def _beside(cells: Mask) -> Mask:
    """The cells and those that touch one of them at a side."""
    wide = cells.copy()
    wide[1:] |= cells[:-1]
    wide[:-1] |= cells[1:]
    wide[:, 1:] |= cells[:, :-1]
    wide[:, :-1] |= cells[:, 1:]
    return wide


def _wider(cells: Mask) -> Mask:
    """The cells and those that touch one of them at a side or a corner."""
    wide = cells.copy()
    wide[1:] |= cells[:-1]
    wide[:-1] |= cells[1:]
    across = wide.copy()
    across[:, 1:] |= wide[:, :-1]
    across[:, :-1] |= wide[:, 1:]
    return across


def _frontier(
    grid: Grid, edge: Numbers, places: Numbers, ways: npt.NDArray[np.float64], gain: float
) -> Frontier:
    """The frontier of these cells; the robot should stand near its middle."""
    reachable = np.flatnonzero(np.isfinite(ways))
    candidates = reachable if reachable.size else np.arange(len(edge))
    middle = edge[candidates].mean(axis=0)
    best = candidates[int(np.argmin(np.hypot(*(edge[candidates] - middle).T)))]
    row, column = places[best] if reachable.size else edge[best]
    x, y = grid.centre(int(row), int(column))
    return Frontier(
        x=x,
        y=y,
        length=len(edge) * grid.resolution,
        distance=float(ways[best]) * grid.resolution if reachable.size else math.inf,
        gain=gain,
    )
