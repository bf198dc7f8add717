"""Pixels and characters of a canvas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wcwidth import wcwidth

from rune_tui.raster.canvas import Canvas, printable, printable_text

WHITE = (255, 255, 255, 255)


def written(canvas: Canvas, row: int = 0) -> str:
    return "".join(chr(point) if point else " " for point in canvas.glyphs[row].tolist())


def test_a_blank_canvas_shows_what_is_behind() -> None:
    canvas = Canvas.blank(5, 3)
    assert (canvas.width, canvas.height, canvas.rows) == (5, 3, 2)
    assert not canvas.pixels.any()
    assert not canvas.glyphs.any()


@pytest.mark.parametrize(
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
    points = range(0x110000)
    odd = [hex(p) for p in points for shown in printable(chr(p)) if wcwidth(shown) != 1]
    assert odd == []


@pytest.mark.parametrize(
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


def test_a_finer_picture_is_seen_as_its_mean_by_all_that_know_no_finer_ones() -> None:
    canvas = Canvas.blank(4, 3, fine=True)
    picture = np.array([[10, 21, 255, 255], [0, 1, 255, 0]], np.uint8)
    canvas.paste_fine(picture[..., None].repeat(3, axis=2), 1, 1)
    assert canvas.fine is not None
    assert (canvas.fine[1:, 2:6, 1] == picture).all()
    assert canvas.pixels[1:, 1:3, 1].tolist() == [[15, 255], [0, 127]]
    assert canvas.pixels[..., 3].tolist() == [[0, 0, 0, 0], [0, 255, 255, 0], [0, 255, 255, 0]]


def test_a_canvas_that_shows_no_finer_pictures_takes_none() -> None:
    with pytest.raises(ValueError, match="fine=True"):
        Canvas.blank(4, 3).paste_fine(np.zeros((1, 2, 3), np.uint8), 0, 0)
