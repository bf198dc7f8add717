"""The first way of an exploration: straight ahead, so that the first walls are drawn true; pure.

Where the robot starts its heading is exact, as `map` is made by it. Wheels hardly lose the heading
on a straight way, and lose degrees of it in a turn. What is drawn before the first turn is what
later turns are corrected by; a turn that comes first turns the whole map.
"""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.clearance import clearance
from hub.grids.grid import Grid

LONGEST = 3.0
"""A longer base line makes the map no truer [m]."""
SHORTEST = 0.5
"""A shorter one is not worth a way [m]."""
AT_START = 0.1
"""A robot that is farther from its start than this [m or rad] has turned or gone already."""


def stands_as_it_began(x: float, y: float, theta: float) -> bool:
    """Whether the robot is at the origin of `map` [m] and looks along its x axis [rad]."""
    return math.hypot(x, y) < AT_START and abs(theta) < AT_START


def straight_ahead(
    grid: Grid, x: float, y: float, theta: float, *, radius: float, longest: float
) -> Point | None:
    """The farthest place that a straight way over free ground leads to.

    Args:
        grid: The map.
        x: Of the robot in `map` [m].
        y: Likewise [m].
        theta: Its heading [rad].
        radius: The robot's, with the margin it must keep [m].
        longest: No farther than this [m].

    Returns:
        None if that is nearer than SHORTEST.
    """
    steps = np.arange(0.0, longest + grid.resolution, grid.resolution)
    rows = np.floor((y + steps * math.sin(theta) - grid.origin_y) / grid.resolution).astype(np.intp)
    columns = np.floor((x + steps * math.cos(theta) - grid.origin_x) / grid.resolution)
    columns = columns.astype(np.intp)
    inside = (rows >= 0) & (rows < grid.height_cells)
    inside &= (columns >= 0) & (columns < grid.width_cells)
    steps, rows, columns = steps[inside], rows[inside], columns[inside]
    away = clearance(grid.occupied, grid.resolution, radius + grid.resolution)[rows, columns]
    # The robot stands where it stands, whatever the map says of that.
    closed = (steps > radius) & ((away < radius) | ~grid.free[rows, columns])
    way = steps[: int(closed.argmax())] if closed.any() else steps
    if not len(way) or way[-1] < SHORTEST:
        return None
    return Point(x=x + float(way[-1]) * math.cos(theta), y=y + float(way[-1]) * math.sin(theta))
