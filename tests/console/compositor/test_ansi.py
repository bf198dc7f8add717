"""Terminals that eat the encoder's bytes end up with exactly the cells."""

from __future__ import annotations

import re

import numpy as np
import pyte
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.ansi import encoded_rows
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from tests.console.compositor.frames import flat, frames, random_cells
from tests.console.compositor.terminal_model import Terminal, assert_shows
from tests.support.cases import for_each

FEWER = [depth for depth in ColourDepth if depth is not ColourDepth.TRUECOLOUR]
Shown = tuple[str, tuple[int, ...] | None, tuple[int, ...] | None]


def wanted(cells: Cells, row: int, column: int) -> Shown:
    """Character, foreground (None where it does not show) and background of a cell."""
    upper, lower = cells.pixels[2 * row : 2 * row + 2, column, :3].astype(int)
    glyph = chr(cells.glyphs[row, column])
    if glyph == "\0":
        if (upper == lower).all():
            return " ", None, tuple(lower.tolist())
        return "▀", tuple(upper.tolist()), tuple(lower.tolist())
    ground = tuple(((upper + lower) // 2).tolist())
    return glyph, None if glyph == " " else tuple(cells.ink[row, column, :3].tolist()), ground


@pytest.mark.parametrize("depth", ColourDepth)
@given(cells=frames)
def test_a_strict_terminal_that_eats_the_rows_shows_the_cells(
    depth: ColourDepth, cells: Cells
) -> None:
    cells = at_depth(cells, depth)
    rows = encoded_rows(cells)
    assert len(rows) == cells.rows
    terminal = Terminal(cells.columns, cells.rows, coloured=depth is not ColourDepth.MONO)
    for number, row in enumerate(rows):
        terminal.feed(f"\x1b[{number + 1};1H{row}")
        assert len(terminal.touched) == cells.columns
    assert_shows(terminal, cells)


@given(frames)
def test_pyte_that_eats_the_rows_shows_the_cells(cells: Cells) -> None:
    screen = pyte.Screen(cells.columns, cells.rows)
    screen.reset_mode(pyte.modes.DECAWM)
    stream = pyte.Stream(screen)
    for number, text in enumerate(encoded_rows(cells)):
        stream.feed(f"\x1b[{number + 1};1H{text}")
    for row in range(cells.rows):
        for column in range(cells.columns):
            glyph, ink, ground = wanted(cells, row, column)
            cell = screen.buffer[row][column]
            assert cell.data == glyph
            assert tuple(bytes.fromhex(cell.bg)) == ground
            if ink is not None:
                assert tuple(bytes.fromhex(cell.fg)) == ink


def looks(cell: pyte.screens.Char, depth: ColourDepth) -> tuple[str, int, int]:
    """Character and the numbers of foreground and background."""
    if depth is ColourDepth.MONO:
        assert (cell.fg, cell.bg) == ("default", "default")
        return cell.data, int(not cell.reverse), int(cell.reverse)
    names = [pyte.graphics.FG_BG_256] * 2
    if depth is ColourDepth.INDEXED_16:
        names = [
            [plain[first + number] for number in range(8)]
            + [bright[first + 60 + number] for number in range(8)]
            for first, plain, bright in (
                (30, pyte.graphics.FG_ANSI, pyte.graphics.FG_AIXTERM),
                (40, pyte.graphics.BG_ANSI, pyte.graphics.BG_AIXTERM),
            )
        ]
    numbers = [
        -1 if colour == "default" else len(palette) - 1 - palette[::-1].index(colour)
        for colour, palette in zip((cell.fg, cell.bg), names, strict=True)
    ]
    return cell.data, numbers[0], numbers[1]


@pytest.mark.parametrize("depth", FEWER)
@given(cells=frames)
def test_pyte_shows_the_cells_in_the_colours_that_there_are(
    depth: ColourDepth, cells: Cells
) -> None:
    cells = at_depth(cells, depth)
    screen = pyte.Screen(cells.columns, cells.rows)
    screen.reset_mode(pyte.modes.DECAWM)
    stream = pyte.Stream(screen)
    for number, row in enumerate(encoded_rows(cells)):
        stream.feed(f"\x1b[{number + 1};1H{row}")
    assert screen.cursor.attrs.bg == "default"
    assert not screen.cursor.attrs.reverse
    for row, column in np.ndindex(cells.glyphs.shape):
        upper, lower = cells.pixels[2 * row : 2 * row + 2, column, 3].tolist()
        mark, ink, ground = looks(screen.buffer[row][column], depth)
        if cells.glyphs[row, column]:
            assert (mark, ground) == (chr(cells.glyphs[row, column]), lower)
            assert mark == " " or ink == cells.ink[row, column, 3]
        else:
            halves = {
                "▀": (ink, ground),
                "▄": (ground, ink),
                "█": (ink, ink),
                " ": (ground, ground),
            }
            assert halves[mark] == (upper, lower)


def test_colours_are_told_in_the_fewest_bytes_of_their_depth() -> None:
    def row(depth: ColourDepth, *pairs: tuple[int, int]) -> str:
        cells = flat(len(pairs), 1, 0)
        cells.pixels[:, :, :3] = np.array(pairs).T[..., None]
        (text,) = encoded_rows(at_depth(cells, depth))
        return text

    black, white = (0, 0), (255, 255)
    up, down = (255, 0), (0, 255)
    assert row(ColourDepth.INDEXED_256, black, black) == "\x1b[48;5;16m  \x1b[0m"
    assert row(ColourDepth.INDEXED_256, up, down) == "\x1b[38;5;231;48;5;16m▀▄\x1b[0m"
    assert row(ColourDepth.INDEXED_16, black, black) == "\x1b[40m  \x1b[0m"
    # Bright colours are foregrounds: some terminals have no bright backgrounds.
    assert row(ColourDepth.INDEXED_16, white, up, down) == "\x1b[97m█\x1b[40m▀▄\x1b[0m"
    assert row(ColourDepth.MONO, black, up, down, white) == " ▀▄█"


def test_without_colours_only_text_on_bright_ground_needs_an_escape() -> None:
    cells = flat(4, 1, 255)
    cells.glyphs[0, 1:3] = ord("A")
    mono = at_depth(cells, ColourDepth.MONO)
    assert encoded_rows(mono) == ["█\x1b[7mAA\x1b[27m█"]
    cells.glyphs[0, 3] = ord("A")
    mono = at_depth(cells, ColourDepth.MONO)
    assert encoded_rows(mono) == ["█\x1b[7mAAA\x1b[0m"]


def test_a_flat_row_sets_its_colour_once() -> None:
    assert encoded_rows(flat(5, 1, 7)) == ["\x1b[48;2;7;7;7m     \x1b[0m"]


def test_colours_in_force_are_not_set_again_across_blanks() -> None:
    cells = flat(3, 1, 7)
    cells.glyphs[0] = [65, 0, 66]
    cells.ink[0] = 200
    assert encoded_rows(cells) == ["\x1b[38;2;200;200;200;48;2;7;7;7mA B\x1b[0m"]


@given(st.lists(st.integers(0, 0xFFFFFFFF), min_size=1, max_size=20))
def test_no_code_point_whatever_puts_a_control_byte_on_the_terminal(points: list[int]) -> None:
    cells = flat(len(points), 1, 7)
    cells.glyphs[0] = points
    (row,) = encoded_rows(cells)
    assert not re.search(r"[\x00-\x1a\x1c-\x1f\x7f-\x9f]", row)
    assert row.count("\x1b") == len(re.findall(r"\x1b\[[\d;]+m", row))


@for_each("point", [1, 10, 27, 0x7F, 0x9B, 0xD800, 0x110000, 0xFFFFFFFF])
def test_control_characters_and_non_characters_become_question_marks(point: int) -> None:
    cells = flat(1, 1, 7)
    cells.glyphs[0, 0] = point
    (row,) = encoded_rows(cells)
    assert row.endswith("m?\x1b[0m")


def test_the_unused_byte_of_a_pixel_makes_no_difference() -> None:
    cells = random_cells(5, 10, 4, 3, 0.3)
    other = Cells(pixels=cells.pixels.copy(), glyphs=cells.glyphs, ink=cells.ink.copy())
    other.pixels[..., 3] += 77
    other.ink[..., 3] += 77
    assert encoded_rows(other) == encoded_rows(cells)
