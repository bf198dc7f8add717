"""What it costs a round robot to cross the cells of a map, and how it gets out of a tight place."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hub.grids.clearance import clearance
from hub.grids.grid import Grid
from hub.grids.wavefront import Cell, Costs

TIGHT = 10.0
"""What a cell costs that is nearer to an obstacle than the radius, where it may be crossed."""
SQUEEZE = 0.5
"""How much of the radius is left where the map makes things narrower than they are.

Sonars and drifting odometry thicken what they see; what is really there the robot sees on the way.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Caution:
    """How a way keeps off obstacles and the unknown.

    Attributes:
        radius: Of the robot [m]: its middle never comes nearer to an occupied cell's middle.
        comfort: Distance beyond the radius from which on obstacles cost nothing [m].
        nearness: What a cell at the radius costs more, in widths of a cell; falls to 0 with the
            square of the distance that is left to `comfort`.
        squeeze: Cells that are nearer than the radius, but not nearer than this [m], cost TIGHT.
        unknown: What a cell that is not known to be free costs more; inf: it cannot be crossed.
    """

    radius: float
    comfort: float = 0.3
    nearness: float = 3.0
    unknown: float = 1.0
    squeeze: float = math.inf


def crossing(grid: Grid, start: Cell, caution: Caution) -> Costs:
    """What it costs to cross each cell by its own width, 1 at least; inf: it cannot be crossed.

    Where the robot starts nearer to an obstacle than its radius, the cells around it that are not
    nearer still may be crossed too, so that it can get out.

    Args:
        grid: The map.
        start: Row and column where the robot is, within the grid.
        caution: How to keep off obstacles.

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
    """Open the cells within the robot's radius around the start that are no tighter than it."""
    reach = math.ceil(radius_cells) + 1
    rows = slice(max(start[0] - reach, 0), start[0] + reach + 1)
    columns = slice(max(start[1] - reach, 0), start[1] + reach + 1)
    row, column = np.ogrid[rows, columns][:2]
    here = factors[rows, columns]
    near = np.hypot(row - start[0], column - start[1]) <= reach
    tight = near & ~np.isfinite(here) & (distance[rows, columns] >= distance[start])
    here[tight] = TIGHT
