"""What colours a terminal is taken to have."""

from __future__ import annotations

import io
from collections.abc import Mapping

import pytest
from rich.console import Console

from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.ui.pixel_strip import PixelStrip
from rune_tui.ui.terminal import colour_depth
from tests.console.compositor.frames import flat


@pytest.mark.parametrize(
    ("environment", "described", "wanted"),
    [
        ({"TERM": "xterm-256color", "COLORTERM": "truecolor"}, 256, ColourDepth.TRUECOLOUR),
        ({"TERM": "xterm-256color", "COLORTERM": "24bit"}, 256, ColourDepth.TRUECOLOUR),
        ({"TERM": "xterm-direct"}, 1 << 24, ColourDepth.TRUECOLOUR),
        ({"TERM": "xterm-256color"}, 256, ColourDepth.INDEXED_256),
        ({"TERM": "newer-than-this-machine"}, None, ColourDepth.INDEXED_256),
        ({"TERM": "xterm-16color"}, 16, ColourDepth.INDEXED_16),
        ({"TERM": "linux"}, 8, ColourDepth.INDEXED_16),
        ({"TERM": "vt220"}, 0, ColourDepth.MONO),
        ({"TERM": "xterm", "COLORTERM": "truecolor", "NO_COLOR": "1"}, 8, ColourDepth.MONO),
        ({"TERM": "linux", "NO_COLOR": ""}, 8, ColourDepth.INDEXED_16),
    ],
)
def test_the_environment_says_what_colours_there_are(
    environment: Mapping[str, str], described: int | None, wanted: ColourDepth
) -> None:
    assert colour_depth(environment, lambda _: described) is wanted


@pytest.mark.parametrize(
    ("platform", "wanted"),
    [("linux", ColourDepth.MONO), ("win32", ColourDepth.TRUECOLOUR)],
)
def test_without_a_name_only_windows_has_colours(
    platform: str, wanted: ColourDepth, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.platform", platform)
    assert colour_depth({}) is wanted


def test_part_of_a_row_has_the_colours_of_the_row() -> None:
    row = PixelStrip(at_depth(flat(4, 1, 255), ColourDepth.INDEXED_16), 0, 0, 4)
    part = row.crop(1, 3)
    assert part.render(Console(file=io.StringIO())) == "\x1b[97m██\x1b[0m"
