"""The first path of an exploration: straight ahead, so that the first walls are exact; pure.

At the start the heading is exact, because it defines `map`. Dead reckoning keeps the heading well
on a straight line, and loses degrees of it in a turn. The walls from before the first turn correct
later turns. An early turn would turn the whole map.
"""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.clearance import clearance
from hub.grids.grid import Grid

LONGEST = 3.0
"""Largest length of the base line; a longer one makes the map no better [m]."""
SHORTEST = 0.5
"""Least length of the base line [m]."""
AT_START = 0.1
"""A robot farther from its start has moved or turned already [m or rad]."""


def stands_as_it_began(x: float, y: float, theta: float) -> bool:
    """Whether the robot is at the origin of `map` [m] and faces along its x axis [rad]."""
    return math.hypot(x, y) < AT_START and abs(theta) < AT_START


def straight_ahead(
    grid: Grid, x: float, y: float, theta: float, *, radius: float, longest: float
) -> Point | None:
    """The farthest place on a straight line over free ground.

    Args:
        grid: The map.
        x: The robot's position in `map` [m].
        y: The same [m].
        theta: Its heading [rad].
        radius: The robot's, with the margin it must keep [m].
        longest: Largest distance [m].

    Returns:
        The place; None: it is nearer than SHORTEST.
    """
    steps = np.arange(0.0, longest + grid.resolution, grid.resolution)
    rows = np.floor((y + steps * math.sin(theta) - grid.origin_y) / grid.resolution).astype(np.intp)
    columns = np.floor((x + steps * math.cos(theta) - grid.origin_x) / grid.resolution)
    columns = columns.astype(np.intp)
    inside = (rows >= 0) & (rows < grid.height_cells)
    inside &= (columns >= 0) & (columns < grid.width_cells)
    steps, rows, columns = steps[inside], rows[inside], columns[inside]
    away = clearance(grid.occupied, grid.resolution, radius + grid.resolution)[rows, columns]
    # The robot's own place is free, even if the map says otherwise.
    closed = (steps > radius) & ((away < radius) | ~grid.free[rows, columns])
    way = steps[: int(closed.argmax())] if closed.any() else steps
    if not len(way) or way[-1] < SHORTEST:
        return None
    return Point(x=x + float(way[-1]) * math.cos(theta), y=y + float(way[-1]) * math.sin(theta))
