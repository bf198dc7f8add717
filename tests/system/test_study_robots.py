"""Sessions of a study with real robots, and with parts that end in the middle of a trial.

A hub that the test starts stands for a real robot: the session knows no more of it than that.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.gcm.navigation import ROBOT_STATE, STOP
from hub.gcm.simulation import SIMULATION_PAUSE
from hub.recording.reader import Recording
from rune_study.session.journal import JOURNAL, Record, read_journal
from tests.support.waiting import slowness
from tests.system.harness import (
    STILL,
    ConsoleProcess,
    HubProcess,
    Observer,
    family,
    in_soak,
)

STUDY = """
title = "t"
seed = "s"
participants = 2
[session]
steps = ["trials"]
[defaults]
layout = "minimal"
arena = "empty"
link = "lan"
[trial]
seconds = {seconds}
[freeze]
questions = "quick"
not_before_s = 5
not_after_s = 5
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


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "questionnaires").mkdir()
    (tmp_path / "questionnaires" / "quick.toml").write_text(QUICK)
    return tmp_path


def begun(folder: Path, seconds: float, *options: str) -> ConsoleProcess:
    (folder / "study.toml").write_text(STUDY.format(seconds=seconds))
    return ConsoleProcess(["study", "run", str(folder), "--participant", "1", *options])


def seen(folder: Path, what: str) -> list[Record]:
    path = folder / "sub-01" / JOURNAL
    return [each for each in read_journal(path) if each.what == what] if path.exists() else []


def shows(session: ConsoleProcess, text: str) -> None:
    session.wait(lambda: text in session.text, 40.0, f"{text} is not on the screen")


def begin(session: ConsoleProcess, folder: Path, attempt: int = 1) -> None:
    shows(session, "Trial 1 of 1")
    session.type("\r")
    session.wait(lambda: len(seen(folder, "trial-begin")) == attempt, 40.0)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[HubProcess]:
    hub = HubProcess(tmp_path, options=("--listen", "0"))
    yield hub
    hub.close()


def test_a_real_robot_is_stopped_in_a_freeze_and_at_the_end_and_never_paused(
    folder: Path, robot: HubProcess
) -> None:
    watch = Observer(robot.endpoint)
    session = begun(folder, 8.0 * slowness(), "--hub", robot.endpoint)
    try:
        shows(session, "The robot has to stand at its start.")
        begin(session, folder)
        session.wait_for_picture()
        session.hold_until("w", lambda: watch.truth.linear > 0.2, 20.0)
        with session.holding("w"):
            session.wait(lambda: seen(folder, "frozen"), 20.0)
        shows(session, "How hard was it?")
        watch.wait(lambda: abs(watch.truth.linear) < STILL, 5.0, "it drives in a freeze")
        session.type("\x1b[B\r")
        session.wait(lambda: seen(folder, "unfrozen"), 20.0)
        session.wait_for_picture()
        with session.holding("w"):
            session.wait(lambda: seen(folder, "trial-end"), 20.0)
        assert session.wait_ended() == 0
        watch.wait(lambda: abs(watch.truth.linear) < STILL, 5.0, "it drives after the trial")
    finally:
        session.close()
        watch.close()
    stops = re.findall("stopped: (.*)", robot.log.read_text())
    assert stops == ["a pause of the study", "the trial is over"]
    (end,) = seen(folder, "trial-end")
    assert end.data["robots"][0]["true"] is False
    assert end.data["robots"][0]["distance"] > 0.2
    with Recording.open(folder / "sub-01" / "t1-a1.mcap") as recording:
        names = {each.name for each in recording.channels.values()}
    assert {f"/magellan/{each.name}" for each in (ROBOT_STATE, STOP)} <= names
    assert f"/magellan/{SIMULATION_PAUSE.name}" not in names


LOST = {
    "record": "The last attempt does not count: the recorder of t1-a1.mcap has ended.",
    "shape": "The last attempt does not count: the link shaper has ended.",
    "run": "The last attempt does not count: the hub at tcp",
}


@pytest.mark.soak
@pytest.mark.parametrize("part", [*list(LOST)[:2], *in_soak("run")])
def test_a_trial_without_one_of_its_parts_begins_again_and_says_why(
    folder: Path, part: str
) -> None:
    session = begun(folder, 60.0)
    try:
        begin(session, folder)
        killed(session, part)
        shows(session, LOST[part])
        begin(session, folder, attempt=2)
        session.wait_for_picture()
    finally:
        session.close()
    (end,) = seen(folder, "trial-end")
    assert end.data["why"].startswith(LOST[part].partition(": ")[2].removesuffix("."))


def killed(session: ConsoleProcess, command: str) -> None:
    """Kill the process of this command of `rune-hub`, and all that it started."""
    for process in family(session.process.pid):
        if [*process.cmdline(), "", "", "", ""][1:4] == ["-m", "hub", command]:
            for each in reversed(family(process.pid)):
                each.send_signal(signal.SIGKILL)
            return
    raise AssertionError(command)


@pytest.mark.soak  # it waits for ten seconds
def test_a_robot_that_says_nothing_ends_the_session_with_a_sentence(folder: Path) -> None:
    robot = HubProcess(folder, modules=("driver",))  # without navigation nothing says where it is
    session = begun(folder, 60.0, "--hub", robot.endpoint)
    try:
        shows(session, "Trial 1 of 1")
        session.type("\r")
        shows(session, "does not say where it is")
        assert session.wait_ended() == 1
    finally:
        session.close()
        robot.close()
