"""Frames for terminals near and far: what is shown, in which order, and when it is exact."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.compositor.looks import looks_of
from rune_tui.compositor.output import Frame
from rune_tui.raster.urgency import Urgency
from rune_tui.terminal.block_output import BlockOutput, coarsened
from rune_tui.terminal.pacing import Acknowledgement, SentFrame
from rune_tui.terminal.rate import LADDER, RateController
from tests.console.compositor.frames import flat, random_cells, with_picture
from tests.console.compositor.terminal_model import Terminal, assert_shows

COLUMNS, ROWS = 24, 10
SHOWN = np.full((ROWS, COLUMNS), Urgency.OTHER, np.uint8)
SHOWN[:8] = Urgency.VIDEO


def narrow(bytes_per_s: float) -> RateController:
    """The controller of a terminal that takes so much."""
    control = RateController(0.0)
    frame = SentFrame(number=0, size=10_000, sent=0.0, behind=False)
    for _ in range(5):
        age = 10_000 / bytes_per_s
        control.acknowledged(
            0.0, Acknowledgement(frame=frame, age=age, gap=float("nan"), size=10_000)
        )
    return control


def scene(seed: int) -> Cells:
    """Noise in the picture, text around it."""
    cells = random_cells(seed, COLUMNS, ROWS, 4, 0.0)
    glyphs = cells.glyphs.copy()
    glyphs[8:] = 65 + seed % 20
    return Cells(pixels=cells.pixels, glyphs=glyphs, ink=cells.ink)


def writer(bytes_per_s: float) -> BlockOutput:
    return BlockOutput(GlyphSet.HALF, narrow(bytes_per_s))


def test_what_is_around_the_picture_comes_first_and_exactly() -> None:
    terminal, frames = Terminal(COLUMNS, ROWS), writer(2000.0)
    for seed in range(5):
        frame = frames.draw(scene(seed), (), SHOWN)
        terminal.feed(frame.first.decode())
        assert all(row >= 8 for row, _ in terminal.touched)
        assert all(
            terminal.marks[row, column].character == chr(65 + seed)
            for row in (8, 9)
            for column in range(COLUMNS)
        )
        terminal.feed(frame.picture.decode())
        assert all(row < 8 for row, _ in terminal.touched)


@given(
    width=st.sampled_from([500.0, 5e3, 50e3, 5e6]),
    seeds=st.lists(st.integers(0, 3), min_size=1, max_size=5),
)
def test_a_still_scene_becomes_exact_whatever_was_before(width: float, seeds: list[int]) -> None:
    terminal, frames = Terminal(COLUMNS, ROWS), writer(width)
    for seed in seeds:
        cells = scene(seed)
        frame = frames.draw(cells, (), SHOWN)
        terminal.feed((frame.first + frame.picture).decode())
    refined = 0
    while frames.inexact:
        frame = frames.refine()
        terminal.feed(frame.picture.decode())
        refined += 1
        assert refined <= 3 * ROWS
    assert_shows(terminal, cells)
    assert frames.draw(cells, (), SHOWN).size == 0
    assert not frames.refine().size


@pytest.mark.parametrize("width", [50e3, 200e3])
def test_a_refinement_is_no_longer_than_there_is_room_for(width: float) -> None:
    control = narrow(width)
    frames = BlockOutput(GlyphSet.HALF, control)
    frames.draw(scene(1), (), SHOWN)
    row = 40 * COLUMNS
    while frames.inexact:
        assert frames.refine().size <= max(control.room(), row)


class Rows(RateController):
    """Has room for so many rows, whatever the way takes."""

    rows = 1

    def room(self, now_under_way: float = 0.0) -> float:
        return self.rows * COLUMNS * 52.0 - now_under_way


def test_a_still_scene_becomes_exact_however_the_room_for_it_changes() -> None:
    control = Rows()
    frames, terminal = BlockOutput(GlyphSet.HALF, control), Terminal(COLUMNS, ROWS)
    first, last = scene(1), scene(1)
    first.pixels[...] //= 16  # colours so like each other that they become one
    last.pixels[...] = first.pixels
    last.pixels[10:16] = 80 - first.pixels[10:16]
    for cells, control.rows in ((first, 1), (last, 5)):
        control.level = len(LADDER) - 3
        frame = frames.draw(cells, (), SHOWN)
        terminal.feed((frame.first + frame.picture).decode())
        while frames.inexact:
            terminal.feed(frames.refine().picture.decode())
    assert_shows(terminal, last)


def test_a_picture_that_would_be_under_way_for_too_long_is_drawn_coarser_at_once() -> None:
    control = narrow(3000.0)
    frames = BlockOutput(GlyphSet.HALF, control)
    frame = frames.draw(scene(1), (), SHOWN)
    assert LADDER[control.level].grain > 1
    exact = BlockOutput(GlyphSet.HALF, narrow(50e6)).draw(scene(1), (), SHOWN)
    assert len(frame.picture) < len(exact.picture) / 2


def test_a_terminal_that_may_show_anything_gets_everything_anew() -> None:
    frames = writer(50e6)
    whole = frames.draw(scene(1), (), SHOWN)
    assert frames.draw(scene(1), (), SHOWN).size == 0
    frames.forget()
    assert frames.draw(scene(1), (), SHOWN) == whole


def test_what_is_covered_is_left_alone_until_it_is_free() -> None:
    terminal, frames = Terminal(COLUMNS, ROWS), writer(50e6)
    covered = np.zeros((ROWS, COLUMNS), np.bool_)
    covered[2:5, 4:9] = True
    cells = scene(1)
    frame = frames.draw(cells, (), SHOWN, covered)
    terminal.feed((frame.first + frame.picture).decode())
    assert not terminal.touched & {tuple(place) for place in np.argwhere(covered).tolist()}
    frame = frames.draw(cells, (), SHOWN)
    terminal.feed((frame.first + frame.picture).decode())
    while frames.inexact:
        terminal.feed(frames.refine().picture.decode())
    assert_shows(terminal, cells)


@given(st.integers(1, 7), st.integers(1, 5), st.integers(1, 4))
def test_coarse_pixels_are_the_means_of_their_squares(columns: int, rows: int, grain: int) -> None:
    cells = random_cells(columns + 7 * rows, columns, rows, 9, 0.0)
    coarse = coarsened(cells, grain).pixels
    for y in range(2 * rows):
        for x in range(columns):
            top, left = y // grain * grain, x // grain * grain
            square = cells.pixels[top : top + grain, left : left + grain].astype(float)
            assert np.abs(coarse[y, x] - square.mean((0, 1))).max() <= 0.5


def test_pixels_of_one_are_what_they_were() -> None:
    cells = flat(3, 2, 77)
    assert (coarsened(cells, 1).pixels == cells.pixels).all()


def test_what_does_not_fit_into_a_frame_follows_in_the_next() -> None:
    control, terminal = RateController(0.0, most_bytes=2000), Terminal(COLUMNS, ROWS)
    frames = BlockOutput(GlyphSet.HALF, control)
    cells = random_cells(1, COLUMNS, ROWS, 99, 0.5)
    frame = frames.draw(cells, (), np.full_like(SHOWN, Urgency.OTHER))
    sizes = []
    while True:
        sizes.append(frame.size)
        terminal.feed((frame.first + frame.picture).decode())
        if not frames.behind:
            break
        frame = frames.draw(cells, (), np.full_like(SHOWN, Urgency.OTHER))
    assert max(sizes) <= 2000
    assert len(sizes) > 3
    assert_shows(terminal, cells)


@pytest.mark.parametrize("width", [500.0, 5e6])
def test_a_still_picture_of_quadrants_becomes_exact_at_every_width(width: float) -> None:
    terminal, frames = Terminal(COLUMNS, ROWS), writer(width)
    cells, pictures = with_picture(scene(1), 1)
    terminal.feed(b"".join(parts(frames.draw(cells, pictures, SHOWN))).decode())
    for _ in range(200):
        if not frames.inexact and not frames.behind:
            break
        terminal.feed(
            b"".join(
                parts(frames.refine() if frames.inexact else frames.draw(cells, pictures, SHOWN))
            ).decode()
        )
    assert_shows(terminal, looks_of(cells, pictures))


def urgent_scene() -> np.ndarray:
    """Of each kind some cells, the most urgent ones at the bottom and in the middle."""
    urgencies = np.full((ROWS, COLUMNS), Urgency.VIDEO, np.uint8)
    urgencies[0] = Urgency.OTHER
    urgencies[3, 4:9] = urgencies[8] = Urgency.RANGES
    urgencies[9, :12] = Urgency.DRIVE
    urgencies[9, 12:] = urgencies[5, 7:11] = Urgency.ALARM
    return urgencies


def test_alarms_come_before_the_drive_state_before_ranges_before_the_rest_before_video() -> None:
    terminal, frames, urgencies = Terminal(COLUMNS, ROWS), writer(50e6), urgent_scene()
    for seed in (1, 2):  # all is new on the screen, then all but the characters changes
        cells = random_cells(seed, COLUMNS, ROWS, 99, 0.0)
        frame = frames.draw(cells, (), urgencies)
        terminal.feed((frame.first + frame.picture).decode())
        order = [int(urgencies[place]) for place in terminal.order]
        assert order == sorted(order)
        assert set(order) == set(Urgency)
        while frames.inexact:
            terminal.feed(frames.refine().picture.decode())
        assert_shows(terminal, cells)


@pytest.mark.parametrize("most_bytes", [300, 900, 2500])
def test_in_frames_that_hold_little_the_most_urgent_comes_first(most_bytes: int) -> None:
    control, terminal = RateController(0.0, most_bytes=most_bytes), Terminal(COLUMNS, ROWS)
    frames, urgencies = BlockOutput(GlyphSet.HALF, control), urgent_scene()
    cells, order = random_cells(3, COLUMNS, ROWS, 99, 0.0), []
    for _ in range(200):
        frame = frames.draw(cells, (), urgencies)
        assert len(frame.first) <= most_bytes
        terminal.feed((frame.first + frame.picture).decode())
        order += [int(urgencies[place]) for place in terminal.order]
        if not frames.behind:
            break
    assert order == sorted(order)
    assert Urgency.OTHER in order


def parts(frame: Frame) -> tuple[bytes, bytes]:
    return frame.first, frame.picture


@pytest.mark.parametrize(("width", "cut"), [(3000.0, False), (50e6, True)])
def test_a_picture_that_is_drawn_coarser_takes_no_quadrants(width: float, cut: bool) -> None:  # noqa: FBT001
    frame = writer(width).draw(*with_picture(flat(COLUMNS, ROWS, 100), 1, steps=(60,)), SHOWN)
    assert bool(set(frame.picture.decode()) & set("▘▚▌▙▜▛")) is cut


@pytest.mark.parametrize(
    ("glyphs", "size"),
    [(GlyphSet.HALF, (1, 2)), (GlyphSet.LOWER, (1, 2)), (GlyphSet.QUADRANTS, (2, 2))],
)
def test_an_output_says_how_many_pixels_it_shows(glyphs: GlyphSet, size: tuple[int, int]) -> None:
    assert BlockOutput(glyphs, narrow(50e6)).pixels_per_cell == size
