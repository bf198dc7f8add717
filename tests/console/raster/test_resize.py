"""Pictures in other sizes keep their aspect and their brightness."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rune_tui.raster.resize import fitted, fitted_size, resized

sizes = st.integers(1, 200)


@example(1, 2, 1, 1)
@example(2, 1, 1, 1)
@given(sizes, sizes, sizes, sizes)
def test_the_fitted_size_fills_the_room_one_way_and_keeps_the_aspect(
    width: int, height: int, room_width: int, room_height: int
) -> None:
    fit_width, fit_height = fitted_size(width, height, room_width, room_height)
    assert 1 <= fit_width <= room_width
    assert 1 <= fit_height <= room_height
    # One side fills the room; the other is the exact one rounded, or the one pixel that must be.
    exact_width = max(1.0, width * room_height / height)
    exact_height = max(1.0, height * room_width / width)
    fills_width = fit_width == room_width and abs(fit_height - exact_height) <= 0.5
    fills_height = fit_height == room_height and abs(fit_width - exact_width) <= 0.5
    assert fills_width or fills_height


@given(
    st.integers(0, 2**32 - 1),
    st.tuples(st.integers(1, 40), st.integers(1, 40)),
    st.tuples(st.integers(1, 40), st.integers(1, 40)),
    st.sampled_from([(), (3,)]),
)
def test_any_size_becomes_any_other_in_grey_and_in_colour(
    seed: int, size: tuple[int, int], wanted: tuple[int, int], channels: tuple[int, ...]
) -> None:
    shape = (*size, *channels)
    pixels = np.random.default_rng(seed).integers(0, 256, shape, np.uint8)
    result = resized(pixels, wanted[1], wanted[0])
    assert result.shape == (*wanted, *shape[2:])
    assert result.dtype == np.uint8
    assert pixels.min() <= result.min()
    assert result.max() <= pixels.max()


@pytest.mark.parametrize("size", [(80, 60), (53, 41), (160, 60), (7, 120)])
def test_shrinking_averages_areas_and_keeps_the_mean(size: tuple[int, int]) -> None:
    pixels = np.random.default_rng(3).integers(0, 256, (120, 160, 3), np.uint8)
    result = resized(pixels, *size)
    assert np.abs(result.mean(axis=(0, 1)) - pixels.mean(axis=(0, 1))).max() < 1.0


def test_halving_is_the_exact_mean_of_four() -> None:
    pixels = np.array([[0, 100], [200, 40]], np.uint8)
    assert resized(pixels, 1, 1).tolist() == [[85]]


def test_growing_keeps_the_mean() -> None:
    pixels = np.random.default_rng(4).integers(0, 256, (12, 16, 3), np.uint8)
    assert abs(resized(pixels, 64, 48).mean() - pixels.mean()) < 3.0


def test_a_picture_stands_in_the_middle_of_its_room() -> None:
    pixels = np.full((30, 40, 3), 77, np.uint8)
    picture, x, y = fitted(pixels, 100, 60)
    assert picture.shape == (60, 80, 3)
    assert (x, y) == (10, 0)
    picture, x, y = fitted(pixels, 20, 60)
    assert picture.shape == (15, 20, 3)
    assert (x, y) == (0, 22)


def test_a_grey_picture_comes_out_in_three_equal_channels() -> None:
    pixels = np.arange(12, dtype=np.uint8).reshape(3, 4)
    picture, _, _ = fitted(pixels, 4, 3)
    assert (picture == pixels[..., None]).all()
