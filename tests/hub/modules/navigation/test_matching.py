"""Laid onto the map, what is seen tells how far dead reckoning has drifted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.grids.grid import Grid
from hub.modules.navigation.matching import FEWEST, Sightings, drift
from hub.plane import Pose

CORNER_X = np.concatenate((np.linspace(-1.0, 1.0, 80), np.full(60, 1.0)))
CORNER_Y = np.concatenate((np.full(80, 1.0), np.linspace(-0.5, 1.0, 60)))
"""Points on two walls that meet."""


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
    found = drift(walls(), *turned.outward(CORNER_X - 0.2, CORNER_Y - 0.1), thought)
    assert found is not None
    assert math.hypot(found.x + x, found.y + y) < 0.07
    assert abs(found.theta + turn) < math.radians(3.0)


def test_where_nothing_has_drifted_nothing_is_moved() -> None:
    found = drift(walls(), CORNER_X, CORNER_Y, Pose())
    assert found is not None
    assert math.hypot(found.x, found.y) < 0.04
    assert abs(found.theta) < math.radians(1.0)


def test_too_few_points_tell_nothing() -> None:
    assert drift(walls(), CORNER_X[: FEWEST - 1], CORNER_Y[: FEWEST - 1], Pose()) is None


def test_points_that_fit_nowhere_tell_nothing() -> None:
    rough = 0.2 * np.sin(np.arange(len(CORNER_X)) * 2.3)
    assert drift(walls(), CORNER_X + rough, CORNER_Y + rough[::-1], Pose()) is None


@pytest.mark.parametrize("far", [1e3, 1e12])
def test_points_outside_of_the_map_tell_nothing(far: float) -> None:
    assert drift(walls(), CORNER_X + far, CORNER_Y - far, Pose()) is None


def test_sightings_are_points_in_odom_of_what_is_new() -> None:
    sightings = Sightings()
    sonar, infrared = np.full(16, np.inf, np.float32), np.full(16, np.inf, np.float32)
    sonar[0], sonar[4], infrared[8], infrared[2] = 1.0, 3.0, 0.5, 0.3
    for _ in range(2):
        sightings.scanned(Pose(x=1.0, theta=math.pi / 2.0), sonar, infrared, 0.31)
    x, y = sightings.taken()
    assert x == pytest.approx([1.0, 1.0])
    assert y == pytest.approx([1.0, -0.5])
    assert sightings.taken()[0].size == 0
