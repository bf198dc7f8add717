"""Edges on the range view and on the map."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.gcm.edges import EDGES, Edges
from hub.gcm.geometry import Point3D
from hub.gcm.standard import Header
from rune_tui.model.edges import KNOWN_S
from rune_tui.model.theme import DARK
from tests.console.visualizers.conftest import words

SIZE = (60, 60)


def knowing(made, *places: tuple[float, float], age: float = 0.2, **state):
    """A robot that knows edges at these places in `map` [m]."""
    cells = tuple(Point3D(x=x, y=y) for x, y in places)
    edges = Edges(header=Header(frame_id="map"), cell_width=0.05, cell_height=0.05, cells=cells)
    return made.robot(
        navigation=made.received(made.navigation(**state)),
        messages={EDGES.name: made.received(edges, age)},
    )


def dots(canvas) -> np.ndarray:
    """Columns and rows of the pixels in the alarm's colour."""
    return np.argwhere((canvas.pixels[..., :3] == DARK.alarm[:3]).all(axis=2))[:, ::-1]


@pytest.mark.parametrize("name", ["visualizeRangeData", "visualizeMapData"])
def test_an_edge_is_where_it_is_and_has_a_word(made, draw, name: str) -> None:
    # The robot looks north, and the ground ends 1 m ahead of it: up on both drawings.
    places = [(5.0 + x, 8.0) for x in np.linspace(-0.4, 0.4, 9)]
    robot = knowing(made, *places, x=5.0, y=7.0, theta=math.pi / 2)
    canvas = draw(name, robot, SIZE)
    column, row = dots(canvas).mean(axis=0)
    assert abs(column - SIZE[0] / 2) < 2.5
    assert row < SIZE[1] / 2 - 3
    assert any("EDGE" in line for line in words(canvas))


@pytest.mark.parametrize("name", ["visualizeRangeData", "visualizeMapData"])
def test_old_far_and_impossible_edges_are_not_shown(made, draw, name: str) -> None:
    for robot in (
        knowing(made, (1.0, 0.0), age=KNOWN_S + 0.5),
        knowing(made, (90.0, 0.0)),
        knowing(made, (math.nan, 1.0)),
        knowing(made),
    ):
        canvas = draw(name, robot, SIZE)
        assert not any("EDGE" in line for line in words(canvas))
