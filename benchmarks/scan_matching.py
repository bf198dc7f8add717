"""Laser scans laid onto those before: the error of the pose, and what a scan costs.

With small_gicp as a peer, where it is installed (`pip install small_gicp`).
"""

from __future__ import annotations

import dataclasses
import importlib.util
import math
import statistics
import time
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from benchmarks import barn
from benchmarks.figures import report, say
from benchmarks.mapping import RESOLUTION, SEEDS, SIZE, TOUR
from hub.gcm.beams import beams_of
from hub.gcm.body import BodyFrame, RangeGroup, RangeKind
from hub.grids.planner import plan
from hub.grids.scan_matching import ScanMatcher, surfaces
from hub.modules.mapping.grid import OccupancyGrid
from hub.pose import Pose
from hub.sim.arena import Arena, Footprints, load_arena
from tests.hub.modules.mapping.touring import (
    MatchedPose,
    Report,
    from_start,
    mapped,
    score,
    surfaces_in_sight,
    tour,
)
from tests.support.magellan import SimulatedMagellan, magellan_body

Floats = npt.NDArray[np.float64]
Matched = Callable[[Pose, Floats, Floats], Pose]
"""From the pose by dead reckoning and the points of a scan to the pose."""

LASER = RangeGroup(
    name="laser",
    kind=RangeKind.LASER,
    beams=360,
    first=-math.pi,
    step=math.tau / 360,
    nearest=0.1,
    farthest=8.0,
)
BODY = dataclasses.replace(
    magellan_body(), ranges=(LASER,), frames=(BodyFrame(name="laser", z=0.3),)
)
BEAMS = beams_of(BODY)
WORLDS = 10
LONGEST_S = 120.0


def ours() -> Matched:
    matcher, pose, last = ScanMatcher(), Pose(), Pose()

    def matched(odom: Pose, x: Floats, y: Floats) -> Pose:
        nonlocal pose, last
        pose, last = pose.then(odom.seen_from(last)), odom
        pose = pose.then(matcher.matched(odom, surfaces(x, y, LASER.step)) or Pose())
        return pose

    return matched


def gicp() -> Matched:
    from benchmarks.peers.gicp import GicpMatcher

    return GicpMatcher().pose


def measured(drive: Sequence[Report], start: Pose, matched: Matched) -> tuple[list, list]:
    """The error of each pose [m], and what each scan cost [ms]."""
    errors, times = [], []
    for item in drive:
        if item.ranges is None:
            continue
        ranges = item.ranges.scans[0].ranges.astype(np.float64)
        ranges[np.isinf(ranges)] = np.nan
        x, y = BEAMS.hits(np.arange(360), ranges)
        odom = Pose(x=item.drive.x, y=item.drive.y, theta=item.drive.theta)
        begun = time.perf_counter()
        pose = matched(odom, x, y)
        times.append((time.perf_counter() - begun) * 1e3)
        true = from_start(item.truth, start)
        errors.append(math.dist((pose.x, pose.y), (true.x, true.y)))
    return errors, times


def among_posts() -> list[tuple[list[Report], Pose]]:
    """Drives along planned ways through worlds of BARN, and their starts."""
    drives = []
    for world in barn.load()[0][:WORLDS]:
        count = len(world.cylinders)
        posts = Footprints(
            low=np.empty((0, 2)),
            high=np.empty((0, 2)),
            centre=world.cylinders,
            radius=np.full(count, world.radius),
            brightness=np.full(count, 0.6),
            origin=("",) * count,
        )
        arena = dataclasses.replace(load_arena("empty"), start=world.start, footprints=posts)
        start = (world.start.x, world.start.y)
        way = plan(barn.grid_of(world), start, world.goal, radius=0.28)
        reports = []
        for item in tour(
            SimulatedMagellan(arena, body=BODY, seed=1), [tuple(each) for each in way][1:]
        ):
            if item.time > LONGEST_S:
                break
            reports.append(item)
        drives.append((reports, arena.start))
    return drives


def compare(name: str, drives: list[tuple[list[Report], Pose]], note: str) -> None:
    """The figures of Rune, with dead reckoning and small_gicp beside it."""
    contenders = {"ours": ours, "dead reckoning": lambda: lambda odom, _x, _y: odom}
    if importlib.util.find_spec("small_gicp"):
        contenders["small_gicp"] = gicp
    off, cost = {}, {}
    for who, make in contenders.items():
        errors, times = [], []
        for drive, start in drives:
            of_drive, of_scans = measured(drive, start, make())
            errors.append(statistics.mean(of_drive))
            times += of_scans
        off[who], cost[who] = statistics.mean(errors), statistics.median(times)
        say(f"{name}, {who}: {', '.join(f'{error:.3f}' for error in errors)} m")
    peers = {who: round(value, 4) for who, value in off.items() if who != "ours"}
    report(f"scan_matching.{name}_error_m", off["ours"], "m", bar=0.05, peers=peers, note=note)
    peers = {who: round(value, 3) for who, value in cost.items() if who == "small_gicp"}
    note = "median of all scans of 360 beams, with the keeping of scans"
    report(f"scan_matching.{name}_ms", cost["ours"], "ms", bar=2.0, peers=peers, note=note)


def map_of(drive: list[Report], arena: Arena) -> float:
    """How true the map is that a laser makes on a tour, with the poses of navigation."""
    grid = OccupancyGrid(RESOLUTION, SIZE, BEAMS)
    mapped(drive, MatchedPose(grid, BODY), grid, BODY)
    return score(grid, arena, surfaces_in_sight(drive, arena, reach=LASER.farthest)).f1


def main() -> None:
    arena = load_arena("yellow")
    drives = [
        (list(tour(SimulatedMagellan(arena, body=BODY, seed=seed), TOUR)), arena.start)
        for seed in SEEDS
    ]
    note = f"mean over time and {len(SEEDS)} tours of 237 s through the yellow arena"
    compare("yellow", drives, note)
    compare("posts", among_posts(), f"mean over time and {WORLDS} worlds of BARN")
    f1 = statistics.mean(map_of(drive, arena) for drive, _ in drives)
    note = "the map of a 360-beam laser on the same tours, poses by its scans, within 10 cm"
    report("map.f1_laser", f1, "", bar=0.9, better="higher", note=note)


if __name__ == "__main__":
    main()
