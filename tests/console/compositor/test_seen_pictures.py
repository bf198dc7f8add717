"""Pictures are seen where nothing lies over them, whatever else is in the view."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.blend import Layer, compose
from rune_tui.compositor.looks import looks_of, unpacked
from rune_tui.compositor.quadrants import quarters_with
from rune_tui.compositor.seen_pictures import seen_pictures
from rune_tui.raster.canvas import Canvas

COLUMNS, ROWS = 9, 5
BACKGROUND = (1, 2, 3)


def camera(seed: int, width: int, height: int, *, scale: tuple[int, int] = (2, 1)) -> Canvas:
    """A canvas full of a picture with so many pixels across and down each of its own."""
    canvas = Canvas.blank(width, height, scale=scale)
    size = (scale[1] * height, scale[0] * width, 3)
    pixels = np.random.default_rng(seed).integers(0, 256, size, np.uint8)
    canvas.place_picture(pixels, 0, 0, (width, height))
    return canvas


@given(
    seed=st.integers(0, 1000),
    at=st.tuples(st.integers(-3, 9), st.integers(-3, 10)),
    scale=st.sampled_from([(2, 1), (3, 2), (8, 8)]),
    overs=st.lists(st.tuples(st.integers(-2, 9), st.integers(-2, 10), st.integers(0, 255))),
)
def test_a_picture_is_seen_in_the_cells_over_which_nothing_lies(
    seed: int,
    at: tuple[int, int],
    scale: tuple[int, int],
    overs: list[tuple[int, int, int]],
) -> None:
    canvas = camera(seed, 6, 6, scale=scale)
    layers = [Layer(canvas=canvas, x=at[0], y=at[1])]
    for x, y, alpha in overs:
        over = Canvas.blank(2, 1)
        over.fill((7, 200, 90, alpha))
        layers.append(Layer(canvas=over, x=x, y=y, zpos=1))
    word = Canvas.blank(2, 2)
    word.text(0, 0, "ab", (255, 255, 255, 255))
    layers.append(Layer(canvas=word, x=3, y=4, zpos=2))
    cells = compose(COLUMNS, ROWS, BACKGROUND, layers)
    found = seen_pictures(cells, layers)
    if not found:
        assert not -6 < at[0] < COLUMNS or not -6 < at[1] < 2 * ROWS
        return
    ((picture, seen),) = ((each.picture, each.seen) for each in found)
    across, down = scale
    rows, columns = picture.means.shape[:2]
    left, top = picture.x - at[0], picture.y - at[1]
    part = slice(down * top, down * (top + rows)), slice(across * left, across * (left + columns))
    assert (picture.pixels == canvas.pictures[0].pixels[part]).all()
    changed = (cells.pixels != compose(COLUMNS, ROWS, BACKGROUND, layers[:1]).pixels).any(axis=2)
    inside = np.zeros((2 * ROWS, COLUMNS), np.bool_)
    inside[picture.y : picture.y + rows, picture.x : picture.x + columns] = True
    free = ~(changed & inside)
    wanted = (inside[0::2] | inside[1::2]) & free[0::2] & free[1::2] & (cells.glyphs == 0)
    assert (seen == wanted).all()


@given(seed=st.integers(0, 1000), at=st.tuples(st.integers(-3, 9), st.integers(-3, 10)))
def test_a_cell_shows_pixels_of_the_picture_or_its_own(seed: int, at: tuple[int, int]) -> None:
    layers = [Layer(canvas=camera(seed, 6, 6), x=at[0], y=at[1])]
    cells = compose(COLUMNS, ROWS, BACKGROUND, layers)
    quarters = quarters_with(looks_of(cells).pixels, seen_pictures(cells, layers))
    wanted = cells.pixels.repeat(2, axis=1)
    pixels = layers[0].canvas.pictures[0].pixels
    for y, x in np.ndindex(2 * ROWS, 2 * COLUMNS):
        down, across = y - at[1], x - 2 * at[0]
        if 0 <= down < 6 and 0 <= across < 12:
            wanted[y, x] = pixels[down, across]
    assert (unpacked(quarters) == wanted).all()


def test_of_two_pictures_the_nearer_one_is_seen() -> None:
    layers = [
        Layer(canvas=camera(1, 4, 4), x=2, y=2, zpos=1),
        Layer(canvas=camera(2, COLUMNS, 2 * ROWS), x=0, y=0),
    ]
    cells = compose(COLUMNS, ROWS, BACKGROUND, layers)
    behind, before = seen_pictures(cells, layers)
    assert before.seen.sum() == 8
    assert (before.seen == ~behind.seen).all()


def test_a_picture_on_a_transparent_layer_is_not_seen() -> None:
    layers = [Layer(canvas=camera(1, COLUMNS, 2 * ROWS), x=0, y=0, transparency=100)]
    assert not seen_pictures(compose(COLUMNS, ROWS, BACKGROUND, layers), layers)


@pytest.mark.parametrize("tint", [(255, 0, 0), (255, 76, 52)])
def test_pictures_are_tinted_and_seen_where_they_were(tint: tuple[int, int, int]) -> None:
    layers = [Layer(canvas=camera(1, COLUMNS, 2 * ROWS), x=0, y=0)]
    cells = compose(COLUMNS, ROWS, BACKGROUND, layers)
    (plain,), (red,) = seen_pictures(cells, layers), seen_pictures(cells, layers, tint)
    exact = plain.picture.pixels[..., :3] * (np.array(tint) / 255.0)
    assert np.abs(red.picture.pixels[..., :3] - exact).max() < 0.51
    assert (red.seen == plain.seen).all()
