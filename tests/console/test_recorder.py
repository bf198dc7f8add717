"""What a recording holds besides the messages of robots."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from mcap.reader import make_reader

from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.display_state import RUNE_DISPLAY, DisplayState
from rune_tui.opening import open_layout
from rune_tui.recorder import Recorder

DISPLAY = DisplayState(latency=0.04, frames_per_s=15.0, bytes_per_s=5e5, coarseness=3)


def test_how_pictures_reach_the_operator_is_recorded_once_a_second() -> None:
    recorder = Recorder(cast("RobotLinks", {}))
    recorder.note(0.0, DISPLAY)
    assert not recorder.path
    said = recorder.begin(open_layout("minimal"), "jane")
    path = recorder.path
    assert path in said.text
    for now in (10.0, 10.3, 10.9, 11.0, 11.5):
        recorder.note(now, DISPLAY)
    end = recorder.end()
    assert not recorder.path
    assert end().text.startswith("2 messages")
    with Path(path).open("rb") as file:
        found = [
            (channel.topic, RUNE_DISPLAY.decode(message.data))
            for _, channel, message in make_reader(file).iter_messages()
        ]
    assert found == [("/console/RuneDisplay", DISPLAY)] * 2
