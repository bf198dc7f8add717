"""A session of a study with real hubs and the real console on a terminal."""

from __future__ import annotations

import math
import signal
import time
from pathlib import Path

import psutil
import pytest

from hub.gcm.autonomy import AUTONOMY_COMMAND
from hub.gcm.navigation import ROBOT_STATE, Assistance
from hub.recording.reader import Recording
from hub.recording.recording_set import RecordingSet
from rune_study.data.derive import derive
from rune_study.data.store import recordings_of
from rune_study.plan.study_file import read_study
from rune_study.session.journal import JOURNAL, Record, read_journal
from rune_study.trial_data.trial_log import TrialLog
from rune_tui.model.own_records import RUNE_INPUT, InputOutcome
from rune_tui.model.study_records import RUNE_PROBE
from rune_tui.replay.source import EventKind
from rune_tui.replay.survey import survey
from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, family, gone

STUDY = """
title = "t"
seed = "s"
participants = 2
[session]
steps = [{steps}]
[defaults]
arena = "empty"
[factors]
layout = ["minimal"]
[trial]
seconds = {seconds}
after = ["quick"]
{more}
"""
QUICK = """
name = "quick"
title = "Quick"
[[item]]
id = "hard"
kind = "choice"
text = "How hard was it?"
options = ["easy", "hard"]
"""
INTERRUPTED = """
[freeze]
questions = "quick"
not_before_s = 3
not_after_s = 3
[neglect]
not_before_s = 5
not_after_s = 5
still_s = 0.5
longest_s = 2
[secondary]
every_s = [1.0, 1.0]
longest_s = 20
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("texts", "questionnaires"):
        (tmp_path / name).mkdir()
    (tmp_path / "texts" / "welcome.md").write_text("# Hello\n")
    (tmp_path / "questionnaires" / "quick.toml").write_text(QUICK)
    return tmp_path


def begun(
    folder: Path, seconds: float, more: str = "", steps: str = '"welcome", "trials"'
) -> ConsoleProcess:
    text = STUDY.format(seconds=seconds, more=more, steps=steps)
    (folder / "study.toml").write_text(text)
    return ConsoleProcess(["study", "run", str(folder), "--participant", "1"])


def records(folder: Path) -> list[Record]:
    path = folder / "sub-01" / JOURNAL
    return read_journal(path) if path.exists() else []


def seen(folder: Path, what: str) -> list[Record]:
    return [each for each in records(folder) if each.what == what]


def shows(session: ConsoleProcess, text: str) -> None:
    session.wait(lambda: text in session.text, 40.0, f"{text} is not on the screen")


def test_a_trial_is_driven_recorded_and_asked_about(folder: Path) -> None:
    session = begun(folder, 3.0)
    try:
        for page in ("Hello", "Trial 1 of 1"):
            shows(session, page)
            session.type("\r")
        session.wait_for_picture()
        shows(session, "How hard was it?")
        session.type("\x1b[B\r")
        assert session.wait_ended() == 0
    finally:
        session.close()
    (end,) = seen(folder, "trial-end")
    assert end.data["why"] == "time"
    done = seen(folder, "done")
    assert [each.data["n"] for each in done] == [0, 1, 2]
    files = done[1].data["result"]["files"]
    assert files == ["t1-a1.mcap", "t1-a1.console.mcap"]
    topics = {}
    for name in files:
        with Recording.open(folder / "sub-01" / name) as recording:
            topics[name] = {channel.name for channel in recording.channels.values()}
    assert "/magellan/SIM_GroundTruth" in topics[files[0]]
    assert "/console/RuneFrame" in topics[files[1]]


@pytest.mark.soak
def test_a_session_that_is_killed_in_a_trial_leaves_nothing_and_goes_on(folder: Path) -> None:
    session = begun(folder, 60.0)
    try:
        for page in ("Hello", "Trial 1 of 1"):
            shows(session, page)
            session.type("\r")
        session.wait(lambda: seen(folder, "trial-begin"), 40.0)
        parts = [psutil.Process(each.pid) for each in family(session.process.pid)]
        assert len(parts) > 3
        session.process.send_signal(signal.SIGKILL)
        until(lambda: gone(parts), 20.0, "parts of the trial go on")
    finally:
        session.close()
    again = ConsoleProcess(["study", "run", str(folder), "--participant", "1"])
    try:
        shows(again, "Trial 1 of 1")
        again.type("\r")
        again.wait(lambda: len(seen(folder, "trial-begin")) == 2, 40.0)
        again.wait_for_picture()
        begins = [each.data for each in seen(folder, "begin")]
        assert [(each["n"], each["attempt"]) for each in begins] == [(0, 1), (1, 1), (1, 2)]
        assert {"t1-a1.mcap", "t1-a2.mcap"} <= {path.name for path in folder.glob("sub-01/*")}
    finally:
        again.close()


@pytest.mark.soak
def test_freezes_withheld_control_and_the_secondary_task_interrupt_a_trial(folder: Path) -> None:
    session = begun(folder, 9.0, INTERRUPTED)
    try:
        for page in ("Hello", "Trial 1 of 1"):
            shows(session, page)
            session.type("\r")
        session.wait_for_picture()
        shows(session, "EVEN OR ODD")
        session.type("\x1b[17~")  # F6
        shows(session, "How hard was it?")
        assert "STANDING" not in session.text
        session.type("\x1b[B\r")
        session.wait(lambda: seen(folder, "unfrozen"), 20.0)
        session.wait_for_picture()
        session.hold("w", 0.5)  # after a freeze, control is withheld after the next use
        session.wait(lambda: seen(folder, "withheld"), 20.0)
        session.wait(lambda: seen(folder, "allowed"), 20.0)
        session.wait(lambda: seen(folder, "trial-end"), 40.0)
    finally:
        session.close()
    (frozen,), (unfrozen,) = seen(folder, "frozen"), seen(folder, "unfrozen")
    (begin,), (end,) = seen(folder, "trial-begin"), seen(folder, "trial-end")
    away = unfrozen.moment - frozen.moment
    assert end.moment - begin.moment >= 9.0 + away - 0.1
    assert end.data["seconds"] == pytest.approx(9.0, abs=0.5)
    answered = [each for each in seen(folder, "secondary") if each.data["key"] == "f6"]
    assert answered
    assert all(each.data["seconds"] > 0.0 for each in answered)
    with Recording.open(folder / "sub-01" / "t1-a1.mcap") as recording:
        assert "/magellan/SIM_Pause" in {each.name for each in recording.channels.values()}


SAGAT = """
name = "sagat"
title = "Now"
[[item]]
id = "position"
kind = "place"
text = "Where is the robot?"
truth = "position"
[[item]]
id = "bumps"
kind = "number"
text = "How many bumps?"
truth = "collisions"
"""


@pytest.mark.soak
def test_answers_at_a_freeze_are_scored_by_the_truth_of_that_moment(folder: Path) -> None:
    (folder / "questionnaires" / "sagat.toml").write_text(SAGAT)
    session = begun(folder, 6.0, "[freeze]\nnot_before_s = 3\nnot_after_s = 3\n")
    try:
        for page in ("Hello", "Trial 1 of 1"):
            shows(session, page)
            session.type("\r")
        shows(session, "Where is the robot?")
        assert "magellan" not in session.text
        assert "█" in session.text
        session.type("\x1b[A\r")  # the middle of the arena
        shows(session, "How many bumps?")
        session.type("0\r")
        shows(session, "How hard was it?")
        session.type("\x1b[B\r")
        assert session.wait_ended() == 0
    finally:
        session.close()
    data = derive(read_study(folder), 1)
    position, bumps = data.probes
    assert (bumps.answer, bumps.truth, bumps.correct) == ("0.0", "0.0", 1)
    assert position.truth == "0.0 0.0"
    assert 3.0 <= position.asked <= position.answered <= bumps.answered
    x, y = map(float, position.answer.split())
    assert position.correct == (math.hypot(x, y) <= 1.0)
    scores = {row.metric: row.value for row in data.metrics if row.metric.startswith("sagat")}
    assert scores["sagat_1"] == (1.0 if position.correct else 0.5)
    assert scores["sagat_unanswered"] == 0.0
    files = recordings_of(read_study(folder), 1, 1)
    assert [file.name for file in files] == [
        "t1-a1.console.mcap",
        "t1-a1.mcap",
        "t1-a1.study.mcap",
    ]
    with RecordingSet.open(files) as recordings:
        log = TrialLog(recordings)
        probes = [record for _, record in log.values("study", RUNE_PROBE)]
        frozen = [each for each in survey(recordings).events if each.kind is EventKind.FREEZE]
    assert [(each.id, each.correct) for each in probes] == [
        (row.id, bool(row.correct)) for row in data.probes
    ]
    assert [each.text for each in frozen] == ["t1 frozen", "t1 unfrozen"]


def test_who_does_not_agree_ends_the_session_for_good(folder: Path) -> None:
    session = begun(folder, 3.0, steps='"consent", "trials"')
    try:
        shows(session, "Enter: begin")
        session.type("\r")
        shows(session, "1  Yes")
        session.type("2\r")
        shows(session, "No ends the session")
        session.type("\r")
        shows(session, "Thank you")
        session.type("\r")
        assert session.wait_ended() == 1
    finally:
        session.close()
    assert [each.what for each in records(folder)] == ["session", "begin", "declined"]
    again = begun(folder, 3.0, steps='"consent", "trials"')
    try:
        shows(again, "--participant 2 --replaces 1")
        assert again.wait_ended() == 1
    finally:
        again.close()
    assert [each.what for each in records(folder)] == ["session", "begin", "declined"]


def test_practice_that_is_quit_too_early_says_so(folder: Path) -> None:
    practice = '[practice]\ncriterion = "distance >= 500"\n'
    session = begun(folder, 3.0, practice, steps='"practice", "trials"')
    try:
        shows(session, "Practice")
        session.type("\r")
        session.wait(lambda: seen(folder, "trial-begin"), 40.0)
        session.wait_for_picture()
        end = time.monotonic() + 40.0
        while not seen(folder, "trial-end"):  # keys of a view that is too old are ignored
            assert time.monotonic() < end, session.text
            session.type("q")
            again = time.monotonic() + 1.0
            while not seen(folder, "trial-end") and time.monotonic() < again:
                session.pump(0.03)
        shows(session, "before its aim was reached")
        session.type("\r")
        shows(session, "Trial 1 of 1")
    finally:
        session.close()
    (done,) = seen(folder, "done")
    assert done.data["result"]["passed"] is False


def test_practice_ends_when_a_metric_of_its_last_part_is_reached(folder: Path) -> None:
    criterion = "command_rate <= 1 and driven < 1 and bumps <= 0 and seconds >= 2"
    practice = f'[practice]\ncriterion = "{criterion}"\nwindow_s = 2\nmost_s = 60\n'
    session = begun(folder, 3.0, practice, steps='"practice", "trials"')
    try:
        shows(session, "Practice")
        session.type("\r")
        shows(session, "Trial 1 of 1")
    finally:
        session.close()
    (done,) = seen(folder, "done")
    assert (done.data["result"]["ended"], done.data["result"]["passed"]) == ("criterion", True)
    (note,) = seen(folder, "criterion")
    assert note.data["met"] is True
    assert note.data["values"]["driven"] == pytest.approx(0.0, abs=0.05)
    assert note.data["values"]["command_rate"] == 0.0
    assert note.data["values"]["bumps"] == 0.0


@pytest.mark.soak
def test_teleoperation_without_assistance_refuses_goals_and_drives(folder: Path) -> None:
    limits = '[defaults]\narena = "empty"\nautonomy = "teleoperation"\nassistance = "off"'
    text = STUDY.format(seconds=15.0, more="", steps='"trials"').replace(
        '[defaults]\narena = "empty"', limits
    )
    (folder / "study.toml").write_text(text.replace("minimal", "search"))
    session = ConsoleProcess(["study", "run", str(folder), "--participant", "1"])
    try:
        shows(session, "Trial 1 of 1")
        session.type("\r")
        session.wait_for_picture()
        shows(session, "ASSISTANCE OFF")
        for key in ("e", "\x1b[15~"):  # F5 switches assistance
            session.type(key)
        shows(session, "not in this condition")
        session.pump(1.5)
        session.hold_until("w", lambda: seen(folder, "trial-end"), 40.0)
        shows(session, "How hard was it?")
    finally:
        session.close()
    (begin,) = seen(folder, "trial-begin")
    assert (begin.data["autonomy"], begin.data["assistance"]) == ("teleoperation", "off")
    (end,) = seen(folder, "trial-end")
    assert end.data["robots"][0]["distance"] > 0.3
    files = [folder / "sub-01" / f"t1-a1{kind}.mcap" for kind in ("", ".console", ".study")]
    with RecordingSet.open(files) as recordings:
        log = TrialLog(recordings)
        assert not [*log.values("magellan", AUTONOMY_COMMAND)]
        states = [each.assistance for _, each in log.values("magellan", ROBOT_STATE)]
        used = {(each.input, each.outcome) for _, each in log.own(RUNE_INPUT) if each.pressed}
    assert states[-1] is Assistance.OFF
    assert {("e", InputOutcome.REFUSED), ("f5", InputOutcome.REFUSED)} < used
    assert ("w", InputOutcome.SENT) in used
    with Recording.open(files[2]) as recording:
        kept = recording.about["rune"]
    assert (kept["autonomy"], kept["assistance"]) == ("teleoperation", "off")
