"""Files in the user's folders, and words on orders that cannot arrive."""

from __future__ import annotations

import datetime
import threading
from pathlib import Path

import pytest

from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import STOP, TURN_COMMAND, VELOCITY_COMMAND, Stop, TurnCommand
from rune_tui.compositor.blend import compose
from rune_tui.files import user_files
from rune_tui.model.effects import SendEffect
from rune_tui.model.robot_state import Lack, LackKind, LinkPhase
from tests.console.states import layout_of, renamed, view_of
from tests.console.visualizers.conftest import Made
from tests.console.widgets.presses import marked, seeing
from tests.support.full_disk import files_no_longer_than

NOW = datetime.datetime(2005, 3, 18, 1, 58, 31, tzinfo=datetime.UTC)
STOPPING = SendEffect(robot="magellan", definition=STOP, value=Stop())
TURNING = SendEffect(robot="magellan", definition=TURN_COMMAND, value=TurnCommand())
DRIVING = SendEffect(robot="magellan", definition=VELOCITY_COMMAND, value=TwistStamped())


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the user's folders are."""
    for name in ("PICTURES", "DOCUMENTS"):
        monkeypatch.setenv(f"XDG_{name}_DIR", str(tmp_path / name.lower()))
    return tmp_path


def test_a_screenshot_is_a_picture_and_a_text(home: Path):
    outcome = user_files.write_screenshot(compose(20, 5, (9, 9, 9), []), (), NOW)
    names = sorted(path.name for path in (home / "pictures" / "Rune").iterdir())
    assert names == ["rune-20050318-015831.png", "rune-20050318-015831.txt"]
    assert str(home) in outcome.text
    assert not outcome.alarm


def test_marks_are_a_table_geojson_and_a_page(home: Path):
    robot = renamed(seeing(marked(1)).robots["magellan"], "a/../b")
    outcome = user_files.write_marks(robot, NOW)
    files = list((home / "documents" / "Rune").iterdir())
    assert sorted(path.suffix for path in files) == [".csv", ".geojson", ".html"]
    assert {path.stem for path in files} == {"a----b-20050318-015831"}
    assert "the marks (1) are in" in outcome.text


def test_without_marks_no_file_is_written(home: Path):
    unknown = user_files.write_marks(seeing(messages={}).robots["magellan"], NOW)
    assert (unknown.alarm, "has not reported its marks" in unknown.text) == (True, True)
    none = user_files.write_marks(seeing().robots["magellan"], NOW)
    assert (none.alarm, "nothing is marked" in none.text) == (False, True)
    assert list(home.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_an_alarm_and_no_fault(home: Path):
    for name in ("pictures", "documents"):
        (home / name).write_text("no folder")
    assert user_files.write_screenshot(compose(20, 5, (9, 9, 9), []), (), NOW).alarm
    assert user_files.write_marks(seeing(marked(1)).robots["magellan"], NOW).alarm


def test_a_full_disk_leaves_no_cut_file_of_marks(home: Path):
    (home / "documents" / "Rune").mkdir(parents=True)
    with files_no_longer_than(60):
        outcome = user_files.write_marks(seeing(marked(1)).robots["magellan"], NOW)
    assert outcome.alarm
    assert "marks not written" in outcome.text
    assert [*(home / "documents" / "Rune").iterdir()] == []


def test_a_recording_that_a_hung_disk_has_not_taken_is_an_alarm(
    home: Path, monkeypatch: pytest.MonkeyPatch
):
    answers = threading.Event()
    # The edge of the hardware: a disk that does not say that it has the data.
    monkeypatch.setattr("os.fdatasync", lambda _: answers.wait(20.0))
    recording, _ = user_files.begin_recording(layout_of(view_of(xsize=9, ysize=9)), "al", NOW)
    assert recording is not None
    outcome = user_files.end_recording(recording, 0.05)
    answers.set()
    assert outcome.alarm
    assert "has no end yet: the disk has not taken it for 0.05 s" in outcome.text
    assert str(home) in outcome.text


def test_two_recordings_of_one_second_have_files_of_their_own(home: Path):
    layout = layout_of(view_of(xsize=9, ysize=9))
    begun = [user_files.begin_recording(layout, "alice", NOW) for _ in range(2)]
    for recording, said in begun:
        assert not said.alarm
        assert recording is not None
        recording.close()
    names = sorted(path.name for path in (home / "documents" / "Rune").iterdir())
    assert names == ["run0-20050318-015831-2.mcap", "run0-20050318-015831.mcap"]


@pytest.mark.parametrize("phase", [LinkPhase.LOST, LinkPhase.CONNECTING])
def test_an_order_that_cannot_arrive_is_told_and_a_stream_is_not(phase: LinkPhase):
    robot = Made().robot(link=Made.link(phase))
    outcome = user_files.undelivered(STOPPING, robot)
    assert outcome is not None
    assert outcome.alarm
    assert "stop not sent" in outcome.text
    assert user_files.undelivered(DRIVING, robot) is None
    assert user_files.undelivered(STOPPING, Made().robot()) is None


def test_an_order_of_somebody_who_may_only_watch_is_told():
    robot = Made().robot(link=Made.link(may_command=False))
    outcome = user_files.undelivered(TURNING, robot)
    assert outcome is not None
    assert "turn command not sent: your key may watch and stop" in outcome.text
    assert user_files.undelivered(STOPPING, robot) is None


def test_an_order_that_nothing_on_the_robot_takes_is_told():
    absent = Lack(kind=LackKind.ABSENT, why="this robot has no module for it")
    robot = Made().robot(link=Made.link(lacking={"NAV_GOAL": absent, "NAV_MOVE": absent}))
    outcome = user_files.undelivered(TURNING, robot)
    assert outcome is not None
    assert outcome.text == (
        "turn command has no effect: it does not provide NAV_GOAL: this robot has no module for it"
    )
    # A stop has other takers too; a stream of commands is not told of 20 times a second.
    assert user_files.undelivered(STOPPING, robot) is None
    assert user_files.undelivered(DRIVING, robot) is None
