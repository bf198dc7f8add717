"""Quadrants show the two colours that come near to four pixels, and never less than halves do."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.looks import packed, unpacked
from rune_tui.compositor.quadrants import BLOCKS, quarters_of, split
from rune_tui.raster.placed_picture import PlacedPicture
from tests.support.cases import for_each

VISIBLE = 192.0
"""A gain that is larger must not be lost, as a sum of squares over a cell."""


def quarters(seed: int, colours: int, spread: int = 256) -> np.ndarray:
    """Pixels of a picture in three rows of four cells, of few colours within a spread of levels."""
    random = np.random.default_rng(seed)
    palette = random.integers(0, spread, (colours, 4)).astype(np.uint8)
    palette[:, 3] = 0
    return palette[random.integers(0, colours, (6, 8))]


def means(pixels: np.ndarray) -> np.ndarray:
    """Each two of them side by side as their mean."""
    return PlacedPicture.of(pixels[..., :3], 0, 0, (2, 1)).means


def shown(pixels: np.ndarray) -> np.ndarray:
    """What is seen of them, of the same shape."""
    return unpacked(quarters_of(*split(packed(means(pixels)), packed(pixels))))


def four(pixels: np.ndarray, row: int, column: int) -> np.ndarray:
    """Upper left, upper right, lower left, lower right of a cell, shape (4, 3)."""
    cell = pixels[2 * row : 2 * row + 2, 2 * column : 2 * column + 2, :3]
    return cell.reshape(4, 3).astype(float)


def in_two_colours(pixels: np.ndarray) -> np.ndarray:
    """The four pixels of a cell in the means of the brighter ones and of the others."""
    light = pixels @ (77, 150, 29)
    bright = light > light.mean()
    split = pixels.copy()
    for side in (bright, ~bright):
        if side.any():
            split[side] = pixels[side].mean(axis=0)
    return split


def off(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.square(first - second).sum())


@given(seed=st.integers(0, 1 << 30), colours=st.integers(1, 6), spread=st.sampled_from([30, 256]))
def test_each_cell_shows_what_comes_nearer_halves_or_two_colours_by_brightness(
    seed: int, colours: int, spread: int
) -> None:
    picture = quarters(seed, colours, spread)
    halves, seen = means(picture).repeat(2, axis=1), shown(picture)
    for row, column in np.ndindex(3, 4):
        pixels, drawn = four(picture, row, column), four(seen, row, column)
        plain, cut = four(halves, row, column), in_two_colours(pixels)
        exact = pixels.reshape(2, 2, 3).mean(axis=1).repeat(2, axis=0)
        gain = off(pixels, exact) - off(pixels, cut)
        if abs(gain - VISIBLE) > 1.0:
            wanted = cut if gain > VISIBLE else plain
            assert np.abs(drawn - wanted).max() <= 0.5 + 1e-3


@given(seed=st.integers(0, 1 << 30), colours=st.integers(1, 6))
def test_pixels_that_are_equal_in_pairs_stay_as_they_are(seed: int, colours: int) -> None:
    pixels = quarters(seed, colours)[:, ::2].repeat(2, axis=1)
    assert (shown(pixels) == pixels).all()


@for_each("shape", BLOCKS)
@for_each("colours", [(20, 200), (200, 20)])
def test_cells_of_two_colours_are_exact(shape: int, colours: tuple[int, int]) -> None:
    has = [bool(shape & quarter) for quarter in (8, 4, 2, 1)]
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[..., :3] = np.where(has, *colours).reshape(2, 2, 1)
    assert (shown(pixels) == pixels).all()
    _, shapes = split(packed(means(pixels)), packed(pixels))
    assert shapes.tolist() == [[shape]]


def test_the_noise_of_a_camera_makes_no_shapes() -> None:
    noise = np.random.default_rng(1).normal(100.0, 2.0, (40, 40, 4))
    pixels = noise.round().astype(np.uint8)
    pixels[..., 3] = 0
    assert (shown(pixels) == means(pixels).repeat(2, axis=1)).all()
