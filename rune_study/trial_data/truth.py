"""The true arena of a simulated trial: its ground as cells, and the places of its victims."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np

from hub.pose import Pose
from hub.sim.arena import Footprints, arena_from_spec, arena_path, load_arena
from hub.sim.arena_file import read_arena_file
from hub.values import dataclass
from rune_study.metrics.coverage import TrueGrid, reachable
from rune_study.metrics.map_quality import middles, surface
from rune_study.statistics.arrays import Flags, Floats

RESOLUTION = 0.05
"""Edge of a cell of the true ground [m]."""
RADIUS = 0.25
"""Of the robot that has to fit where ground counts as reachable [m]."""


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What is true of an arena.

    Attributes:
        grid: Its ground.
        victims: Places of its victims [m] (victims, 2).
        start: Where a rover starts; a `map` begins there.
    """

    grid: TrueGrid
    victims: Floats
    start: Pose

    @functools.cached_property
    def reachable(self) -> Flags:
        """Cells that a robot can reach from the start (height, width)."""
        return reachable(self.grid, (self.start.x, self.start.y), RADIUS)

    @functools.cached_property
    def surface(self) -> Floats:
        """Middles of the surfaces that face the space of the start [m] (n, 2)."""
        space = reachable(self.grid, (self.start.x, self.start.y), 0.0)
        cells = surface(self.grid, space)
        return middles(cells, RESOLUTION, self.grid.origin_x, self.grid.origin_y)

    def victims_in_map(self) -> list[tuple[float, float]]:
        """Places of its victims in the `map` of a robot that began at the start [m]."""
        return [self.start.inward(x, y) for x, y in self.victims.tolist()]


@functools.lru_cache(maxsize=8)
def truth_of(arena: str) -> Truth:
    """The truth of an arena, by its name or path.

    Raises:
        ArenaError: It cannot be read.
    """
    made = load_arena(arena)
    spec = read_arena_file(arena_path(arena))
    return Truth(
        grid=grid_of(made.footprints),
        victims=np.array([victim.at for victim in spec.victims], float).reshape(-1, 2),
        start=made.start,
    )


@functools.lru_cache(maxsize=8)
def walls_of(arena: str) -> TrueGrid:
    """The ground of an arena without its victims, as people may see it.

    Raises:
        ArenaError: It cannot be read.
    """
    spec = read_arena_file(arena_path(arena))
    return grid_of(arena_from_spec(dataclasses.replace(spec, victims=())).footprints)


def grid_of(footprints: Footprints) -> TrueGrid:
    """The obstacles of an arena as cells; a cell is blocked if its middle is in one."""
    ends = [*footprints.low, *footprints.high, *footprints.centre]
    low = np.min(ends, axis=0) - RESOLUTION if ends else np.zeros(2)
    high = np.max(ends, axis=0) + RESOLUTION if ends else np.ones(2)
    width, height = (math.ceil(each / RESOLUTION) for each in high - low)
    x = low[0] + (np.arange(width) + 0.5) * RESOLUTION
    y = (low[1] + (np.arange(height) + 0.5) * RESOLUTION)[:, None]
    blocked = np.zeros((height, width), bool)
    for (x0, y0), (x1, y1) in zip(footprints.low, footprints.high, strict=True):
        rows = slice(*np.searchsorted(y[:, 0], (y0, y1)))
        blocked[rows, slice(*np.searchsorted(x, (x0, x1)))] = True
    for (cx, cy), radius in zip(footprints.centre, footprints.radius, strict=True):
        blocked |= np.hypot(x - cx, y - cy) <= radius
    return TrueGrid(
        blocked=blocked, resolution=RESOLUTION, origin_x=float(low[0]), origin_y=float(low[1])
    )
