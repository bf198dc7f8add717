"""What a recording holds besides the messages of robots."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, cast

import platformdirs
import pytest
from mcap.reader import make_reader

from hub.ipc.definition import MessageDefinition
from rune_tui.files.recorder import Recorder
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.display_state import RUNE_DISPLAY, DisplayState
from rune_tui.model.shown_layout import SHOWN_LAYOUT, ShownLayout
from rune_tui.model.team_events import RUNE_TEAM, TeamEvent, TeamEventKind
from rune_tui.startup.opening import open_layout

DISPLAY = DisplayState(latency=0.04, frames_per_s=15.0, bytes_per_s=5e5, coarseness=3)


@pytest.fixture(autouse=True)
def documents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Recordings of these tests go there."""
    monkeypatch.setattr(platformdirs, "user_documents_path", lambda: tmp_path)


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
    assert end().text.startswith("3 messages")
    assert recorded(path, RUNE_DISPLAY) == [DISPLAY] * 2


def test_what_the_operator_did_with_the_robots_is_recorded() -> None:
    recorder = Recorder(cast("RobotLinks", {}))
    event = TeamEvent(kind=TeamEventKind.CHOSEN, robot="blimp", after_s=3.5)
    recorder.note_team(1.0, event)
    recorder.begin(open_layout("minimal"), "jane")
    path = recorder.path
    recorder.note_team(2.0, event)
    recorder.end()()
    assert recorded(path, RUNE_TEAM) == [event]


def test_each_layout_that_is_shown_is_recorded_with_its_time() -> None:
    recorder = Recorder(cast("RobotLinks", {}))
    first, other = open_layout("minimal"), open_layout("hri-a", {"run": "7"})
    recorder.follow(other)
    before = time.time_ns()
    recorder.begin(first, "jane")
    path = recorder.path
    for layout in (other, other, first):
        recorder.follow(layout)
    recorder.end()()
    shown = [ShownLayout(layout=each.path, run=each.run_number) for each in (first, other)]
    assert recorded(path, SHOWN_LAYOUT) == [shown[0], shown[1], shown[1], shown[0]]
    with Path(path).open("rb") as file:
        times = [message.log_time for *_, message in make_reader(file).iter_messages()]
    assert before <= times[0] <= times[-1] <= time.time_ns()


def recorded(path: str, definition: MessageDefinition[Any]) -> list[Any]:
    """What the console said of itself in a message, in its order."""
    with Path(path).open("rb") as file:
        return [
            definition.decode(message.data)
            for _, channel, message in make_reader(file).iter_messages()
            if channel.topic == f"/console/{definition.name}"
        ]
