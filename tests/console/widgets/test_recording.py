"""The robot's own recorder on a console: its key, its words, what is said of it."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from hub.gcm.recording import RECORD_STATE, RecordAction, RecordCommand, RecordState
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, RobotRecordEffect
from rune_tui.model.recording import RecordingWatch
from rune_tui.visualizers.parts.recording_words import recording_parts
from tests.console.visualizers.conftest import received
from tests.console.widgets.presses import down, event_spec, seeing, widget_of

KEY = event_spec("f6")
IDLE = RecordState()
RUNS = RecordState(recording=1, running_s=725.0, size_mb=12.4, begun=1e9, path="/r/a.mcap")


def on(recording: RecordState | None) -> ConsoleState:
    state = seeing()
    if recording is None:
        return state
    robot = state.robots["magellan"]
    messages = {**robot.messages, RECORD_STATE.name: received(recording)}
    return dataclasses.replace(state, robots={"magellan": robot.with_(messages=messages)})


def ordered(recording: RecordState | None, **options: Any) -> RecordCommand:
    widget = widget_of("widgetRobotRecord", **options)
    (effect,) = widget.handle(down("f6"), KEY, on(recording))
    assert isinstance(effect, RobotRecordEffect)
    return effect.command


def test_the_key_begins_a_recording_and_ends_the_one_that_runs() -> None:
    for recording, action in (
        (None, RecordAction.START), (IDLE, RecordAction.START), (RUNS, RecordAction.STOP),
    ):  # fmt: skip
        assert ordered(recording).action is action


def test_other_keys_mark_split_and_keep_snapshots() -> None:
    assert ordered(RUNS, do="mark").action is RecordAction.MARK
    assert ordered(RUNS, do="split").action is RecordAction.SPLIT
    snapshot = ordered(RUNS, do="snapshot", before=5.0, after=2.0)
    assert (snapshot.action, snapshot.before_s, snapshot.after_s) == (RecordAction.SNAPSHOT, 5, 2)


def test_a_note_is_typed() -> None:
    (question,) = widget_of("widgetRobotRecord", do="note").handle(down("f6"), KEY, on(RUNS))
    assert isinstance(question, AskEffect)
    (effect,) = question.answer("a victim", on(RUNS))
    assert isinstance(effect, RobotRecordEffect)
    assert (effect.command.action, effect.command.text) == (RecordAction.MARK, "a victim")


@pytest.mark.parametrize(
    ("recording", "words"),
    [
        (None, []),
        (IDLE, []),
        (RUNS, ["ROBOT REC 0:12 h 12 MB"]),
        (RecordState(ring=1, ring_s=720.0), ["RING 12 min"]),
        (dataclasses.replace(RUNS, lost=7), ["ROBOT REC 0:12 h 12 MB", "7 LOST"]),
        (RecordState(fault="the disk is full"), ["NOT RECORDED: the disk is full"]),
    ],
)
def test_the_status_line_says_what_is_recorded(recording: Any, words: list[str]) -> None:
    robot = on(recording).robots["magellan"]
    assert [part.text for part in recording_parts(robot)] == words


def test_changes_are_reported_once() -> None:
    watch = RecordingWatch()
    steps = [
        (IDLE, []),
        (RUNS, ["the robot records to /r/a.mcap"]),
        (
            dataclasses.replace(RUNS, marks=1, mark="a victim"),
            ["mark 1 is in the recording: a victim"],
        ),
        (
            dataclasses.replace(RUNS, marks=1, lost=3, fault="the disk is full"),
            ["3 messages are missing in the recording", "the disk is full"],
        ),
        (dataclasses.replace(RUNS, marks=1, lost=3), ["all is recorded again"]),
        (
            RecordState(marks=1, lost=3, size_mb=0.0),
            ["the robot's recording is ended: 12.4 MB"],
        ),
    ]
    for recording, reports in steps:
        state = on(recording)
        for _ in range(2):
            found = [notice.text for notice in watch.look(state.robots["magellan"], state)]
            assert found == reports, recording
            reports = []
