"""Rows of the picture as Textual knows rows."""

from __future__ import annotations

import io

from rich.console import Console

from rune_tui.compositor.ansi import encoded_rows
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import LOWER_HALF
from rune_tui.compositor.looks import looks_of
from rune_tui.ui.pixel_strip import PixelStrip
from tests.console.compositor.frames import flat, with_picture
from tests.console.compositor.terminal_model import Terminal, assert_shows


def test_part_of_a_row_has_the_colours_of_the_row() -> None:
    cells = at_depth(flat(4, 1, 255), ColourDepth.INDEXED_16)
    row = PixelStrip(cells, looks_of(cells), 0, 0, 4)
    part = row.crop(1, 3)
    assert part.render(Console(file=io.StringIO())) == "\x1b[97m██\x1b[0m"


def test_rows_that_textual_draws_and_their_segments_have_the_half_block_that_was_chosen() -> None:
    cells = flat(3, 1, 5)
    cells.pixels[1, :, :3] = 6
    part = PixelStrip(cells, looks_of(cells), 0, 0, 3, LOWER_HALF).crop(1, 2)
    drawn = part.render(Console(file=io.StringIO()))
    assert drawn == "\x1b[38;2;6;6;6;48;2;5;5;5m▄\x1b[0m"
    (segment,) = part
    assert segment.text == LOWER_HALF
    assert segment.style is not None
    assert str(segment.style) == "#060606 on #050505"


def test_part_of_a_row_shows_its_quadrants() -> None:
    cells, pictures = with_picture(flat(4, 2, 100), 1, steps=(60,))
    looks = looks_of(cells, pictures)
    row = PixelStrip(cells, looks, 1, 0, 4)
    whole = encoded_rows(looks)[1]
    assert row.render(Console(file=io.StringIO())) == whole
    terminal = Terminal(2, 1)
    terminal.feed(row.crop(1, 3).render(Console(file=io.StringIO())))
    assert_shows(terminal, looks.part(1, 1, 3))
    assert {mark.character for mark in terminal.marks.values()} & set("▘▚▌▙▜▛")
