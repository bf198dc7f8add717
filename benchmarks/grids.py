"""Cost of looking for ways over grid maps: clearance, a planned way, frontiers."""

from __future__ import annotations

import numpy as np

from benchmarks.figures import median_ms, report
from hub.grids.clearance import clearance
from hub.grids.frontiers import frontiers
from hub.grids.grid import Grid
from hub.grids.planner import plan

RADIUS = 0.255
NOTE = "cells of 5 cm, median, one core"


def scattered(edge_cells: int, share: float) -> Grid:
    """Free ground with single occupied cells, the same in every run."""
    random = np.random.default_rng(2003)
    cells = np.where(random.random((edge_cells, edge_cells)) < share, 100, 0).astype(np.int8)
    cells[:30, :30] = cells[-30:, -30:] = 0
    return Grid(cells=cells, resolution=0.05, origin_x=0.0, origin_y=0.0)


def maze(edge_cells: int, every: int) -> Grid:
    """Corridors back and forth, so that the way leads over nearly all the ground."""
    grid = scattered(edge_cells, 0.0)
    for number, row in enumerate(range(every, edge_cells, every)):
        grid.cells[row] = 100
        grid.cells[row, slice(-every + 1, None) if number % 2 else slice(0, every - 1)] = 0
    return grid


def main() -> None:
    ground = scattered(800, 0.01)
    value = median_ms(lambda _: clearance(ground.occupied, 0.05, 0.6), 9)
    report("grids.clearance_800x800_ms", value, "ms", bar=50, note=NOTE + ", up to 0.6 m")

    ways = {"scattered": (scattered(300, 0.002), 14.5), "maze": (maze(300, 20), 14.6)}
    for name, (grid, end) in ways.items():
        way = plan(grid, (0.4, 0.4), (end, end), radius=RADIUS)
        value = median_ms(lambda _, g=grid, e=end: plan(g, (0.4, 0.4), (e, e), radius=RADIUS), 9)
        note = f"{NOTE}, from corner to corner, {len(way or ())} points"
        report(f"grids.plan_300x300_{name}_ms", value, "ms", bar=100, note=note)

    half = scattered(300, 0.001)
    half.cells[:, 200:] = -1
    value = median_ms(lambda _: frontiers(half, (0.4, 0.4), radius=RADIUS), 9)
    report("grids.frontiers_300x300_ms", value, "ms", bar=100, note=NOTE + ", a third unknown")


if __name__ == "__main__":
    main()
