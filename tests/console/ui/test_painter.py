"""What brings frames to the terminal, past Textual."""

from __future__ import annotations

import numpy as np
from textual.app import App

from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import traits_of
from rune_tui.ui.painter import Painter
from rune_tui.ui.view_pane import ViewPane
from tests.console.compositor.frames import flat


def test_a_frame_for_a_pane_that_is_on_no_screen_any_more_is_left_out() -> None:
    painter = Painter(App(), ViewPane(), traits_of(Answers(), {}, (16, 4)), 0.0)
    painter.paint(0.0, flat(16, 4, 9), np.zeros((4, 16), np.uint8))
    assert painter.display(0.0).frames_per_s == 0.0
