"""Scans laid onto the scans before: where the robot really is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.grids.scan_matching import FEWEST, ScanMatcher, Surfaces, surfaces
from hub.pose import Pose
from hub.sim.arena import Arena
from hub.sim.plane_rays import first_hits
from tests.hub.sim.arenas import arena_of
from tests.support.cases import for_each

STEP = math.tau / 360
BEARINGS = np.arange(360) * STEP
ROOM = arena_of("""
name = "room"
[start]
at = [2.0, 1.5]
[hall]
[[wall]]
from = [0.0, 0.0]
to = [5.0, 0.0]
[[wall]]
from = [5.0, 0.0]
to = [5.0, 4.0]
[[wall]]
from = [0.0, 4.0]
to = [5.0, 4.0]
[[wall]]
from = [0.0, 0.0]
to = [0.0, 4.0]
[[box]]
at = [3.5, 2.5]
size = [0.8, 0.5, 1.0]
""")
CORRIDOR = arena_of("""
name = "corridor"
[start]
at = [20.0, 1.0]
[hall]
[[wall]]
from = [0.0, 0.0]
to = [40.0, 0.0]
[[wall]]
from = [0.0, 2.0]
to = [40.0, 2.0]
""")


def scan(arena: Arena, pose: Pose, *, seed: int = 0, noise: float = 0.01) -> Surfaces:
    """What a laser at a pose sees within 8 m; the arena's start is the origin."""
    place = arena.start.then(pose)
    rays = np.stack((np.cos(BEARINGS + place.theta), np.sin(BEARINGS + place.theta)), axis=1)
    away, _, _ = first_hits(arena.footprints, np.tile((place.x, place.y), (360, 1)), rays)
    away += np.random.default_rng(seed).normal(0.0, noise, 360)
    away[away > 8.0] = np.nan
    return surfaces(away * np.cos(BEARINGS), away * np.sin(BEARINGS), STEP)


OFF = st.floats(-0.08, 0.08)


@given(x=OFF, y=OFF, turn=st.floats(-0.1, 0.1), heading=st.floats(-3.0, 3.0))
def test_the_error_of_dead_reckoning_is_found(
    x: float, y: float, turn: float, heading: float
) -> None:
    matcher = ScanMatcher()
    begin = Pose(theta=heading)
    assert matcher.matched(begin, scan(ROOM, begin)) is None
    real = Pose(x=0.3, y=0.1, theta=heading + 0.2)
    reckoned = Pose(x=real.x + x, y=real.y + y, theta=real.theta + turn)
    error = matcher.matched(reckoned, scan(ROOM, real, seed=1))
    assert error is not None
    found = reckoned.then(error).seen_from(real)
    assert math.hypot(found.x, found.y) < 0.015
    assert abs(found.theta) < math.radians(0.5)
    assert matcher.sure
    assert matcher.share > 0.8


def test_errors_do_not_add_up_on_a_way_through_a_room() -> None:
    """Dead reckoning turns too far by a tenth and drives too far by a tenth."""
    matcher, odom, real, here = ScanMatcher(), Pose(), Pose(), Pose()
    for number in range(100):
        real = real.then(Pose(x=0.03, theta=0.05))
        moved = Pose(x=0.033, theta=0.055)
        odom, here = odom.then(moved), here.then(moved)
        error = matcher.matched(odom, scan(ROOM, real, seed=number))
        here = here.then(error or Pose())
    assert math.dist((odom.x, odom.y), (real.x, real.y)) > 0.2
    assert math.dist((here.x, here.y), (real.x, real.y)) < 0.05
    assert abs(here.seen_from(real).theta) < math.radians(1.0)


def test_along_a_corridor_dead_reckoning_decides() -> None:
    matcher = ScanMatcher()
    matcher.matched(Pose(), scan(CORRIDOR, Pose()))
    real = Pose(x=0.2, y=0.05)
    error = matcher.matched(Pose(x=0.25, y=0.0), scan(CORRIDOR, real, seed=1))
    assert error is not None
    assert error.y == pytest.approx(0.05, abs=0.01)
    assert abs(error.x) < 0.02
    assert not matcher.sure


@for_each(
    "there", [Pose(x=-1.5, y=1.8, theta=2.0), Pose(x=0.5, y=0.4), Pose(x=-0.3, y=0.6, theta=0.4)]
)
def test_a_robot_that_was_carried_away_is_not_matched_and_goes_on_from_there(there: Pose) -> None:
    matcher = ScanMatcher()
    matcher.matched(Pose(), scan(ROOM, Pose()))
    assert matcher.matched(Pose(), scan(ROOM, there)) is None
    error = matcher.matched(Pose(), scan(ROOM, there, seed=1))
    assert error is not None
    assert math.hypot(error.x, error.y) < 0.01


def test_too_few_points_are_not_matched() -> None:
    matcher = ScanMatcher()
    wall = np.linspace(-0.5, 0.5, FEWEST - 1)
    for _ in range(2):
        assert matcher.matched(Pose(), surfaces(np.ones(FEWEST - 1), wall, STEP)) is None


def test_a_surface_has_its_direction_and_ends_at_gaps_and_corners() -> None:
    seen = surfaces(np.r_[np.full(20, 2.0), np.full(20, 5.0)], np.linspace(-1.0, 1.0, 40), STEP)
    known = seen.across_x != 0.0
    assert np.flatnonzero(~known).tolist() == [0, 1, 18, 19, 20, 21, 38, 39]
    assert np.abs(seen.across_x[known]) == pytest.approx(1.0)
    corner = surfaces(np.r_[np.linspace(1.0, 2.0, 20), np.full(20, 2.0)],
                      np.r_[np.full(20, 1.0), np.linspace(0.95, 0.0, 20)], STEP)  # fmt: skip
    assert (corner.across_x[19], corner.across_y[19]) == (0.0, 0.0)
    assert abs(corner.across_y[5]) == abs(corner.across_x[30]) == pytest.approx(1.0)


@for_each("count", [0, 1, 4, 360])
def test_scans_of_nothing_do_no_harm(count: int) -> None:
    matcher = ScanMatcher()
    for value in (math.nan, math.inf, -math.inf, 1e300, 0.0, 0.0):
        seen = surfaces(np.full(count, value), np.full(count, value), STEP)
        assert matcher.matched(Pose(), seen) is None
    assert matcher.matched(Pose(), scan(ROOM, Pose())) is None
    assert matcher.matched(Pose(), scan(ROOM, Pose())) is not None
