"""Pixels and characters of a canvas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wcwidth import wcwidth

from rune_tui.raster.canvas import Canvas, printable, printable_text
from tests.support.cases import for_each
from tests.support.repetitions import repetitions

WHITE = (255, 255, 255, 255)


def written(canvas: Canvas, row: int = 0) -> str:
    return "".join(chr(point) if point else " " for point in canvas.glyphs[row].tolist())


def test_a_blank_canvas_shows_what_is_behind() -> None:
    canvas = Canvas.blank(5, 3)
    assert (canvas.width, canvas.height, canvas.rows) == (5, 3, 2)
    assert not canvas.pixels.any()
    assert not canvas.glyphs.any()


@for_each(
    ("column", "shown"),
    [(0, "abcd"), (2, "  ab"), (-2, "cdef"), (4, "    "), (-6, "    "), (-5, "f   ")],
)
def test_text_is_clipped_at_both_edges(column: int, shown: str) -> None:
    canvas = Canvas.blank(4, 2)
    canvas.text(column, 0, "abcdef", WHITE)
    assert written(canvas) == shown


@pytest.mark.parametrize("row", [-1, 2, 100])
def test_text_in_a_row_outside_is_not_drawn(row: int) -> None:
    canvas = Canvas.blank(4, 4)
    canvas.text(0, row, "abcd", WHITE)
    assert not canvas.glyphs.any()


@given(st.text())
def test_every_character_takes_exactly_one_cell(string: str) -> None:
    for character in printable_text(string):
        assert wcwidth(character) == 1
        assert printable(character) == character


def test_no_character_of_unicode_takes_other_than_one_cell() -> None:
    points = (*range(0x3000), *range(0x3000, 0x110000, repetitions(61, 1)))
    odd = [hex(p) for p in points for shown in printable(chr(p)) if wcwidth(shown) != 1]
    assert odd == []


@for_each(
    ("raw", "shown"),
    [
        ("\x1b[2J", "?[2J"),
        ("a\nb\tc", "a?b?c"),
        ("\x9b31m", "?31m"),
        ("中文", "??"),
        ("e\u0301", "é"),
        ("x\u0301\u0302", "x"),
        ("a\u00a0b\u3000c", "a b c"),
        ("a\u202eb\u200b", "a?b?"),
        ("\ud800\U0010ffff", "??"),
        ("37° é", "37° é"),
    ],
)
def test_what_a_terminal_cannot_show_in_one_cell_is_replaced(raw: str, shown: str) -> None:
    assert printable_text(raw) == shown


def test_a_picture_pasted_partly_outside_is_clipped() -> None:
    canvas = Canvas.blank(3, 3)
    picture = np.arange(27, dtype=np.uint8).reshape(3, 3, 3) + 1
    canvas.paste(picture, -1, 2)
    assert (canvas.pixels[2, :2, :3] == picture[0, 1:]).all()
    assert (canvas.pixels[2, :2, 3] == 255).all()
    assert not canvas.pixels[:2].any()
    assert not canvas.pixels[2, 2].any()


def test_a_picture_pasted_across_the_upper_edge_shows_its_lower_part() -> None:
    canvas = Canvas.blank(3, 3)
    picture = np.arange(27, dtype=np.uint8).reshape(3, 3, 3) + 1
    canvas.paste(picture, 1, -2)
    assert (canvas.pixels[0, 1:, :3] == picture[2, :2]).all()
    assert not canvas.pixels[1:].any()


def test_a_picture_wholly_outside_changes_nothing() -> None:
    canvas = Canvas.blank(3, 3)
    picture = np.full((2, 2, 3), 9, np.uint8)
    for x, y in ((3, 0), (-2, 0), (0, 3), (0, -2)):
        canvas.paste(picture, x, y)
    assert not canvas.pixels.any()


def grey(*rows: list[int]) -> np.ndarray:
    """A picture of grey pixels, shape (h, w, 3)."""
    return np.array(rows, np.uint8)[..., None].repeat(3, axis=2)


def test_a_placed_picture_is_seen_as_its_means_and_keeps_its_pixels() -> None:
    canvas, pixels = Canvas.blank(4, 3, scale=(2, 1)), grey([10, 21, 255, 255], [0, 1, 255, 0])
    canvas.place_picture(pixels, 1, 1, (2, 2))
    (placed,) = canvas.pictures
    assert (placed.pixels[..., :3] == pixels).all()
    assert (placed.x, placed.y) == (1, 1)
    assert canvas.pixels[1:, 1:3, 1].tolist() == [[15, 255], [0, 127]]
    assert canvas.pixels[..., 3].tolist() == [[0, 0, 0, 0], [0, 255, 255, 0], [0, 255, 255, 0]]


@for_each("scale", [(1, 1), (2, 1), (1, 2), (3, 2), (8, 8), (16, 16)])
def test_a_canvas_shows_the_exact_means_of_a_picture(scale: tuple[int, int]) -> None:
    across, down = scale
    pixels = np.random.default_rng(1).integers(0, 256, (3 * down, 4 * across, 3), np.uint8)
    canvas = Canvas.blank(4, 3, scale=scale)
    canvas.place_picture(pixels, 0, 0, (4, 3))
    blocks = pixels.reshape(3, down, 4, across, 3).astype(int)
    assert (canvas.pixels[..., :3] == blocks.sum(axis=(1, 3)) // (across * down)).all()
    assert len(canvas.pictures) == (scale != (1, 1))


def test_a_placed_picture_is_clipped_at_the_edges_of_the_canvas() -> None:
    canvas, pixels = Canvas.blank(2, 2, scale=(2, 1)), grey(range(8), range(10, 18), range(20, 28))
    canvas.place_picture(pixels, -1, -2, (4, 3))
    (placed,) = canvas.pictures
    assert placed.pixels[..., 0].tolist() == [[22, 23, 24, 25]]
    assert (placed.x, placed.y) == (0, 0)
    assert canvas.pixels[..., 0].tolist() == [[22, 24], [0, 0]]


def test_a_picture_that_is_placed_outside_changes_nothing() -> None:
    canvas = Canvas.blank(3, 3, scale=(2, 1))
    for x, y in ((3, 0), (-2, 0), (0, 3), (0, -2)):
        canvas.place_picture(grey([9, 9], [9, 9]), x, y, (2, 2))
    assert not canvas.pixels.any()
    assert not canvas.pictures


def test_a_picture_that_is_darkened_is_still_seen_as_its_means() -> None:
    canvas = Canvas.blank(2, 1, scale=(2, 1))
    canvas.place_picture(grey([11, 20, 255, 0]), 0, 0, (2, 1), brightness=150)
    (placed,) = canvas.pictures
    assert placed.pixels[..., 0].tolist() == [[6, 11, 150, 0]]
    assert canvas.pixels[..., 0].tolist() == [[8, 75]]
