"""What a recording holds besides the messages of robots."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, cast

import platformdirs
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from hub.ipc.definition import MessageDefinition
from hub.recording.reader import Recording
from rune_tui.files.recorder import Recorder
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.display_state import RUNE_DISPLAY, DisplayState
from rune_tui.model.own_records import RUNE_LAYOUT, GivenVariable
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
    shown = recorded(path, RUNE_LAYOUT)
    assert [(each.layout, each.run) for each in shown] == [
        (each.path, each.run_number) for each in (first, other, other, first)
    ]
    assert shown[1].variables == (GivenVariable(name="run", value="7"),)
    assert shown[0].sha256 == shown[3].sha256 != shown[1].sha256
    with Path(path).open("rb") as file:
        times = [message.log_time for *_, message in make_reader(file).iter_messages()]
    assert before <= times[0] <= times[-1] <= time.time_ns()


def test_the_files_of_a_layout_are_in_its_recording_once() -> None:
    recorder = Recorder(cast("RobotLinks", {}))
    layout = open_layout("search")
    recorder.begin(layout, "jane")
    path = Path(recorder.path)
    recorder.follow(layout)
    recorder.end()()
    with Recording.open(path) as recording:
        found = {each.name: recording.attachment(each) for each in recording.attachments}
        assert len(recording.attachments) == len(found) == len(layout.files)
    names = recorded(str(path), RUNE_LAYOUT)[0].files
    assert found[names[0]] == layout.files[0].read_bytes()
    assert any(name.endswith("parts/keys.xml") for name in names)


def test_a_recording_goes_into_the_folder_that_is_asked_for(tmp_path: Path) -> None:
    recorder = Recorder(cast("RobotLinks", {}))
    recorder.folder = tmp_path / "mine"
    recorder.begin(open_layout("minimal"), "jane")
    assert Path(recorder.path).parent == tmp_path / "mine"
    recorder.end()()


def test_a_recording_of_the_last_protocol_is_read_by_its_own_schemas() -> None:
    """It has messages that are another type now, or none: ranges in the state, an attitude."""
    path = Path(__file__).parents[2] / "data" / "recordings" / "protocol-4.mcap"
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = [
            (channel.topic.rpartition("/")[2], decoded)
            for _, channel, _, decoded in reader.iter_decoded_messages()
        ]
    names = {topic for topic, _ in found}
    assert names == {"GCM_RobotState", "GCM_Velocity_Command", "GCM_Attitude"}
    states = [decoded for topic, decoded in found if topic == "GCM_RobotState"]
    assert [state.x for state in states] == [0.0, 1.0, 2.0]


def recorded(path: str, definition: MessageDefinition[Any]) -> list[Any]:
    """What the console said of itself in a message, in its order."""
    with Path(path).open("rb") as file:
        return [
            definition.decode(message.data)
            for _, channel, message in make_reader(file).iter_messages()
            if channel.topic == f"/console/{definition.name}"
        ]
