"""Shapes land where their arguments say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing, toward
from tests.support.cases import for_each

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


@for_each(
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


def test_dashes_cover_what_their_lengths_say() -> None:
    canvas = Canvas.blank(20, 3)
    with drawing(canvas, smoothing=4) as pen:
        pen.dashes([(0.0, 1.5), (20.0, 1.5)], RED, dash=3.0, gap=2.0)
    alpha = canvas.pixels[1, :, 3]
    shown = np.arange(20) % 5 < 3
    assert (alpha[shown] > 150).all()
    assert (alpha[~shown] < 100).all()


def test_dashes_go_on_around_a_corner() -> None:
    canvas = Canvas.blank(30, 30)
    with drawing(canvas) as pen:
        pen.dashes([(0.0, 5.0), (12.0, 5.0), (12.0, 29.0)], RED, dash=5.0, gap=5.0)
    red = canvas.pixels[..., 3] > 0
    assert red[5, 2]
    assert not red[5, 7]
    assert red[5, 11]
    assert red[7, 12]
    assert not red[10, 12]
    assert not red[12, 12]
    assert red[14, 12]


def test_dashes_from_far_outside_show_the_same_and_take_no_time() -> None:
    near, far = Canvas.blank(20, 20), Canvas.blank(20, 20)
    with drawing(near) as pen:
        pen.dashes([(-9.75, 4.0), (30.0, 4.0)], RED, dash=3.0, gap=2.0)
    with drawing(far) as pen:
        pen.dashes([(-999_999_999.75, 4.0), (1e9, 4.0)], RED, dash=3.0, gap=2.0)
        pen.dashes([(-1e9, 400.0), (1e9, 400.0)], RED, dash=3.0, gap=2.0)
    assert near.pixels.any()
    assert (near.pixels == far.pixels).all()


def test_dashes_without_length_draw_nothing() -> None:
    canvas = Canvas.blank(9, 9)
    with drawing(canvas) as pen:
        pen.dashes([(4.0, 4.0), (4.0, 4.0)], RED, dash=3.0, gap=2.0)
        pen.dashes([(4.0, 4.0)], RED, dash=3.0, gap=2.0)
    assert not canvas.pixels.any()


def test_a_cross_reaches_its_corners_and_leaves_its_sides() -> None:
    canvas = Canvas.blank(21, 21)
    with drawing(canvas) as pen:
        pen.cross((10.0, 10.0), 6.0, RED)
    red = canvas.pixels[..., 3] > 0
    assert red[[4, 4, 16, 16, 10], [4, 16, 4, 16, 10]].all()
    assert not red[[4, 16, 10, 10], [10, 10, 4, 16]].any()


def test_of_a_line_that_comes_from_far_away_only_what_is_seen_is_drawn() -> None:
    canvas = Canvas.blank(8, 6)
    with drawing(canvas) as pen:
        # All of its pixels would take Pillow for ever.
        pen.line([(-1e13, 2.5), (1e13, 2.5), (1e13, 9e13), (-5e12, 4.5), (9.0, 4.5)], RED)
    assert (canvas.pixels[2] == RED).all()
    assert (canvas.pixels[4] == RED).all()
    assert not canvas.pixels[[0, 1, 5]].any()


@pytest.mark.timeout(60)
@pytest.mark.parametrize("radius", [900.0, 1e6, 1e9, 1e12])
def test_circles_of_any_radius_take_no_time_and_show_the_part_that_is_seen(radius: float) -> None:
    canvas = Canvas.blank(20, 10)
    with drawing(canvas) as pen:
        pen.circle((10.0, 5.0), radius, fill=RED, rim=BLUE)
    assert (canvas.pixels == RED).all()
    with drawing(canvas) as pen:  # the rim comes through the middle
        pen.circle((10.0 + radius, 5.0), radius, fill=BLUE)
        pen.pie((10.0 + radius, 5.0), radius, 0.0, 1.0, BLUE)
        pen.arc((10.0 - radius, 5.0), radius, 0.0, 1.0, BLUE)
    if radius <= 1e6:
        assert (canvas.pixels[:, 18:] == BLUE).all()
        assert (canvas.pixels[4:6, :8] == RED).all()


@pytest.mark.parametrize("far", [1e9, 1e200, 1e308])
def test_a_line_to_a_place_that_no_screen_has_is_cut(far: float) -> None:
    canvas = Canvas.blank(8, 8)
    with drawing(canvas) as pen:
        pen.line([(4.0, 4.0), (far, 4.0)], RED)
        pen.line([(far, far), (far, -far)], RED)
        pen.dashes([(-far, 4.0), (4.0, 4.0)], RED, dash=1.0, gap=1.0)
    assert tuple(canvas.pixels[4, 6]) == RED
    assert not canvas.pixels[0].any()
