"""`rune draw-test` on a terminal that answers, and on one that does not."""

from __future__ import annotations

import json
import re
from contextlib import closing

import numpy as np

from rune_tui.terminal.draw_speed import DrawSpeed, moving_picture
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


def test_every_pixel_moves_and_words_do_not_claim_a_speed_without_an_answer() -> None:
    first, second = (moving_picture(number, 40, 10).pixels[..., :3] for number in (0, 1))
    assert np.any(first != second, axis=2).all()
    mute = DrawSpeed(size=(80, 24), frames=0, took=0.0, sent=0, encoding=0.0, round_trip=0.0)
    assert "not known" in mute.report()
    assert not json.loads(mute.as_json())["answers"]
