"""Composing equals doing it pixel by pixel."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.blend import Layer, compose, mix
from rune_tui.compositor.cells import Cells
from rune_tui.raster.canvas import Canvas
from tests.support.cases import for_each

COLUMNS, ROWS = 9, 5
BACKGROUND = (10, 20, 30)


def nearest_255th(total: int) -> int:
    return (2 * total + 255) // 510


def mixed(under: list[int], over: list[int], alpha: int) -> list[int]:
    return [nearest_255th(o * alpha + u * (255 - alpha)) for u, o in zip(under, over, strict=True)]


def halved(first: list[int], second: list[int]) -> list[int]:
    return [(a + b) // 2 for a, b in zip(first, second, strict=True)]


class Reference:
    """The same composition in plain loops over every pixel and cell of the view."""

    def __init__(self) -> None:
        self.pixels = [[list(BACKGROUND) for _ in range(COLUMNS)] for _ in range(2 * ROWS)]
        self.glyphs = [[0] * COLUMNS for _ in range(ROWS)]
        self.ink = [[[0, 0, 0] for _ in range(COLUMNS)] for _ in range(ROWS)]

    def lay(self, layer: Layer) -> None:
        for row in range(ROWS):
            for column in range(COLUMNS):
                self._veil(layer, row, column)
        for y in range(2 * ROWS):
            for x in range(COLUMNS):
                *colour, alpha = self._source(layer, x, y)
                self.pixels[y][x] = mixed(self.pixels[y][x], colour, alpha)
        for row in range(ROWS):
            for column in range(COLUMNS):
                self._write(layer, row, column)

    def _source(self, layer: Layer, x: int, y: int) -> list[int]:
        u, v = x - layer.x, y - layer.y
        if not (0 <= u < layer.canvas.width and 0 <= v < layer.canvas.height):
            return [0, 0, 0, 0]
        *colour, alpha = layer.canvas.pixels[v, u].tolist()
        return [*colour, nearest_255th(alpha * (255 - layer.transparency))]

    def _veil(self, layer: Layer, row: int, column: int) -> None:
        upper = self._source(layer, column, 2 * row)
        lower = self._source(layer, column, 2 * row + 1)
        alpha = min(upper[3], lower[3])
        if alpha >= 128:
            self.glyphs[row][column] = 0
        tint = halved(upper[:3], lower[:3])
        self.ink[row][column] = mixed(self.ink[row][column], tint, alpha)

    def _write(self, layer: Layer, row: int, column: int) -> None:
        u, v = column - layer.x, row - layer.y // 2
        if not (0 <= u < layer.canvas.width and 0 <= v < layer.canvas.rows):
            return
        glyph = int(layer.canvas.glyphs[v, u])
        *ink, alpha = layer.canvas.ink[v, u].tolist()
        alpha = nearest_255th(alpha * (255 - layer.transparency))
        if not glyph or not alpha or (alpha < 128 and self.glyphs[row][column]):
            return
        ground = halved(self.pixels[2 * row][column], self.pixels[2 * row + 1][column])
        self.glyphs[row][column] = glyph
        self.ink[row][column] = mixed(ground, ink, alpha)


def noise(width: int, height: int, seed: int) -> Canvas:
    """Random pixels, among them many of alpha 0 and 255, and some characters."""
    random = np.random.default_rng(seed)
    canvas = Canvas.blank(width, height)
    for colours in (canvas.pixels, canvas.ink):
        colours[...] = random.integers(0, 256, colours.shape, np.uint8)
        extreme = random.random(colours.shape[:2])
        colours[extreme < 0.3, 3] = 0
        colours[extreme > 0.6, 3] = 255
    canvas.glyphs[...] = random.integers(65, 91, canvas.glyphs.shape)
    canvas.glyphs[random.random(canvas.glyphs.shape) < 0.6] = 0
    return canvas


layers = st.builds(
    lambda width, height, seed, x, y, zpos, transparency: Layer(
        canvas=noise(width, height, seed), x=x, y=y, zpos=zpos, transparency=transparency
    ),
    st.integers(1, 12),
    st.integers(1, 13),
    st.integers(0, 10_000),
    st.integers(-12, 10),
    st.integers(-13, 11),
    st.integers(-2, 2),
    st.one_of(st.sampled_from([0, 0, 255, 128]), st.integers(0, 255)),
)


@given(st.lists(layers, max_size=4))
def test_composing_equals_the_reference_pixel_by_pixel(pile: list[Layer]) -> None:
    cells = compose(COLUMNS, ROWS, BACKGROUND, pile)
    reference = Reference()
    for layer in sorted(pile, key=lambda layer: layer.zpos):
        reference.lay(layer)
    assert cells.pixels[..., :3].tolist() == reference.pixels
    assert cells.glyphs.tolist() == reference.glyphs
    written = cells.glyphs > 0
    assert (cells.ink[written, :3] == np.array(reference.ink)[written]).all()


def plain(colour: tuple[int, int, int, int], **place: int) -> Layer:
    canvas = Canvas.blank(4, 4)
    canvas.fill(colour)
    return Layer(canvas=canvas, **{"x": 0, "y": 0, **place})


def corner(cells: Cells) -> tuple[int, ...]:
    return tuple(cells.pixels[0, 0, :3].tolist())


RED, GREEN = (255, 0, 0, 255), (0, 255, 0, 255)


def test_the_larger_zpos_is_in_front_whatever_the_order() -> None:
    pile = [plain(RED, zpos=2), plain(GREEN, zpos=1)]
    assert corner(compose(4, 2, (0, 0, 0), pile)) == RED[:3]
    assert corner(compose(4, 2, (0, 0, 0), reversed(pile))) == RED[:3]


def test_of_equal_zpos_the_later_one_is_in_front() -> None:
    assert corner(compose(4, 2, (0, 0, 0), [plain(RED), plain(GREEN)])) == GREEN[:3]


@pytest.mark.parametrize(
    ("transparency", "seen"), [(0, (255, 0, 0)), (255, (7, 8, 9)), (128, (131, 4, 5))]
)
def test_transparency_is_exact_at_both_ends(transparency: int, seen: tuple[int, ...]) -> None:
    pile = [plain(RED, transparency=transparency)]
    # round((255 * 127 + 7 * 128) / 255) and so on.
    assert corner(compose(4, 2, (7, 8, 9), pile)) == seen


def test_pixels_of_alpha_zero_show_what_is_behind() -> None:
    assert corner(compose(4, 2, (7, 8, 9), [plain((255, 255, 255, 0))])) == (7, 8, 9)


def test_the_unused_byte_of_every_pixel_is_zero() -> None:
    cells = compose(6, 3, (7, 8, 9), [plain(RED), plain((1, 2, 3, 99))])
    assert not cells.pixels[..., 3].any()


def text_layer(string: str, **place: int) -> Layer:
    canvas = Canvas.blank(4, 2)
    canvas.text(0, 0, string, (255, 255, 255, 255))
    return Layer(canvas=canvas, **{"x": 0, "y": 0, **place})


def test_an_opaque_layer_hides_the_text_behind_it() -> None:
    cells = compose(4, 2, (0, 0, 0), [text_layer("abcd"), plain(RED, zpos=1, x=2)])
    assert cells.glyphs[0].tolist() == [97, 98, 0, 0]


def test_text_behind_clear_pixels_stays() -> None:
    cells = compose(4, 2, (0, 0, 0), [text_layer("abcd"), plain((9, 9, 9, 0), zpos=1)])
    assert cells.glyphs[0].tolist() == [97, 98, 99, 100]
    assert (cells.ink[0, :, :3] == 255).all()


@pytest.mark.parametrize(("alpha", "seen"), [(127, True), (128, False)])
def test_text_is_hidden_once_it_is_covered_at_least_half(alpha: int, *, seen: bool) -> None:
    cells = compose(4, 2, (0, 0, 0), [text_layer("abcd"), plain((9, 9, 9, alpha), zpos=1)])
    assert cells.glyphs.any() == seen


def test_text_in_a_cell_of_which_only_one_pixel_is_covered_stays() -> None:
    cells = compose(4, 2, (0, 0, 0), [text_layer("abcd"), plain(RED, zpos=1, y=1)])
    assert cells.glyphs[0].tolist() == [97, 98, 99, 100]


@pytest.mark.parametrize(("alpha", "glyph"), [(127, 97), (128, 120)])
def test_faint_text_does_not_replace_text_behind_it(alpha: int, glyph: int) -> None:
    faint = Canvas.blank(4, 2)
    faint.text(0, 0, "x", (255, 255, 255, alpha))
    cells = compose(4, 2, (0, 0, 0), [text_layer("a"), Layer(canvas=faint, x=0, y=0, zpos=1)])
    assert cells.glyphs[0, 0] == glyph


@for_each("alpha", [0, 1, 127, 128, 254, 255])
def test_mixing_rounds_every_share_to_the_nearest(alpha: int) -> None:
    under, over = np.meshgrid(np.arange(256, dtype=np.uint8), np.arange(256, dtype=np.uint8))
    exact = (over.astype(int) * alpha + under.astype(int) * (255 - alpha)) / 255
    result = mix(under, over, np.full_like(under, alpha))
    assert (result == np.floor(exact + 0.5)).all()
