"""Reachable cells of a map, and the area on which the robot can stand."""

from __future__ import annotations

import math

import numpy as np

from hub.grids.clearance import clearance
from hub.grids.costs import SQUEEZE, TIGHT, Caution, crossing
from hub.grids.grid import Grid
from hub.grids.wavefront import Costs, spread


def ways(
    grid: Grid, start: tuple[float, float], *, radius: float, squeeze: float = SQUEEZE
) -> Costs:
    """Length of the path to each free cell where the robot can stay.

    Args:
        grid: The map.
        start: The robot's place, within the map [m].
        radius: The robot's, with the margin it must keep [m].
        squeeze: Places that keep only this share of the radius free cost ten times as much.

    Returns:
        Lengths [cells], shape (height, width); inf: the robot cannot go there, or cannot stay
        there.
    """
    first = grid.cell(*start)
    keeps = squeeze * radius
    caution = Caution(radius=radius, comfort=0.0, unknown=math.inf, squeeze=keeps)
    factors = crossing(grid, first, caution)
    costs = spread(factors, first)
    costs[factors >= TIGHT] = np.inf  # the robot may pass there, but not stay
    return costs


def standing_ground(grid: Grid, lengths: Costs, room: float) -> float:
    """The area of free ground that the robot can reach and fits on.

    Strips along the unknown do not count: sensors that look through a wall make them.

    Args:
        grid: The map.
        lengths: The result of `ways` for it.
        room: Radius around the robot's middle that must be free [m].

    Returns:
        Its area [m^2].
    """
    blocked = np.pad(~grid.free, 1, constant_values=True)
    away = clearance(blocked, grid.resolution, room + grid.resolution)[1:-1, 1:-1]
    cells = np.count_nonzero(np.isfinite(lengths) & (away >= room))
    return float(cells) * grid.resolution**2
