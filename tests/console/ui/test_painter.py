"""What brings frames to the terminal, past Textual."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from textual.app import App

from rune_tui.raster.urgency import Urgency
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import traits_of
from rune_tui.ui.painter import Painter
from rune_tui.ui.view_pane import ViewPane
from tests.console.compositor.frames import flat, random_cells


def test_a_frame_for_a_pane_that_is_on_no_screen_any_more_is_left_out() -> None:
    painter = Painter(App(), ViewPane(), traits_of(Answers(), {}, (16, 4)), 0.0)
    painter.paint(0.0, flat(16, 4, 9), (), np.zeros((4, 16), np.uint8))
    assert painter.display(0.0).frames_per_s == 0.0


def test_in_tmux_no_frame_is_longer_than_it_keeps_when_all_words_change(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    columns, rows = 40, 20
    painter = Painter(App(), ViewPane(), traits_of(Answers(), {"TMUX": "1"}, (columns, rows)), 0.0)
    monkeypatch.setattr(painter, "covered", lambda _: None)
    painter.control.most_bytes = 6 * columns * rows
    shown = np.full((rows, columns), Urgency.VIDEO, np.uint8)
    shown[-2:] = Urgency.OTHER
    painter.urgencies = shown
    still = random_cells(1, columns, rows, 99, 0.0)
    sizes = []
    for number in range(12):  # the camera rests, the words do not
        pixels = still.pixels.copy()
        pixels[-4:] = random_cells(number, columns, 2, 99, 0.0).pixels
        cells = dataclasses.replace(still, pixels=pixels)
        sizes.append(painter.frame(10.0 + number, cells, changed=True).size)
    assert max(sizes[1:]) <= painter.control.most_bytes
