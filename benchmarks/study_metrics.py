"""What the metrics of a trial of 10 minutes cost: two robots, states 20 times a second, a map."""

from __future__ import annotations

import math
import time

import numpy as np

from benchmarks.figures import median_ms, report
from rune_study.metrics.awareness import AnswerKind, Query
from rune_study.metrics.coverage import TrueGrid, reachable, seen_cells
from rune_study.metrics.effectiveness import signal
from rune_study.metrics.latency import motion_to_photon
from rune_study.metrics.map_quality import middles, surface
from rune_study.metrics.questionnaires import TLX_SCALES
from rune_study.metrics.registry import METRICS, measure
from rune_study.metrics.shortest_path import shortest_path
from rune_study.metrics.trial import (
    Contacts,
    Motion,
    Questionnaires,
    RobotData,
    Travel,
    TrialData,
)
from rune_study.metrics.victims import Mark

SECONDS, RATE_HZ = 600.0, 20.0
EDGE, RESOLUTION = 300, 0.05
FIELD_OF_VIEW = math.radians(60.0)


def arena() -> TrueGrid:
    """Ground of 15 m by 15 m with 40 boxes, the same in every run."""
    random = np.random.default_rng(2005)
    blocked = np.zeros((EDGE, EDGE), np.bool_)
    blocked[[0, -1]] = blocked[:, [0, -1]] = True
    for row, column in random.integers(30, EDGE - 40, (40, 2)):
        blocked[row : row + random.integers(4, 20), column : column + random.integers(4, 20)] = True
    return TrueGrid(blocked=blocked, resolution=RESOLUTION)


def robot(name: str, shortest: float, seed: int) -> RobotData:
    """A robot that is driven at random, and stands now and then."""
    random = np.random.default_rng(seed)
    times = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)
    works = np.repeat(random.random(60) < 0.7, len(times) // 60)
    turns = np.cumsum(random.normal(0.0, 0.1, len(times)))
    x = np.clip(7.5 + np.cumsum(works * np.cos(turns)) * 0.015, 0.5, 14.5)
    y = np.clip(7.5 + np.cumsum(works * np.sin(turns)) * 0.015, 0.5, 14.5)
    stick = np.clip(np.cumsum(random.normal(0.0, 0.05, len(times))), -1.0, 1.0)
    pan = np.cumsum(random.normal(0.0, 0.02, len(times)))
    return RobotData(
        name=name,
        inputs=np.sort(random.uniform(0.0, SECONDS, 600)),
        selections=np.sort(random.uniform(0.0, SECONDS, 60)),
        progress=signal(times, np.cumsum(works * 0.015)),
        travel=Travel(x=x, y=y, shortest=shortest, arrived=True),
        motion=Motion(times=times, linear=works * 0.3, angular=np.diff(turns, append=0.0), pan=pan),
        contacts=Contacts(
            times=times,
            counts=np.cumsum(random.random(len(times)) < 0.01).astype(float),
            bumpers=1 << random.integers(0, 16, len(times)),
            linear=works * 0.3,
        ),
        wheel=signal(times, 90.0 * stick),
        stick=signal(times, stick),
        keys=signal(times, np.round(stick)),
    )


def trial() -> TrialData:
    """A trial with all data; making it is a part of the cost."""
    grid = arena()
    random = np.random.default_rng(7)
    shortest = shortest_path(grid, (0.5, 0.5), (14.5, 14.5), 0.2)
    robots = tuple(robot(name, shortest, seed) for seed, name in enumerate(("rover", "second")))
    within = reachable(grid, (0.5, 0.5), 0.2)
    poses = [each.travel for each in robots if each.travel]
    views = [
        seen_cells(
            grid, each.x[::10], each.y[::10], np.zeros(each.x[::10].size), width=FIELD_OF_VIEW
        )
        for each in poses
    ]
    walls = middles(surface(grid, reachable(grid, (0.5, 0.5), 0.0)), RESOLUTION, 0.0, 0.0)
    inputs = np.sort(random.uniform(0.0, SECONDS, 600))
    captured = np.arange(0.0, SECONDS, 1.0 / 30.0)
    query = Query(level=1, kind=AnswerKind.NUMBER, answer=3, truth=3)
    return TrialData(
        length=SECONDS,
        robots=robots,
        marks=tuple(Mark(time=60.0 * k, x=random.uniform(0, 15), y=7.0) for k in range(10)),
        victims=random.uniform(0.0, 15.0, (12, 2)),
        seen=np.logical_or.reduce(views),
        reachable=within,
        marked=walls + random.normal(0.0, 0.05, walls.shape),
        surface=walls,
        photons=motion_to_photon(inputs, inputs + 0.1, captured, captured + 0.08),
        queries=(query,) * 12,
        questionnaires=Questionnaires(tlx=dict.fromkeys(TLX_SCALES, 50), sus=(3,) * 10),
    )


def main() -> None:
    value = median_ms(lambda _: measure(trial()), 5, warmup=1, clock=time.process_time) / 1e3
    known = sum(each.known for each in measure(trial()).values())
    note = (
        f"CPU, median; {known} of {len(METRICS)} metrics, two robots, shortest paths and views too"
    )
    report("study.metrics_10min_cpu_s", value, "s", bar=2.0, note=note)


if __name__ == "__main__":
    main()
