"""The map: what a scan costs, and how true it is after a tour through the yellow arena."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np

from benchmarks.figures import median_ms, report, say
from hub.gcm.beam_scans import ScanReader
from hub.gcm.beams import beams_of
from hub.gcm.body import RangeGroup, RangeKind, RobotBody
from hub.modules.mapping.grid import OccupancyGrid
from hub.modules.mapping.scans import ScanSelector
from hub.pose import Pose
from hub.sim.arena import load_arena
from hub.sim.plane_rays import first_hits
from tests.hub.modules.mapping.touring import (
    BEAMS,
    MatchedPose,
    PoseSource,
    Report,
    mapped,
    score,
    state_of,
    surfaces_in_sight,
    tour,
    true_pose,
)
from tests.support.magellan import SimulatedMagellan, magellan_body

SEEDS = (1, 2, 3)
RESOLUTION, SIZE = 0.05, 40.0
CORRECTION_PERIOD = 20.0
"""How often the operator corrects the pose by a landmark, in the figure that has it [s]."""
TOUR = (
    *((5.2, 4.6), (2.7, 4.35), (2.7, 1.9), (1.9, 1.5), (5.2, 1.4), (6.1, 1.1), (7.6, 1.3)),
    *((7.6, 2.4), (9.0, 2.3), (7.6, 2.4), (7.6, 4.7), (5.2, 4.7), (5.2, 7.5), (4.35, 7.7)),
    *((4.28, 8.28), (3.3, 8.35), (3.2, 7.3), (0.9, 7.3), (3.2, 7.3), (3.3, 8.35), (4.28, 8.28)),
    *((4.35, 7.7), (6.6, 8.2), (5.2, 7.3), (5.2, 5.2), (7.6, 4.7), (7.7, 5.55), (8.7, 5.6)),
    *((8.7, 8.2), (8.5, 6.8), (8.7, 5.6), (7.7, 5.55), (7.6, 4.7), (7.6, 3.6), (9.0, 3.5)),
)
"""Through all rooms, in the arena's frame [m]: office, bedroom, store, living room, kitchen, hall,
workshop."""


def update_times(reports: list[Report]) -> list[float]:
    """What each scan of a tour costs, from the readings on [ms]."""
    arena = load_arena("yellow")
    grid, scans, pose = (
        OccupancyGrid(RESOLUTION, SIZE, BEAMS),
        ScanSelector(BEAMS),
        true_pose(arena.start),
    )
    reader = ScanReader(magellan_body())
    times = []
    for item in reports:
        reader.moved(state_of(item, pose(item)), item.time)
        start = time.perf_counter()
        scan = item.ranges and reader.read(item.ranges, item.time)
        evidence = scan and scans.evidence(scan)
        if scan is not None and evidence is not None:
            grid.add(scan.pose, evidence)
            times.append((time.perf_counter() - start) * 1e3)
    return times


def laser_scan() -> None:
    """What a scan of 360 laser beams costs, at places of the tour."""
    arena = load_arena("yellow")
    group = RangeGroup(
        name="laser", kind=RangeKind.LASER, beams=360, step=math.tau / 360, farthest=12.0
    )
    beams = beams_of(RobotBody(name="laser", kind="laser", radius=0.2, ranges=(group,)))
    along = np.stack((np.cos(beams.bearing), np.sin(beams.bearing)), axis=1)
    grid = OccupancyGrid(RESOLUTION, SIZE, beams)
    scans = []
    for place in TOUR:
        away, _, _ = first_hits(arena.footprints, np.tile(place, (360, 1)), along)
        scans.append((Pose(x=place[0], y=place[1]), away.astype(np.float32)))
    value = median_ms(lambda number: grid.add(*scans[number % len(scans)]), 10 * len(scans))
    mean = statistics.mean(float(away.mean()) for _, away in scans)
    note = f"360 beams of {mean:.1f} m in the mean, 5 cm cells"
    report("mapping.laser_scan_ms", value, "ms", bar=0.5, note=note)


def main() -> None:
    laser_scan()
    arena = load_arena("yellow")
    sources: dict[str, tuple[str, Callable[[OccupancyGrid], Callable[[Report], Pose]]]] = {
        "map.f1": ("true poses", lambda _: true_pose(arena.start)),
        "map.f1_odometry": (
            "dead reckoning only, off by up to 1.9 m",
            lambda _: PoseSource(arena.start, math.inf),
        ),
        "map.f1_matched": (
            "dead reckoning, corrected by the map itself every 1.5 s",
            MatchedPose,
        ),
        "map.f1_landmarks": (
            f"dead reckoning, put right every {CORRECTION_PERIOD:g} s",
            lambda _: PoseSource(arena.start, CORRECTION_PERIOD),
        ),
    }
    scores: dict[str, list] = {name: [] for name in sources}
    for seed in SEEDS:
        robot = SimulatedMagellan(arena, seed=seed)
        reports = list(tour(robot, TOUR))
        truth = robot.ground_truth()
        say(f"seed {seed}: {reports[-1].time:.0f} s, {truth.contacts} contacts")
        if seed == SEEDS[0]:
            times = update_times(reports)
            note = (
                f"median of {len(times)} scans of 16 sonars and 16 infrared sensors, 5 cm cells;"
                f" 99 %: {sorted(times)[len(times) * 99 // 100]:.2f} ms"
            )
            report("map.update_ms", statistics.median(times), "ms", bar=3.0, note=note)
        surfaces = surfaces_in_sight(reports, arena)
        for name, (_, source) in sources.items():
            grid = OccupancyGrid(RESOLUTION, SIZE, BEAMS)
            mapped(reports, source(grid), grid)
            scores[name].append(score(grid, arena, surfaces))
    for name, (poses, _) in sources.items():
        precision = statistics.mean(item.precision for item in scores[name])
        recall = statistics.mean(item.recall for item in scores[name])
        note = (
            f"{poses}; mean of {len(SEEDS)} tours of {reports[-1].time:.0f} s, within 10 cm:"
            f" precision {precision:.2f}, recall {recall:.2f} of all surfaces in line of sight"
            " within 3 m, also those that sonar cannot see because it meets them at a slant"
        )
        f1 = statistics.mean(item.f1 for item in scores[name])
        report(name, f1, "", better="higher", note=note)


if __name__ == "__main__":
    main()
