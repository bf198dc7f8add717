"""Terminals that eat the encoder's bytes end up with exactly the cells."""

from __future__ import annotations

import re

import numpy as np
import pyte
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rune_tui.compositor.ansi import RowEncoder, changed_rows
from rune_tui.compositor.cells import Cells

Shown = tuple[str, tuple[int, ...] | None, tuple[int, ...] | None]

GLYPHS = [32, 33, 65, 0xB0, 0x416, 0x2588, 0x2580, 0x1D400]


def random_cells(seed: int, columns: int, rows: int, colours: int, written: float) -> Cells:
    """Cells of few colours, so that neighbours are often equal, some with characters."""
    random = np.random.default_rng(seed)
    palette = random.integers(0, 256, (colours, 4), np.uint8)
    glyphs = random.choice(np.array(GLYPHS, np.uint32), (rows, columns))
    glyphs[random.random((rows, columns)) >= written] = 0
    return Cells(
        pixels=palette[random.integers(0, colours, (2 * rows, columns))],
        glyphs=glyphs,
        ink=palette[random.integers(0, colours, (rows, columns))],
    )


frames = st.builds(
    random_cells,
    st.integers(0, 100_000),
    st.integers(1, 14),
    st.integers(1, 6),
    st.integers(1, 5),
    st.sampled_from([0.0, 0.2, 1.0]),
)


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


def eaten(row: str) -> list[Shown]:
    """A screen model of its own: knows SGR colours and reset, refuses all else."""
    shown: list[Shown] = []
    ink: tuple[int, ...] | None = None
    ground: tuple[int, ...] | None = None
    for codes, character in re.findall(r"\x1b\[([\d;]*)m|([^\x1b\n])", row):
        if character:
            shown.append((character, None if character == " " else ink, ground))
            continue
        numbers = [int(code) for code in codes.split(";")]
        while numbers:
            kind = numbers.pop(0)
            if kind == 0:
                ink = ground = None
                continue
            assert numbers.pop(0) == 2
            colour = tuple(numbers[:3])
            assert len(colour) == 3
            del numbers[:3]
            if kind == 38:
                ink = colour
            else:
                assert kind == 48
                ground = colour
    return shown


@settings(max_examples=150, deadline=None)
@given(frames)
def test_a_screen_model_that_eats_the_rows_shows_the_cells(cells: Cells) -> None:
    rows = RowEncoder().encode_text(cells)
    assert len(rows) == cells.rows
    for number, row in enumerate(rows):
        assert re.fullmatch(r"(\x1b\[[\d;]+m|[^\x00-\x1f\x7f-\x9f])*", row)
        assert row.endswith("\x1b[0m")
        assert eaten(row) == [wanted(cells, number, c) for c in range(cells.columns)]


@settings(max_examples=40, deadline=None)
@given(frames)
def test_pyte_that_eats_the_rows_shows_the_cells(cells: Cells) -> None:
    screen = pyte.Screen(cells.columns, cells.rows)
    screen.reset_mode(pyte.modes.DECAWM)
    stream = pyte.Stream(screen)
    for number, row in enumerate(RowEncoder().encode_text(cells)):
        stream.feed(f"\x1b[{number + 1};1H{row}")
    for row in range(cells.rows):
        for column in range(cells.columns):
            glyph, ink, ground = wanted(cells, row, column)
            cell = screen.buffer[row][column]
            assert cell.data == glyph
            assert tuple(bytes.fromhex(cell.bg)) == ground
            if ink is not None:
                assert tuple(bytes.fromhex(cell.fg)) == ink


@given(frames)
def test_bytes_and_text_say_the_same(cells: Cells) -> None:
    encoder = RowEncoder()
    assert [row.decode() for row in encoder.encode(cells)] == encoder.encode_text(cells)


@given(st.lists(frames, min_size=2, max_size=5))
def test_nothing_is_left_over_from_earlier_frames(sequence: list[Cells]) -> None:
    encoder = RowEncoder()
    for cells in sequence:
        assert encoder.encode(cells) == RowEncoder().encode(cells)


@given(frames, st.data())
def test_chosen_rows_are_the_rows_of_the_whole(cells: Cells, data: st.DataObject) -> None:
    numbers = data.draw(st.lists(st.integers(0, cells.rows - 1)))
    whole = RowEncoder().encode(cells)
    assert RowEncoder().encode(cells, numbers) == [whole[number] for number in numbers]


def flat(columns: int, rows: int, colour: int) -> Cells:
    return Cells(
        pixels=np.full((2 * rows, columns, 4), colour, np.uint8),
        glyphs=np.zeros((rows, columns), np.uint32),
        ink=np.zeros((rows, columns, 4), np.uint8),
    )


def test_a_flat_row_sets_its_colour_once() -> None:
    assert RowEncoder().encode(flat(5, 1, 7)) == [b"\x1b[48;2;7;7;7m     \x1b[0m"]


def test_colours_in_force_are_not_set_again_across_blanks() -> None:
    cells = flat(3, 1, 7)
    cells.glyphs[0] = [65, 0, 66]
    cells.ink[0] = 200
    assert RowEncoder().encode(cells) == [b"\x1b[38;2;200;200;200;48;2;7;7;7mA B\x1b[0m"]


@given(st.lists(st.integers(0, 0xFFFFFFFF), min_size=1, max_size=20))
def test_no_code_point_whatever_puts_a_control_byte_on_the_terminal(points: list[int]) -> None:
    cells = flat(len(points), 1, 7)
    cells.glyphs[0] = points
    (row,) = RowEncoder().encode_text(cells)
    assert not re.search(r"[\x00-\x1a\x1c-\x1f\x7f-\x9f]", row)
    assert row.count("\x1b") == len(re.findall(r"\x1b\[[\d;]+m", row))


@pytest.mark.parametrize("point", [1, 10, 27, 0x7F, 0x9B, 0xD800, 0x110000, 0xFFFFFFFF])
def test_control_characters_and_non_characters_become_question_marks(point: int) -> None:
    cells = flat(1, 1, 7)
    cells.glyphs[0, 0] = point
    (row,) = RowEncoder().encode_text(cells)
    assert row.endswith("m?\x1b[0m")


def test_the_unused_byte_of_a_pixel_makes_no_difference() -> None:
    cells = random_cells(5, 10, 4, 3, 0.3)
    other = Cells(pixels=cells.pixels.copy(), glyphs=cells.glyphs, ink=cells.ink.copy())
    other.pixels[..., 3] += 77
    other.ink[..., 3] += 77
    assert RowEncoder().encode(other) == RowEncoder().encode(cells)
    assert changed_rows(cells, other).size == 0


def test_all_rows_are_changed_without_a_frame_of_the_same_size() -> None:
    assert changed_rows(None, flat(4, 3, 0)).tolist() == [0, 1, 2]
    assert changed_rows(flat(5, 3, 0), flat(4, 3, 0)).tolist() == [0, 1, 2]


def test_only_rows_that_look_different_are_changed() -> None:
    before = random_cells(8, 10, 6, 4, 0.5)
    after = Cells(pixels=before.pixels.copy(), glyphs=before.glyphs.copy(), ink=before.ink.copy())
    assert changed_rows(before, after).size == 0
    after.pixels[3, 9, 0] += 1
    after.glyphs[4, 0] = 0 if after.glyphs[4, 0] else 65
    after.glyphs[5, 2] = before.glyphs[5, 2] = 65
    after.ink[5, 2, 1] += 1
    before.glyphs[0, 0] = after.glyphs[0, 0] = 0
    after.ink[0, 0] += 1  # of no character: cannot be seen
    assert changed_rows(before, after).tolist() == [1, 4, 5]
