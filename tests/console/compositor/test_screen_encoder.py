"""What the encoder believes the terminal shows, a strict terminal shows, and near enough to it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import pyte
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import LOWER_HALF, UPPER_HALF
from rune_tui.compositor.looks import Looks, looks_of, unpacked
from rune_tui.compositor.quality import EXACT, Quality
from rune_tui.compositor.screen_encoder import ScreenEncoder
from tests.console.compositor.frames import flat, in_quadrants, random_cells, with_picture
from tests.console.compositor.terminal_model import Mark, Terminal, assert_cell, assert_shows
from tests.support.cases import for_each

ROUGH = Quality(tolerance=8, threshold=10)


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A frame of a sequence, and what happens to the terminal before it."""

    scene: str
    quality: Quality
    covered: float
    forgotten: float
    written: float


steps = st.builds(
    Step,
    scene=st.sampled_from(["new", "noisy", "drifting", "smooth", "still"]),
    quality=st.builds(Quality, tolerance=st.integers(0, 20), threshold=st.integers(0, 20)),
    covered=st.sampled_from([0.0, 0.0, 0.3, 1.0]),
    forgotten=st.sampled_from([0.0, 0.0, 0.3, 1.0]),
    written=st.sampled_from([0.0, 0.0, 0.2]),
)


def scene(step: Step, before: Cells, random: np.random.Generator) -> Cells:
    """The frame that follows another one."""
    rows, columns = before.rows, before.columns
    pixels, glyphs, ink = before.pixels.astype(int), before.glyphs.copy(), before.ink
    if step.scene == "new":
        return random_cells(int(random.integers(1 << 30)), columns, rows, 4, step.written)
    if step.scene == "noisy":
        pixels += random.integers(-12, 13, pixels.shape)
    elif step.scene == "drifting":
        pixels += 3
    elif step.scene == "smooth":
        across, down = np.arange(columns)[:, None], np.arange(2 * rows)[:, None, None]
        pixels = 3 * across + 5 * down + random.integers(0, 200, 4) + np.zeros((1, 1, 4), int)
    if step.scene != "still":
        changed = random.random(glyphs.shape) < step.written
        glyphs[changed] = random.choice([0, 32, 65, 66], np.count_nonzero(changed))
        ink = np.where(random.random((rows, columns, 1)) < step.written, 255 - ink, ink)
    return Cells(pixels=np.clip(pixels, 0, 255).astype(np.uint8), glyphs=glyphs, ink=ink)


@given(
    seed=st.integers(0, 1 << 30),
    columns=st.integers(1, 19),
    rows=st.integers(1, 4),
    depth=st.sampled_from([ColourDepth.TRUECOLOUR, ColourDepth.TRUECOLOUR, *ColourDepth]),
    half=st.sampled_from([UPPER_HALF, LOWER_HALF]),
    quadrants=st.booleans(),
    sequence=st.lists(steps, min_size=1, max_size=6),
)
def test_no_cell_is_ever_further_off_than_the_quality_allows_or_wrong_for_ever(
    seed: int,
    columns: int,
    rows: int,
    depth: ColourDepth,
    half: str,
    quadrants: bool,  # noqa: FBT001 - given by name
    sequence: list[Step],
) -> None:
    random = np.random.default_rng(seed)
    terminal = Terminal(columns, rows, coloured=depth is not ColourDepth.MONO)
    encoder = ScreenEncoder(half=half)
    frame = random_cells(seed, columns, rows, 5, 0.1)
    looks = looks_of(frame)
    for step in sequence:
        frame = scene(step, frame, random)
        looks = looks_of(at_depth(frame, depth))
        if quadrants and depth is ColourDepth.TRUECOLOUR:
            # Pixels of a picture that change while their means stay, too.
            looks = looks_of(*with_picture(frame, int(random.integers(1 << 30))))
        forgotten = random.random((rows, columns)) < step.forgotten
        covered = random.random((rows, columns)) < step.covered
        if step.forgotten == 1.0:
            encoder.forget()
        else:
            encoder.forget(forgotten)
        for place in np.argwhere(forgotten | covered):
            terminal.scribble(*place)
        terminal.feed(encoder.encode(looks, step.quality, covered).decode())
        assert not any(covered[place] for place in terminal.touched)
        assert (encoder.remembered.known == ~covered).all()
        assert_near(terminal, encoder, looks, step.quality)
    terminal.feed(encoder.encode(looks, EXACT).decode())
    assert_shows(terminal, looks)
    assert encoder.encode(looks, EXACT) == b""
    assert encoder.encode(looks, sequence[0].quality) == b""


def assert_near(terminal: Terminal, encoder: ScreenEncoder, looks: Looks, quality: Quality) -> None:
    off = 0
    if looks.depth is ColourDepth.TRUECOLOUR:
        off = max(quality.tolerance, quality.threshold)
    shown = encoder.remembered.shown
    assert shown is not None
    for row, column in np.argwhere(encoder.remembered.known).tolist():
        mark = terminal.marks[row, column]
        assert_cell(mark, shown, row, column)
        assert_cell(mark, looks, row, column, off=off)


@pytest.mark.parametrize("size", [(1, 1), (1, 120), (20, 5), (157, 43), (400, 1), (150, 120)])
@pytest.mark.parametrize("quality", [EXACT, ROUGH])
def test_terminals_of_all_sizes_get_every_cell(size: tuple[int, int], quality: Quality) -> None:
    columns, rows = size
    encoder, terminal = ScreenEncoder(), Terminal(columns, rows)
    before = random_cells(1, columns, rows, 40, 0.1)
    terminal.feed(encoder.encode(before, quality).decode())
    after = random_cells(2, columns, rows, 40, 0.1)
    some = np.random.default_rng(3).random((rows, columns)) < 0.1
    pixels = np.where(some.repeat(2, axis=0)[..., None], after.pixels, before.pixels)
    after = dataclasses.replace(before, pixels=pixels)
    terminal.feed(encoder.encode(after, quality).decode())
    assert_shows(terminal, after, off=quality.threshold)


def test_quadrants_whose_colours_come_near_enough_are_not_sent_again() -> None:
    encoder, quality = ScreenEncoder(), Quality(threshold=10)
    assert encoder.encode(looks_of(*with_picture(flat(9, 4, 100), 1)), quality)
    darker = looks_of(*with_picture(flat(9, 4, 93), 1))
    assert encoder.encode(darker, quality) == b""
    assert encoder.encode(darker, EXACT)


def one_cell(*greys: int, glyph: str = "") -> Looks:
    """A cell of four pixels of a picture, in reading order."""
    cells = flat(1, 1, 0)
    cells.glyphs[...] = ord(glyph) if glyph else 0
    pixels = np.reshape(greys, (2, 2, 1)).repeat(3, axis=2).astype(np.uint8)
    return looks_of(*in_quadrants(pixels, cells))


@pytest.mark.parametrize("quality", [EXACT, ROUGH])
def test_quarters_that_change_places_are_sent(quality: Quality) -> None:
    encoder = ScreenEncoder()
    assert "▘".encode() in encoder.encode(one_cell(200, 40, 40, 40), quality)
    assert "▚".encode() in encoder.encode(one_cell(200, 40, 40, 200), quality)


def test_quarters_of_like_colours_may_change_places() -> None:
    encoder, quality = ScreenEncoder(), Quality(threshold=20)
    encoder.encode(one_cell(118, 100, 100, 100), quality)
    assert encoder.encode(one_cell(100, 100, 118, 100), quality) == b""


def test_quarters_that_become_one_colour_take_no_quadrant() -> None:
    coarse = ScreenEncoder().encode(one_cell(118, 100, 100, 100), Quality(tolerance=10))
    assert coarse == b"\x1b[1;1H\x1b[48;2;109;109;109m \x1b[0m"


def test_pixels_of_a_picture_under_a_character_are_nothing_to_send() -> None:
    encoder = ScreenEncoder()
    assert encoder.encode(one_cell(200, 40, 40, 40, glyph="A"))
    assert encoder.encode(one_cell(40, 200, 40, 40, glyph="A")) == b""


@given(seed=st.integers(0, 1 << 30), columns=st.integers(1, 9), rows=st.integers(1, 4))
def test_pyte_shows_quadrants_too(seed: int, columns: int, rows: int) -> None:
    screen = pyte.Screen(columns, rows)
    stream = pyte.ByteStream(screen)
    encoder = ScreenEncoder()
    for number in range(3):
        # Most cells stay as they are, so that the cursor has to move.
        frame = random_cells(seed, columns, rows, 2, 0.2)
        drawn = looks_of(*with_picture(frame, seed + number // 2))
        stream.feed(encoder.encode(drawn))
    for row, column in np.ndindex(rows, columns):
        cell = screen.buffer[row][column]
        assert_cell(Mark(cell.data, rgb(cell.fg), rgb(cell.bg)), drawn, row, column)


def rgb(told: str) -> tuple[int, ...] | None:
    """A colour as pyte tells it; None for the terminal's own."""
    return None if told == "default" else tuple(bytes.fromhex(told))


@given(seed=st.integers(0, 1 << 30), columns=st.integers(1, 19), rows=st.integers(1, 4))
def test_pyte_shows_the_frames_too(seed: int, columns: int, rows: int) -> None:
    screen = pyte.Screen(columns + 3, rows + 2)
    stream = pyte.ByteStream(screen)
    encoder = ScreenEncoder(top=2, left=3)
    for number in range(3):
        # Few colours: many cells stay as they are, so that the cursor has to move.
        cells = random_cells(seed + number, columns, rows, 2, 0.2)
        stream.feed(encoder.encode(cells))
    for row, column in np.ndindex(rows, columns):
        cell = screen.buffer[row + 2][column + 3]
        upper, lower = cells.pixels[2 * row : 2 * row + 2, column, :3].astype(int)
        glyph = int(cells.glyphs[row, column])
        ground = (upper + lower) // 2 if glyph else lower
        assert cell.bg == bytes(ground.tolist()).hex()
        assert cell.data == (chr(glyph) if glyph else " " if (upper == lower).all() else "▀")
        if cell.data != " ":
            ink = cells.ink[row, column, :3] if glyph else upper
            assert cell.fg == bytes(ink.tolist()).hex()
    assert screen.cursor.attrs == screen.default_char


def grey(*rows: list[int]) -> Cells:
    """Cells of one grey each."""
    cells = flat(len(rows[0]), len(rows), 0)
    cells.pixels[..., :3] = np.repeat(np.array(rows, np.uint8), 2, axis=0)[..., None]
    return cells


def test_a_frame_that_is_shown_already_takes_no_bytes() -> None:
    encoder = ScreenEncoder()
    assert encoder.encode(random_cells(1, 9, 4, 5, 0.2))
    assert encoder.encode(random_cells(1, 9, 4, 5, 0.2)) == b""


def test_only_changed_cells_are_sent_each_behind_the_shortest_move() -> None:
    encoder = ScreenEncoder(top=10, left=20)
    encoder.encode(grey([0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]))
    changed = grey([0, 0, 7, 7, 0, 7], [9, 0, 0, 9, 0, 0])
    assert encoder.encode(changed) == (
        b"\x1b[11;23H\x1b[48;2;7;7;7m  \x1b[C \x1b[12;21H\x1b[48;2;9;9;9m \x1b[2C \x1b[0m"
    )


def test_cells_of_two_colours_take_the_half_block_that_was_chosen() -> None:
    cells = flat(1, 1, 5)
    cells.pixels[1, :, :3] = 6
    assert b"38;2;5;5;5;48;2;6;6;6m" + "▀".encode() in ScreenEncoder().encode(cells)
    lower = ScreenEncoder(half=LOWER_HALF).encode(cells)
    assert b"38;2;6;6;6;48;2;5;5;5m" + "▄".encode() in lower


def test_noise_below_the_threshold_is_not_sent_and_nearly_equal_neighbours_become_one() -> None:
    random = np.random.default_rng(4)
    encoder = ScreenEncoder()
    noisy = [flat(40, 10, 100) for _ in range(3)]
    for cells in noisy:
        cells.pixels[..., :3] += random.integers(0, 9, (20, 40, 3), np.uint8)
    assert len(encoder.encode(noisy[0], ROUGH)) < 10 * 40 * 5
    assert encoder.encode(noisy[1], ROUGH) == b""
    assert encoder.encode(noisy[2], ROUGH) == b""


def test_a_still_frame_becomes_exact_by_sending_what_is_not() -> None:
    encoder, terminal = ScreenEncoder(), Terminal(40, 10)
    cells = random_cells(5, 40, 10, 300, 0.0)
    cells.pixels[4:, :, :3] = 50  # exact from the beginning
    terminal.feed(encoder.encode(cells, Quality(tolerance=60)).decode())
    terminal.feed(encoder.encode(cells, EXACT).decode())
    assert terminal.touched
    assert max(row for row, _ in terminal.touched) < 2
    assert_shows(terminal, cells)


@pytest.mark.parametrize("quality", [EXACT, ROUGH, Quality(threshold=255)])
def test_an_alarm_that_comes_changes_or_goes_is_shown_at_every_quality(quality: Quality) -> None:
    encoder, terminal = ScreenEncoder(), Terminal(6, 1)
    quiet = flat(6, 1, 100)
    alarm = flat(6, 1, 101)
    alarm.glyphs[0, 1:5] = [ord(letter) for letter in "STOP"]
    alarm.ink[..., :3] = 255
    redder = dataclasses.replace(alarm, ink=alarm.ink - np.array([0, 1, 1, 0], np.uint8))
    brighter = dataclasses.replace(redder, pixels=redder.pixels + np.uint8(1))
    for cells in (quiet, alarm, redder, brighter):
        terminal.feed(encoder.encode(cells, quality).decode())
        for column in range(1, 5):
            assert_cell(terminal.marks[0, column], cells, 0, column)
    terminal.feed(encoder.encode(quiet, quality).decode())
    assert not any(mark.character in "STOP" for mark in terminal.marks.values())


def test_covered_cells_are_left_alone_and_sent_when_they_are_free() -> None:
    encoder, cells = ScreenEncoder(), grey([1, 2, 3])
    middle = np.array([[False, True, False]])
    assert b"48;2;2;2;2" not in encoder.encode(cells, covered=middle)
    assert encoder.encode(cells, covered=middle) == b""
    assert encoder.encode(cells) == b"\x1b[1;2H\x1b[48;2;2;2;2m \x1b[0m"


def test_what_is_forgotten_is_sent_again_and_nothing_else() -> None:
    encoder, cells = ScreenEncoder(), grey([1, 2, 3])
    whole = encoder.encode(cells)
    encoder.forget(np.array([[False, False, True]]))
    assert encoder.encode(cells) == b"\x1b[1;3H\x1b[48;2;3;3;3m \x1b[0m"
    encoder.forget()
    assert encoder.remembered.shown is None
    assert encoder.encode(cells) == whole


def test_another_size_or_depth_is_sent_whole() -> None:
    encoder = ScreenEncoder()
    encoder.encode(grey([1, 2, 3]))
    for cells in (grey([1, 2]), at_depth(grey([1, 2]), ColourDepth.INDEXED_256)):
        assert encoder.encode(cells) == ScreenEncoder().encode(cells)
        assert encoder.remembered.known.all()


def test_frames_without_cells_take_no_bytes() -> None:
    for columns, rows in ((0, 0), (0, 3), (3, 0)):
        for quality in (EXACT, ROUGH):
            assert ScreenEncoder().encode(flat(columns, rows, 0), quality) == b""


def test_what_was_shown_does_not_change_with_later_frames_or_with_the_caller() -> None:
    encoder, cells = ScreenEncoder(), grey([1, 2, 3])
    encoder.encode(cells)
    shown = encoder.remembered.shown
    assert shown is not None
    cells.pixels[...] = 99
    encoder.encode(grey([1, 2, 7]))
    assert unpacked(shown.upper)[0, :, 0].tolist() == [1, 2, 3]


@for_each("numbers", [(-1, 0), (128, 0), (0, -1), (0, 256)])
def test_qualities_beyond_what_a_colour_has_are_refused(numbers: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="choose other numbers"):
        Quality(tolerance=numbers[0], threshold=numbers[1])


def test_moves_reach_across_the_widest_terminals() -> None:
    encoder = ScreenEncoder()
    encoder.encode(flat(1200, 1, 0))
    ends = flat(1200, 1, 0)
    ends.pixels[:, [0, 999, 1100], :3] = 7
    terminal = Terminal(1200, 1)
    terminal.feed(encoder.encode(ends).decode())
    assert terminal.touched == {(0, 0), (0, 999), (0, 1100)}
    encoder.encode(flat(1200, 1, 0))
    ends.pixels[:, 999, :3] = 0
    terminal.feed(encoder.encode(ends).decode())
    assert terminal.touched == {(0, 0), (0, 1100)}


def test_of_a_part_of_the_cells_nothing_else_is_sent_or_believed() -> None:
    encoder, terminal = ScreenEncoder(), Terminal(7, 3)
    first, second = random_cells(1, 7, 3, 4, 0.2), random_cells(2, 7, 3, 4, 0.2)
    terminal.feed(encoder.encode(first).decode())
    upper = np.zeros((3, 7), np.bool_)
    upper[0] = True
    terminal.feed(encoder.encode(second, only=upper).decode())
    assert_near(terminal, encoder, joined(second, first), EXACT)
    terminal.feed(encoder.encode(second, only=~upper).decode())
    assert_near(terminal, encoder, second, EXACT)


def test_what_was_encoded_and_not_written_can_be_taken_back() -> None:
    encoder, terminal = ScreenEncoder(), Terminal(7, 3)
    first, second = random_cells(1, 7, 3, 4, 0.2), random_cells(2, 7, 3, 4, 0.2)
    terminal.feed(encoder.encode(first).decode())
    before = encoder.remembered
    assert encoder.encode(second)
    encoder.return_to(before)
    assert_near(terminal, encoder, first, EXACT)
    terminal.feed(encoder.encode(second, ROUGH).decode())
    assert_near(terminal, encoder, second, ROUGH)


def test_what_was_known_of_another_size_is_of_no_use() -> None:
    encoder = ScreenEncoder()
    encoder.encode(flat(3, 2, 9))
    before = encoder.remembered
    encoder.encode(flat(4, 2, 9))
    encoder.return_to(before)
    assert encoder.remembered.shown is None


def joined(upper: Cells, lower: Cells) -> Cells:
    """The first row of one frame over the others of another."""
    return Cells(
        pixels=np.concatenate([upper.pixels[:2], lower.pixels[2:]]),
        glyphs=np.concatenate([upper.glyphs[:1], lower.glyphs[1:]]),
        ink=np.concatenate([upper.ink[:1], lower.ink[1:]]),
    )


def test_the_last_columns_become_one_colour_in_frames_of_any_width() -> None:
    for columns in (2, 3, 7, 8, 11, 13):
        cells = flat(columns, 1, 100)
        cells.pixels[:, 1::2, :3] = 108
        expected = b"\x1b[1;1H\x1b[48;2;104;104;104m" + b" " * columns + b"\x1b[0m"
        assert ScreenEncoder().encode(cells, Quality(tolerance=4)) == expected


def test_what_became_what_is_shown_already_is_not_sent() -> None:
    encoder, cells = ScreenEncoder(), flat(8, 1, 100)
    encoder.encode(cells)
    cells.pixels[0, 2:4, :3] = [[98], [102]]
    assert encoder.encode(cells, Quality(tolerance=4)) == b""


def test_one_covered_cell_of_many_is_left_alone() -> None:
    encoder, terminal = ScreenEncoder(), Terminal(40, 5)
    covered = np.zeros((5, 40), np.bool_)
    covered[2, 20] = True
    for number in range(2):
        cells = random_cells(number, 40, 5, 300, 0.1)
        terminal.feed(encoder.encode(cells, covered=covered).decode())
        assert len(terminal.touched) == 199
        assert (2, 20) not in terminal.touched


def test_the_ink_of_a_space_makes_no_difference() -> None:
    encoder, cells = ScreenEncoder(), flat(3, 1, 7)
    cells.glyphs[...] = ord(" ")
    encoder.encode(cells)
    cells.ink[...] = 99
    assert encoder.encode(cells) == b""


@pytest.mark.parametrize(
    "depth", [depth for depth in ColourDepth if depth is not ColourDepth.TRUECOLOUR]
)
def test_colours_that_have_numbers_are_exact_at_every_quality(depth: ColourDepth) -> None:
    cells = at_depth(random_cells(3, 40, 5, 300, 0.1), depth)
    rough = ScreenEncoder().encode(cells, Quality(tolerance=100, threshold=200))
    assert rough == ScreenEncoder().encode(cells)
