"""The map that a robot makes keeps its pose from drifting away."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import beams_of
from hub.gcm.body import BodyFrame, RangeGroup, RangeKind
from hub.grids.grid import Grid
from hub.modules.mapping.grid import OccupancyGrid
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.correction import PoseCorrection
from hub.modules.navigation.drift_watch import OLDEST_S, YOUNGEST_S, DriftWatch
from hub.modules.navigation.matching import drift
from hub.modules.navigation.pose_uncertainty import Spread
from hub.pose import Pose
from hub.sim.arena import load_arena
from tests.hub.modules.mapping.touring import (
    BEAMS,
    MatchedPose,
    PoseSource,
    Report,
    from_start,
    mapped,
    tour,
)
from tests.hub.modules.navigation.drives import ROBOT
from tests.support.cases import for_each
from tests.support.magellan import SimulatedMagellan
from tests.support.messages import drive_state

RULES = BeamRules(ROBOT.body, beams_of(ROBOT.body))
ROUND = ((5.2, 4.6), (2.7, 4.35), (2.7, 1.9), (1.9, 1.5), (5.2, 1.4), (5.2, 4.6))
"""In the yellow arena's office and hall [m]."""


@pytest.fixture(scope="module")
def reports() -> list[Report]:
    return list(tour(SimulatedMagellan(load_arena("yellow"), seed=2), ROUND))


def test_the_pose_drifts_much_less_than_dead_reckoning(reports: list[Report]) -> None:
    start = load_arena("yellow").start
    grid = OccupancyGrid(0.05, 24.0, BEAMS)
    source, dead = MatchedPose(grid), PoseSource(start, math.inf)
    errors: list[tuple[float, float]] = []

    def pose(report: Report) -> Pose:
        true, told, reckoned = from_start(report.truth, start), source(report), dead(report)
        errors.append(
            (
                math.hypot(told.x - true.x, told.y - true.y),
                math.hypot(reckoned.x - true.x, reckoned.y - true.y),
            )
        )
        return told

    mapped(reports, pose, grid)
    matched, reckoned = np.mean(errors, axis=0)
    assert reckoned > 0.4
    assert matched < 0.5 * reckoned


def _half(name: str) -> RangeGroup:
    return RangeGroup(
        name=name,
        kind=RangeKind.LASER,
        beams=180,
        first=-math.pi / 2,
        step=math.pi / 180,
        nearest=0.1,
        farthest=8.0,
    )


TWO_LASERS = dataclasses.replace(
    ROBOT.body,
    ranges=(_half("front"), _half("rear")),
    frames=(
        BodyFrame(name="front", x=0.1, z=0.3),
        BodyFrame(name="rear", x=-0.1, z=0.3, yaw=math.pi),
    ),
)


def test_laser_scans_show_the_pose_to_centimetres_without_a_map() -> None:
    arena = load_arena("yellow")
    source = MatchedPose(OccupancyGrid(0.05, 24.0), TWO_LASERS)
    dead, errors = PoseSource(arena.start, math.inf), []
    for report in tour(SimulatedMagellan(arena, body=TWO_LASERS, seed=2), ROUND):
        true = from_start(report.truth, arena.start)
        errors.append(
            [
                math.dist((pose.x, pose.y), (true.x, true.y))
                for pose in (source(report), dead(report))
            ]
        )
    laid, reckoned = np.max(errors, axis=0)
    assert reckoned > 0.5
    assert laid < 0.08


def _seen() -> BeamScan:
    """Walls all around at about 0.6 m, but shifted by 5 cm along x, seen from the origin."""
    ranges = 0.6 + 0.05 * np.cos(RULES.beams.bearing)
    return BeamScan(pose=Pose(), ranges=ranges, fresh=np.ones(len(ranges), dtype=np.bool_))


def _ring() -> Grid:
    x = (np.arange(60) + 0.5) * 0.05 - 1.5
    away = np.hypot(x, x[:, None])
    cells = np.where(np.abs(away - 0.6) < 0.04, 100, 0).astype(np.int8)
    return Grid(cells=cells, resolution=0.05, origin_x=-1.5, origin_y=-1.5)


def take(watch: DriftWatch, pose: Pose, now: float) -> None:
    """A driver reports a pose, and its sensors measure."""
    watch.moved(drive_state(x=pose.x, y=pose.y, theta=pose.theta), now)
    watch.scanned(dataclasses.replace(_seen(), pose=pose), now)


def shifted(*, wait: float) -> float:
    """By how much the pose is shifted when the second map comes so long after the first [m]."""
    correction = PoseCorrection()
    watch = DriftWatch(correction, RULES)
    watch.mapped(_ring(), Pose(), 0.0)
    for step in range(1, round(wait * 10.0) + 1):
        # It drove a little, so that its pose may be off.
        pose = Pose(x=0.05 * (step % 2))
        take(watch, pose, step / 10.0)
    watch.mapped(_ring(), pose, wait)
    return correction.odom.x


def test_what_was_seen_is_laid_onto_a_map_that_does_not_show_it_yet() -> None:
    assert shifted(wait=YOUNGEST_S + 0.1) == pytest.approx(-0.05, abs=0.035)
    assert shifted(wait=YOUNGEST_S - 0.1) == 0.0


def test_a_map_is_not_matched_while_laser_scans_show_the_pose() -> None:
    correction, rules = PoseCorrection(), BeamRules(TWO_LASERS, beams_of(TWO_LASERS))
    watch = DriftWatch(correction, rules)
    bearing = rules.beams.bearing
    ranges = 0.6 / np.maximum(np.abs(np.cos(bearing)), np.abs(np.sin(bearing)))
    scan = BeamScan(pose=Pose(), ranges=ranges, fresh=np.ones(len(ranges), dtype=np.bool_))
    watch.mapped(_ring(), Pose(), 0.0)
    for step in range(1, 20):
        watch.moved(drive_state(x=0.0, y=0.0, theta=0.0), step / 10.0)
        watch.scanned(scan, step / 10.0)
    watch.mapped(_ring(), Pose(), 2.0)
    assert abs(correction.odom.x) < 0.002


def test_an_old_map_is_not_used() -> None:
    assert shifted(wait=OLDEST_S + 0.1) == 0.0


NONSENSE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e15, 5e-324)


@for_each("wrong", NONSENSE)
@for_each("field", ["x", "y", "theta"])
def test_report_that_cannot_be_does_no_harm_and_is_forgotten(field: str, wrong: float) -> None:
    correction = PoseCorrection()
    watch = DriftWatch(correction, RULES)
    watch.mapped(_ring(), Pose(), 0.0)
    for step in range(1, 12):
        now, pose = step / 10.0, Pose(x=0.05 * (step % 2))
        take(watch, dataclasses.replace(pose, **{field: wrong}), now)
        take(watch, pose, now + 0.01)
    watch.mapped(_ring(), pose, YOUNGEST_S + 0.2)
    assert abs(correction.odom.x) < 0.2
    assert math.isfinite(correction.odom.theta)


@for_each("wrong", NONSENSE)
def test_points_and_poses_that_cannot_be_are_not_matched(wrong: float) -> None:
    grid, spread = _ring(), Spread(turn=0.05, way=0.05)
    bearings = np.linspace(0.0, 6.2, 60)
    x, y = 0.6 * np.cos(bearings), 0.6 * np.sin(bearings)
    good = drift(grid, x, y, Pose(), spread)
    assert good is not None
    with_nonsense = drift(grid, np.append(x, wrong), np.append(y, wrong), Pose(), spread)
    assert with_nonsense is not None
    assert math.isfinite(with_nonsense.moved.x)
    for odd in (Pose(x=wrong), Pose(theta=wrong)):
        match = drift(grid, x, y, odd, spread)
        assert match is None or math.isfinite(match.moved.x)
