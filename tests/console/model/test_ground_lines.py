"""Lines on the ground are cut to what the camera sees of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.ground_lines import visible_lines
from tests.console.model.cameras import CAMERAS, geometry, numbers

POINTS = st.lists(st.tuples(numbers(-8.0, 8.0), numbers(-8.0, 8.0)), max_size=6)


def test_a_line_from_behind_the_camera_into_the_distance_ends_at_the_lower_edge() -> None:
    (piece,) = visible_lines(geometry(), [(-5.0, 0.0), (1000.0, 0.0)])
    assert piece[0] == pytest.approx([80.0, 120.0])
    assert piece[1] == pytest.approx([80.0, 60.0], abs=0.1)


def test_a_line_across_the_picture_is_cut_at_both_edges_and_one_beside_it_is_gone() -> None:
    view = geometry()
    (piece,) = visible_lines(view, [(3.0, 9.0), (3.0, -9.0)])
    assert piece[:, 0] == pytest.approx([0.0, 160.0])
    assert piece[0, 1] == pytest.approx(piece[1, 1])
    assert visible_lines(view, [(0.5, 9.0), (3.0, 9.0)]) == []
    assert visible_lines(view, [(-1.0, 1.0), (-3.0, 9.0)]) == []


def test_a_line_around_the_robot_keeps_what_is_ahead() -> None:
    """Its ends are behind the camera, on both sides: divided by the depth they would be ahead."""
    square = [(-2.0, 2.0), (2.0, 2.0), (2.0, -2.0), (-2.0, -2.0), (-2.0, 2.0)]
    (piece,) = visible_lines(geometry(), square)
    assert piece[:, 0] == pytest.approx([0.0, 160.0])


def test_a_bent_line_stays_in_one_piece_until_it_leaves_the_picture() -> None:
    view = geometry()
    inside = [(2.0, 0.2), (3.0, 0.0), (4.0, -0.3)]
    (whole,) = visible_lines(view, inside)
    assert whole == pytest.approx(view.pixels(inside).pixels)
    pieces = visible_lines(view, [*inside, (4.0, -30.0), (5.0, -30.0), (5.0, 0.0), (6.0, 0.0)])
    assert [len(piece) for piece in pieces] == [4, 3]


def test_a_row_of_nan_parts_two_lines() -> None:
    gap = (math.nan, math.nan)
    pieces = visible_lines(geometry(), [(2.0, 0.0), (3.0, 0.0), gap, (2.0, 0.5), (3.0, 0.5)])
    assert [len(piece) for piece in pieces] == [2, 2]


@pytest.mark.parametrize("points", [np.empty((0, 2)), [(2.0, 0.0)], [(2.0, 0.0), (2.0, 0.0)]])
def test_lines_without_length_are_harmless(points: object) -> None:
    assert len(visible_lines(geometry(), np.asarray(points))) <= 1


@given(state=CAMERAS, points=POINTS, margin=st.sampled_from([0.0, 4.0]))
def test_pieces_stay_within_the_picture_and_its_margin_and_on_their_lines(
    state: object, points: list[tuple[float, float]], margin: float
) -> None:
    view = PictureGeometry.of(state, 160, 120)  # type: ignore[arg-type]
    assert view is not None
    corners = np.asarray(points, float).reshape(-1, 2)
    for piece in visible_lines(view, corners, margin=margin):
        assert len(piece) >= 2
        assert (piece >= -margin - 1e-6).all()
        assert (piece <= np.array((160.0, 120.0)) + margin + 1e-6).all()
        ground = view.ground(piece).points
        assert _distance_to_lines(ground, corners).max() < 1e-5


@given(state=CAMERAS, points=POINTS)
def test_every_point_of_a_line_that_is_in_the_picture_is_on_a_piece(
    state: object, points: list[tuple[float, float]]
) -> None:
    view = PictureGeometry.of(state, 160, 120)  # type: ignore[arg-type]
    assert view is not None
    corners = np.asarray(points, float).reshape(-1, 2)
    if len(corners) < 2:
        return
    share = np.linspace(0.0, 1.0, 7)[:, None, None]
    dense = (corners[:-1] * (1.0 - share) + corners[1:] * share).reshape(-1, 2)
    seen = view.pixels(dense)
    well = seen.inside & (seen.pixels > 0.01).all(axis=1)
    well &= (seen.pixels < np.array((159.99, 119.99))).all(axis=1)
    pieces = visible_lines(view, corners)
    for pixel in seen.pixels[well]:
        assert min(_distance_to_lines(pixel[None], piece)[0] for piece in pieces) < 1e-3


def _distance_to_lines(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """From points, shape (p, 2), to the nearest segment between corners, shape (p,)."""
    start, step = corners[:-1], np.diff(corners, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-300)
    share = ((points[:, None] - start) * step).sum(axis=2) / length
    nearest = start + np.clip(share, 0.0, 1.0)[..., None] * step
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
