"""Rows of the picture as Textual knows rows."""

from __future__ import annotations

import io

from rich.console import Console

from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.ui.pixel_strip import PixelStrip
from tests.console.compositor.frames import flat


def test_part_of_a_row_has_the_colours_of_the_row() -> None:
    row = PixelStrip(at_depth(flat(4, 1, 255), ColourDepth.INDEXED_16), 0, 0, 4)
    part = row.crop(1, 3)
    assert part.render(Console(file=io.StringIO())) == "\x1b[97m██\x1b[0m"
