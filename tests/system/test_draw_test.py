"""`rune draw-test` on a terminal that answers, and on one that does not."""

from __future__ import annotations

import json
import os
import re
from contextlib import ExitStack, closing

import numpy as np

from rune_tui.terminal.draw_speed import measure, moving_picture
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import traits_of
from tests.system.harness import ConsoleProcess


def test_a_terminal_learns_how_fast_it_draws() -> None:
    arguments = ["draw-test", "--seconds", "0.3", "--json"]
    with closing(ConsoleProcess(arguments, columns=400, rows=10)) as command:
        assert command.wait_ended(30.0) == 0
        words = re.search(r"\{.*?\}", command.text.replace("\n", ""))
        assert words, command.text
        found = json.loads(words[0])
    assert found["answers"]
    assert (found["columns"], found["rows"]) == (400, 10)
    assert found["frames"] > 0
    assert found["frames_per_s"] > 0
    assert found["bytes_per_frame"] > 400 * 10


def test_every_pixel_moves() -> None:
    first, second = (moving_picture(number, 40, 10).pixels[..., :3] for number in (0, 1))
    assert np.any(first != second, axis=2).all()


def test_a_terminal_that_does_not_answer_is_asked_once_and_has_no_speed() -> None:
    with ExitStack() as stack:
        (source, silent), (asked, sink) = os.pipe(), os.pipe()
        for end in (source, asked, sink):
            stack.callback(os.close, end)
        os.close(silent)
        traits = traits_of(Answers(), {}, (80, 24))
        mute = measure(source, sink, traits, (80, 24), 5.0)
        assert os.read(asked, 4096).count(b"\x1b[6n") == 1
    assert "not known" in mute.report()
    assert json.loads(mute.as_json()) == {"columns": 80, "rows": 24, "answers": False, "frames": 0}
