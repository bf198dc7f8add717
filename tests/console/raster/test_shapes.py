"""Shapes land where their arguments say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing, toward

RED = (200, 0, 0, 255)
BLUE = (0, 0, 200, 100)


def test_a_rectangle_covers_exactly_its_pixels() -> None:
    canvas = Canvas.blank(6, 5)
    with drawing(canvas) as pen:
        pen.rectangle(1, 2, 4, 5, RED)
    expected = np.zeros((5, 6), bool)
    expected[2:5, 1:4] = True
    assert ((canvas.pixels[..., 3] > 0) == expected).all()
    assert (canvas.pixels[expected] == RED).all()


def test_an_empty_rectangle_draws_nothing() -> None:
    canvas = Canvas.blank(6, 5)
    with drawing(canvas) as pen:
        pen.rectangle(2, 2, 2, 4, RED)
        pen.rectangle(4, 2, 2, 4, RED)
    assert not canvas.pixels.any()


def test_shapes_outside_the_canvas_are_clipped() -> None:
    canvas = Canvas.blank(4, 4)
    with drawing(canvas) as pen:
        pen.rectangle(-9, -9, 20, 20, RED)
        pen.circle((-50.0, -50.0), 3.0, fill=BLUE)
    assert (canvas.pixels == RED).all()


@pytest.mark.parametrize(
    ("direction", "inside"),
    [(0.0, (20, 8)), (math.pi / 2, (8, 20)), (math.pi, (20, 32)), (-math.pi / 2, (32, 20))],
)
def test_pies_point_counter_clockwise_from_up(direction: float, inside: tuple[int, int]) -> None:
    canvas = Canvas.blank(40, 40)
    with drawing(canvas) as pen:
        pen.pie((20.0, 20.0), 18.0, direction, math.pi / 4, RED)
    x, y = inside
    assert tuple(canvas.pixels[y, x]) == RED
    assert canvas.pixels[39 - y, 39 - x, 3] == 0


def test_toward_goes_up_and_then_to_the_left() -> None:
    assert toward((10.0, 10.0), 4.0, 0.0) == pytest.approx((10.0, 6.0))
    assert toward((10.0, 10.0), 4.0, math.pi / 2) == pytest.approx((6.0, 10.0))


def test_smoothing_softens_edges_without_darkening_them() -> None:
    canvas = Canvas.blank(21, 21)
    with drawing(canvas, smoothing=4) as pen:
        pen.circle((10.5, 10.5), 8.0, fill=RED)
    alpha = canvas.pixels[..., 3]
    edge = (alpha > 60) & (alpha < 200)
    assert edge.any()
    assert (np.abs(canvas.pixels[edge, 0].astype(int) - 200) < 6).all()


def test_smoothing_leaves_what_was_there() -> None:
    canvas = Canvas.blank(4, 4)
    canvas.fill((10, 20, 30, 255))
    with drawing(canvas, smoothing=3):
        pass
    assert (canvas.pixels == (10, 20, 30, 255)).all()


def test_lines_polygons_and_arcs_leave_their_colour() -> None:
    canvas = Canvas.blank(30, 30)
    with drawing(canvas) as pen:
        pen.line([(0.0, 0.0), (9.0, 0.0)], RED)
        pen.polygon([(20.0, 20.0), (28.0, 20.0), (24.0, 28.0)], RED)
        pen.arc((10.0, 20.0), 8.0, 0.0, math.pi / 8, BLUE)
    assert tuple(canvas.pixels[0, 5]) == RED
    assert tuple(canvas.pixels[22, 24]) == RED
    assert tuple(canvas.pixels[12, 10]) == BLUE
    assert canvas.pixels[20, 10, 3] == 0
