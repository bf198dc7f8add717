"""Pictures in other sizes keep their aspect and their brightness."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from rune_tui.raster.resize import covering_size, fitted_size, resized
from tests.support.cases import for_each

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


@for_each("size", [(80, 60), (53, 41), (160, 60), (7, 120)])
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


@given(sizes, sizes, sizes, sizes)
def test_the_covering_size_fills_the_room_both_ways_and_keeps_the_aspect(
    width: int, height: int, room_width: int, room_height: int
) -> None:
    wide, high = covering_size(width, height, room_width, room_height)
    assert wide >= room_width
    assert high >= room_height
    fills_width = wide == room_width and abs(high - room_width * height / width) <= 0.5
    fills_height = high == room_height and abs(wide - room_height * width / height) <= 0.5
    assert fills_width or fills_height


def test_what_shrinks_one_way_and_grows_the_other_is_averaged_and_smooth() -> None:
    pixels = np.zeros((2, 8), np.uint8)
    pixels[:, ::2] = 200
    pixels[1] //= 2
    result = resized(pixels, 4, 8)
    assert (result == result[:, :1]).all()
    column = result[:, 0].astype(int)
    assert (column[0], column[-1]) == (100, 50)
    assert (np.diff(column) <= 0).all()
    assert (resized(pixels.T.copy(), 8, 4) == result.T).all()


@for_each("size", [(20, 15), (80, 60), (40, 15), (20, 60), (7, 99)])
def test_a_part_looks_as_if_it_were_cut_out(size: tuple[int, int]) -> None:
    pixels = np.random.default_rng(5).integers(0, 256, (60, 80, 3), np.uint8)
    part = resized(pixels, *size, (20.0, 15.0, 60.0, 45.0))
    cut = resized(pixels[15:45, 20:60].copy(), *size)
    # At their edges, smooth pictures know their neighbours or not.
    inner = slice(4, -4)
    assert part.shape == cut.shape
    assert np.abs(part[inner, inner].astype(int) - cut[inner, inner]).max(initial=0) <= 1
