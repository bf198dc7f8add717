"""How long a mark takes until it is on the disk, and a mission until it is back after a crash."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.figures import report
from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions.folder import MissionFolder
from hub.missions.keeper import MissionKeeper, MissionLimits
from hub.missions.points import MAX_THUMBNAIL_BYTES
from hub.modules.mapping.grid import OccupancyGrid

MARKS = 100
CHANGES = 400
CELL, SIZE = 0.05, 40.0


def main() -> None:
    """A mission of many marks and changes, each with the largest picture, and a whole map."""
    with tempfile.TemporaryDirectory(dir=os.environ.get("BENCH_FOLDER")) as folder:
        keeper = MissionKeeper(MissionFolder(Path(folder), "rover"), MissionLimits())
        keeper.open()
        picture = np.random.default_rng(1).integers(0, 256, MAX_THUMBNAIL_BYTES, np.uint8)
        took = []
        for number in range(MARKS + CHANGES):
            known = number >= MARKS
            point = InterestPoint(
                number=number % MARKS + 1 if known else 0,
                version=number // MARKS if known else 0,
                kind=PointKind.VICTIM, x=float(number), y=1.0, by="Ada", note=f"{number}",
                thumbnail=picture,
            )  # fmt: skip
            began = time.monotonic()
            keeper.mark(point, "Ada")
            took.append(time.monotonic() - began)
        grid = OccupancyGrid(CELL, SIZE)
        grid.log_odds[:] = np.random.default_rng(2).uniform(-2.0, 3.5, grid.log_odds.shape)
        began = time.monotonic()
        keeper.save_map(grid.kept())
        saved = time.monotonic() - began
        keeper.close()
        again = MissionKeeper(MissionFolder(Path(folder), "rover"), MissionLimits())
        began = time.monotonic()
        kept = again.open()
        if kept is not None:
            OccupancyGrid(CELL, SIZE).restore(kept)
        back = time.monotonic() - began
        again.close()
    took.sort()
    report("missions.mark_p50_ms", 1e3 * statistics.median(took), "ms", bar=50.0)
    report("missions.mark_p99_ms", 1e3 * took[int(0.99 * len(took))], "ms", bar=500.0)
    report("missions.save_map_ms", 1e3 * saved, "ms", bar=500.0)
    report("missions.back_after_crash_s", back, "s", bar=1.0)


if __name__ == "__main__":
    main()
