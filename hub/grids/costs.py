"""The cost for a round robot to cross each cell of a map."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.grids.clearance import clearance
from hub.grids.grid import Grid
from hub.grids.wavefront import Cell, Costs
from hub.values import dataclass

TIGHT = 10.0
"""Cost of a cell that is nearer to an obstacle than the radius, if it may be crossed."""
SQUEEZE = 0.5
"""Share of the radius to keep free in a tight place.

Sonars and drifting odometry make walls of a map thicker. The robot sees the real ones on the way.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Caution:
    """How a path avoids obstacles and the unknown.

    Attributes:
        radius: Of the robot [m]: its middle never comes nearer to an occupied cell's middle.
        comfort: Obstacles farther than this beyond the radius cost nothing [m].
        nearness: Additional cost of a cell at the radius, in widths of a cell; falls to 0 with the
            square of the distance that is left to `comfort`.
        squeeze: Cells between this distance [m] and the radius cost TIGHT.
        unknown: Additional cost of a cell not known to be free; inf: it cannot be crossed.
    """

    radius: float
    comfort: float = 0.3
    nearness: float = 3.0
    unknown: float = 1.0
    squeeze: float = math.inf


def crossing(grid: Grid, start: Cell, caution: Caution) -> Costs:
    """The cost to cross each cell, per width of a cell, at least 1; inf: it cannot be crossed.

    A robot may start nearer to an obstacle than its radius. Then it may cross the cells around it
    that are not nearer still, so that it can get out.

    Args:
        grid: The map.
        start: Row and column where the robot is, within the grid.
        caution: How to avoid obstacles.

    Returns:
        Factors, shape (height, width).
    """
    distance = clearance(grid.occupied, grid.resolution, caution.radius + caution.comfort)
    factors = np.ones(grid.cells.shape)
    if caution.comfort > 0.0:
        lack = (caution.radius + caution.comfort - distance) / np.float32(caution.comfort)
        factors += caution.nearness * np.clip(lack, 0.0, 1.0) ** 2
    factors[~grid.free] += caution.unknown
    tight = distance < caution.radius
    factors[tight] += TIGHT - 1.0
    factors[tight & (distance < caution.squeeze)] = np.inf
    if not math.isfinite(factors[start]):
        _let_out(factors, distance, start, caution.radius / grid.resolution)
    return factors


def _let_out(
    factors: Costs, distance: npt.NDArray[np.float32], start: Cell, radius_cells: float
) -> None:
    """Open the cells within the robot's radius around the start that are not tighter than it."""
    reach = math.ceil(radius_cells) + 1
    rows = slice(max(start[0] - reach, 0), start[0] + reach + 1)
    columns = slice(max(start[1] - reach, 0), start[1] + reach + 1)
    row, column = np.ogrid[rows, columns][:2]
    here = factors[rows, columns]
    near = np.hypot(row - start[0], column - start[1]) <= reach
    tight = near & ~np.isfinite(here) & (distance[rows, columns] >= distance[start])
    here[tight] = TIGHT
