"""Laid onto the map, what is seen tells how far dead reckoning has drifted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import beams_of
from hub.grids.grid import Grid
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.matching import FEWEST, Sightings, drift
from hub.modules.navigation.pose_uncertainty import Spread
from hub.pose import Pose
from tests.hub.modules.navigation.drives import ROBOT

CORNER_X = np.concatenate((np.linspace(-1.0, 1.0, 80), np.full(60, 1.0)))
CORNER_Y = np.concatenate((np.full(80, 1.0), np.linspace(-0.5, 1.0, 60)))
"""Points on two walls that meet."""
FAR = Spread(turn=math.radians(4.0), way=0.1)
"""As after a drive with many turns."""


def walls(width: int = 80) -> Grid:
    cells = np.full((width, width), -1, np.int8)
    grid = Grid(cells=cells, resolution=0.05, origin_x=-2.0, origin_y=-2.0)
    for x, y in zip(CORNER_X.tolist(), CORNER_Y.tolist(), strict=True):
        cells[grid.cell(x, y)] = 100
    return grid


@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-3.0, 3.0))
def test_a_shift_and_a_turn_are_found(x: float, y: float, turn: float, heading: float) -> None:
    # The points as they seem to lie to a robot whose pose is off by this much.
    thought = Pose(x=0.2 + x, y=0.1 + y, theta=heading + turn)
    turned = Pose(x=thought.x, y=thought.y, theta=turn)
    found = drift(walls(), *turned.outward(CORNER_X - 0.2, CORNER_Y - 0.1), thought, FAR)
    assert found is not None
    assert math.hypot(found.moved.x + x, found.moved.y + y) < 0.07
    assert abs(found.moved.theta + turn) < math.radians(3.0)
    assert found.spread.turn < FAR.turn
    assert found.spread.way < FAR.way


def test_where_nothing_has_drifted_nothing_is_moved() -> None:
    found = drift(walls(), CORNER_X, CORNER_Y, Pose(), FAR)
    assert found is not None
    assert math.hypot(found.moved.x, found.moved.y) < 0.04
    assert abs(found.moved.theta) < math.radians(1.0)


def test_what_dead_reckoning_knows_well_is_not_turned_by_what_is_seen() -> None:
    turn = math.radians(4.0)
    cosine, sine = math.cos(turn), math.sin(turn)
    x, y = CORNER_X * cosine - CORNER_Y * sine, CORNER_X * sine + CORNER_Y * cosine
    sure = Spread(turn=math.radians(0.3), way=0.01)
    found, free = (drift(walls(), x, y, Pose(), spread) for spread in (sure, FAR))
    assert found is not None
    assert free is not None
    assert abs(free.moved.theta + turn) < math.radians(1.0)
    assert abs(found.moved.theta) < math.radians(1.0)


def test_a_single_wall_tells_nothing_of_the_way_along_it() -> None:
    grid = walls()
    grid.cells[:] = np.where(np.arange(80)[:, None] == grid.cell(0.0, 1.0)[0], 100, 0)
    found = drift(grid, np.linspace(-1.0, 1.0, 80), np.full(80, 1.08), Pose(), FAR)
    assert found is not None
    assert abs(found.moved.x) < 0.02
    assert found.moved.y == pytest.approx(-0.05, abs=0.03)


def test_too_few_points_tell_nothing() -> None:
    assert drift(walls(), CORNER_X[: FEWEST - 1], CORNER_Y[: FEWEST - 1], Pose(), FAR) is None


def test_points_that_fit_nowhere_hardly_move_anything() -> None:
    rough = 0.2 * np.sin(np.arange(len(CORNER_X)) * 2.3)
    found = drift(walls(), CORNER_X + rough, CORNER_Y + rough[::-1], Pose(), FAR)
    assert found is not None
    assert math.hypot(found.moved.x, found.moved.y) < 0.03
    assert found.spread.way > 0.8 * FAR.way
    assert found.spread.turn > 0.8 * FAR.turn


@pytest.mark.parametrize("far", [1e3, 1e12])
def test_points_outside_of_the_map_tell_nothing(far: float) -> None:
    assert drift(walls(), CORNER_X + far, CORNER_Y - far, Pose(), FAR) is None


def seen_from(pose: Pose, ranges: dict[str, dict[int, float]], *, fresh: bool = True) -> BeamScan:
    """A scan of a Magellan, with ranges [m] of some of its sensors."""
    beams = beams_of(ROBOT.body)
    measured = np.full(len(beams.kind), np.inf)
    for name, given_ranges in ranges.items():
        for number, value in given_ranges.items():
            measured[beams.groups[name]][number] = value
    return BeamScan(pose=pose, ranges=measured, fresh=np.full(len(measured), fresh))


RULES = BeamRules(ROBOT.body, beams_of(ROBOT.body))


def test_sightings_are_points_in_odom_of_new_ranges() -> None:
    sightings = Sightings(RULES)
    pose = Pose(x=1.0, theta=math.pi / 2.0)
    ranges = {"sonar": {0: 1.0, 4: 3.1}, "infrared": {8: 0.5, 2: 0.3}}
    sightings.scanned(seen_from(pose, ranges), 7.0)
    sightings.scanned(seen_from(pose, ranges, fresh=False), 7.1)
    x, y = sightings.since(6.9)
    assert x == pytest.approx([1.0, 1.0])
    assert y == pytest.approx([1.0, -0.5])
    assert sightings.since(7.0)[0].size == 0


def test_sightings_are_forgotten() -> None:
    sightings = Sightings(RULES)
    for now in (1.0, 2.0, 2.5 + Sightings.KEPT_S):
        sightings.scanned(seen_from(Pose(), {"sonar": dict.fromkeys(range(16), 1.0)}), now)
    assert len(sightings.since(0.0)[0]) == 16
