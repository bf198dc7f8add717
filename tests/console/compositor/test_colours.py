"""Cells in fewer colours: only colours that exist, the nearest of them, and text that is read."""

from __future__ import annotations

import numpy as np
import pyte.graphics
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from tests.console.compositor.frames import flat, frames, random_cells
from tests.support.cases import for_each

FEWER = [ColourDepth.INDEXED_256, ColourDepth.INDEXED_16, ColourDepth.MONO]
INDEXED = FEWER[:2]
XTERM = [tuple(bytes.fromhex(colour)) for colour in pyte.graphics.FG_BG_256]
VGA_GREYS = {0: (0, 0, 0), 7: (170, 170, 170), 8: (85, 85, 85), 15: (255, 255, 255)}


def brightness(colours: np.ndarray) -> np.ndarray:
    return colours[..., :3].astype(float) @ (0.299, 0.587, 0.114)


def as_counted(colours: np.ndarray) -> np.ndarray:
    """Brightness and chroma, chroma at four fifths."""
    bright = colours.astype(float) @ (77 / 256, 150 / 256, 29 / 256)
    red, blue = colours[..., 0] - bright, colours[..., 2] - bright
    return np.stack([bright, 0.8 * red, 0.8 * blue], axis=-1)


def letter(ink: tuple[int, ...], ground: tuple[int, ...]) -> Cells:
    cells = flat(1, 1, *ground)
    cells.glyphs[0, 0] = ord("A")
    cells.ink[0, 0, :3] = ink
    return cells


def test_truecolour_is_left_as_it_is() -> None:
    cells = random_cells(1, 5, 4, 3, 0.5)
    assert at_depth(cells, ColourDepth.TRUECOLOUR) is cells


@given(frames)
def test_256_colours_are_those_of_xterm_but_for_the_16_that_people_choose(cells: Cells) -> None:
    shown = at_depth(cells, ColourDepth.INDEXED_256)
    for *colour, number in shown.pixels.reshape(-1, 4).tolist():
        assert number >= 16
        assert tuple(colour) == XTERM[number]
    for *colour, number in shown.ink[shown.glyphs > 0].tolist():
        assert number >= 16
        assert tuple(colour) == XTERM[number]


@given(st.lists(st.tuples(*[st.integers(0, 31)] * 3), min_size=1, max_size=30))
def test_256_colours_are_the_nearest_ones(fives: list[tuple[int, int, int]]) -> None:
    wanted = np.array(fives) * 255 // 31
    cells = flat(len(fives), 1, 0)
    cells.pixels[..., :3] = wanted
    shown = at_depth(cells, ColourDepth.INDEXED_256).pixels[0, :, :3]
    palette = as_counted(np.array(XTERM[16:]))
    distances = ((as_counted(wanted)[:, None] - palette) ** 2).sum(axis=-1)
    best = np.sqrt(distances.min(axis=1))
    got = np.sqrt(((as_counted(wanted) - as_counted(shown)) ** 2).sum(axis=-1))
    assert (got <= best + 2.0).all()  # the whole part of a colour of five bits is up to 1 off


@for_each("depth", INDEXED)
@for_each("grey", [0, 255])
def test_black_stays_black_and_white_stays_white(depth: ColourDepth, grey: int) -> None:
    assert (at_depth(flat(8, 4, grey), depth).pixels[..., :3] == grey).all()


@for_each(("number", "colour"), VGA_GREYS.items())
def test_greys_of_the_16_stay_as_they_are(number: int, colour: tuple[int, int, int]) -> None:
    pixels = at_depth(flat(8, 4, *colour), ColourDepth.INDEXED_16).pixels
    assert np.unique(pixels.reshape(-1, 4), axis=0).tolist() == [[*colour, number]]


def test_a_grey_between_two_of_the_16_is_made_of_both() -> None:
    pixels = at_depth(flat(8, 4, 128), ColourDepth.INDEXED_16).pixels
    assert set(pixels[..., 3].flat) == {7, 8}


def test_a_brick_wall_is_no_grey_even_in_16_colours() -> None:
    pixels = at_depth(flat(8, 4, 106, 62, 52), ColourDepth.INDEXED_16).pixels
    assert set(pixels[..., 3].flat) <= {1, 3}  # red and brown


def test_a_dark_panel_has_no_grain() -> None:
    pixels = at_depth(flat(8, 4, 24, 28, 34), ColourDepth.INDEXED_16).pixels
    assert set(pixels[..., 3].flat) == {0}


@pytest.mark.parametrize("depth", FEWER)
@given(cells=frames)
def test_text_stays_and_has_one_colour_behind_it(depth: ColourDepth, cells: Cells) -> None:
    shown = at_depth(cells, depth)
    written = cells.glyphs > 0
    assert (shown.glyphs[written] == cells.glyphs[written]).all()
    assert (shown.pixels[0::2][written] == shown.pixels[1::2][written]).all()


@pytest.mark.parametrize("depth", FEWER)
@given(
    ink=st.tuples(*[st.integers(0, 255)] * 3),
    ground=st.tuples(*[st.integers(0, 255)] * 3),
)
def test_text_always_stands_out(
    depth: ColourDepth, ink: tuple[int, ...], ground: tuple[int, ...]
) -> None:
    shown = at_depth(letter(ink, ground), depth)
    assert abs(brightness(shown.ink[0, 0]) - brightness(shown.pixels[0, 0])) > 55.0


@for_each(
    ("ink", "ground", "turned"),
    [
        ((240, 240, 240), (24, 28, 34), False),
        ((20, 20, 20), (200, 200, 200), True),
        ((240, 240, 240), (200, 24, 24), True),  # an alarm
        ((255, 176, 0), (24, 28, 34), False),  # a warning among others
    ],
)
def test_without_colours_dark_text_and_alarms_are_the_other_way_round(
    ink: tuple[int, ...], ground: tuple[int, ...], *, turned: bool
) -> None:
    shown = at_depth(letter(ink, ground), ColourDepth.MONO)
    assert shown.pixels[0, 0, 3] == turned
    assert shown.ink[0, 0, 3] != turned


@for_each(
    ("upper", "lower", "wanted"),
    [
        (0, 0, (0, 0, "\0")),
        (255, 255, (1, 1, "\0")),
        (255, 0, (1, 0, "\0")),
        (20, 240, (0, 1, "\0")),
        (64, 64, (0, 0, "░")),
        (120, 140, (0, 0, "▒")),
        (190, 190, (0, 0, "▓")),
    ],
)
def test_without_colours_pixels_are_half_blocks_and_shades(
    upper: int, lower: int, wanted: tuple[int, int, str]
) -> None:
    cells = flat(1, 1, upper)
    cells.pixels[1, 0, :3] = lower
    shown = at_depth(cells, ColourDepth.MONO)
    glyph = chr(shown.glyphs[0, 0])
    assert (*shown.pixels[:, 0, 3].tolist(), glyph) == wanted
    assert shown.pixels[0, 0, 0] == 255 * wanted[0]
    if glyph != "\0":
        assert shown.ink[0, 0].tolist() == [255, 255, 255, 1]


def test_no_pattern_lies_between_words_on_a_ground_of_one_colour() -> None:
    cells = flat(40, 1, 38, 45, 54)
    cells.glyphs[0, [3, 4, 20]] = ord("A")
    cells.ink[0, :, :3] = 255
    reduced = at_depth(cells, ColourDepth.INDEXED_16)
    assert len(np.unique(reduced.pixels.reshape(-1, reduced.pixels.shape[-1]), axis=0)) == 1
