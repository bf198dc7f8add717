"""Recordings become arrays in the trial's own time."""

from __future__ import annotations

import dataclasses
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hub.gcm.ground_truth import GROUND_TRUTH, GroundTruth
from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from hub.gcm.navigation import ROBOT_STATE, MotionState, RobotState
from hub.ipc.definition import MessageDefinition
from hub.recording.anchor import TimeAnchor
from hub.recording.recording_set import RecordingSet
from hub.recording.topics import topic_of
from hub.recording.writer import RecordingWriter, WriterLimits
from rune_study.trial_data.operator import inputs_of
from rune_study.trial_data.sightings import marks_of
from rune_study.trial_data.track import track_of
from rune_study.trial_data.trial_log import TrialLog
from rune_tui.model.own_records import (
    RUNE_INPUT,
    RUNE_SELECT,
    InputOutcome,
    InputRecord,
    Selection,
    SelectRecord,
)

ANCHOR = TimeAnchor(1_700_000_000_000_000_000, 100.0)
BEGIN = ANCHOR.stamp(100.0)
NO_PICTURE = np.zeros(0, np.uint8)
Entry = tuple[float, str, MessageDefinition[Any], Any]


def opened(folder: Path, *entries: Entry) -> RecordingSet:
    """A recording of messages, measured at these seconds and logged half a second later.

    Messages of one topic are numbered from 1.
    """
    writer = RecordingWriter(folder / "x.mcap", ANCHOR, {}, WriterLimits(least_free=0))
    numbers: Counter[str] = Counter()
    for seconds, robot, definition, value in entries:
        measured = 100.0 + seconds
        payload = definition.encode(value)
        topic = topic_of(robot, definition)
        numbers[topic.name] += 1
        writer.add(topic, payload, measured + 0.5, measured, numbers[topic.name])
    writer.close()
    return RecordingSet.open([folder / "x.mcap"])


def state(x: float, bumpers: int = 0) -> RobotState:
    return RobotState(
        stamp=0.0,
        x=x,
        y=0.0,
        theta=0.0,
        linear=0.5,
        angular=0.0,
        commanded_linear=0.0,
        commanded_angular=0.0,
        bumpers=bumpers,
        battery_voltage=12.0,
        battery_fraction=1.0,
        motion=MotionState.MOVING,
        refused=0,
    )


def truth(x: float, contacts: int = 0) -> GroundTruth:
    return GroundTruth(
        time=0.0,
        x=x,
        y=0.0,
        theta=0.0,
        linear=0.5,
        angular=0.0,
        commanded_linear=0.0,
        commanded_angular=0.0,
        contacts=contacts,
        touching=0,
    )


def pressed(
    seconds: float,
    name: str,
    robot: str,
    *,
    repeat: bool = False,
    down: bool = True,
    value: float = 1.0,
) -> Entry:
    record = InputRecord(
        t_read=100.0 + seconds,
        input=name,
        pressed=down,
        repeat=repeat,
        value=value,
        viewport="",
        x=0.0,
        y=0.0,
        in_picture=False,
        handlers=("widgetDrive",),
        robot=robot,
        outcome=InputOutcome.SENT,
    )
    return (seconds, "console", RUNE_INPUT, record)


def test_a_track_is_the_truth_where_it_was_recorded_with_the_robots_bumpers(tmp_path: Path) -> None:
    entries: list[Entry] = [
        (1.0, "rover", GROUND_TRUTH, truth(1.0)),
        (1.5, "rover", ROBOT_STATE, state(9.0, bumpers=4)),
        (2.0, "rover", GROUND_TRUTH, truth(3.0, contacts=1)),
        (1.0, "other", ROBOT_STATE, state(5.0, bumpers=1)),
    ]
    with opened(tmp_path, *entries) as recordings:
        log = TrialLog(recordings, BEGIN)
        assert log.robots == ("other", "rover")
        track = track_of(log, "rover")
        assert track.true
        assert track.times == pytest.approx([1.0, 2.0])
        assert track.x.tolist() == [1.0, 3.0]
        assert track.bumpers.tolist() == [0, 4]
        assert track.contacts.tolist() == [0, 1]
        assert track.travelled == 2.0
        other = track_of(log, "other")
        assert (other.true, other.x.tolist(), other.bumpers.tolist()) == (False, [5.0], [1])
        assert len(track_of(log, "nobody").times) == 0


def test_inputs_count_once_while_a_key_is_held_and_belong_to_their_robot(tmp_path: Path) -> None:
    entries: list[Entry] = [
        (0.5, "console", RUNE_SELECT, SelectRecord(what=Selection.CHOSEN, robot="rover")),
        pressed(1.0, "w", "rover"),
        pressed(1.2, "w", "rover", repeat=True),
        pressed(2.0, "d", "rover"),
        pressed(3.0, "w", "other"),
        pressed(4.0, "F5", ""),
    ]
    with opened(tmp_path, *entries) as recordings:
        inputs = inputs_of(TrialLog(recordings, BEGIN))
        assert inputs.by_robot["rover"] == pytest.approx([1.0, 2.0])
        assert inputs.by_robot["other"] == pytest.approx([3.0])
        assert inputs.selections["rover"] == pytest.approx([0.5])
        assert len(inputs.inputs) == 5
        times, values = inputs.axis("joystick pad lefty")
        assert (len(times), len(values)) == (0, 0)


def test_reports_of_a_stick_count_when_it_leaves_the_last_place_by_5_percent(
    tmp_path: Path,
) -> None:
    places = [0.04, 0.06, 0.1, 0.5, 0.53, 1.0, 1.0, 0.0]
    stick = [
        pressed(1.0 + at, "joystick pad lefty", "r1", repeat=at > 0, down=value > 0.0, value=value)
        for at, value in enumerate(places)
    ]
    with opened(tmp_path, *stick) as recordings:
        inputs = inputs_of(TrialLog(recordings, BEGIN))
        assert inputs.by_robot["r1"] == pytest.approx([2.0, 4.0, 6.0, 8.0])
        assert len(inputs.inputs) == len(places)


def test_a_key_is_held_up_to_its_release_and_a_press_after_a_lost_one_begins_anew(
    tmp_path: Path,
) -> None:
    entries: list[Entry] = [
        pressed(1.0, "w", "rover"),
        pressed(1.5, "d", "rover"),
        pressed(2.0, "w", "rover", repeat=True),
        pressed(9.0, "w", "rover", down=False),
        pressed(20.0, "d", "rover"),
        pressed(21.0, "d", "rover", down=False),
    ]
    with opened(tmp_path, *entries) as recordings:
        inputs = inputs_of(TrialLog(recordings, BEGIN))
    assert inputs.held["rover"].tolist() == [
        pytest.approx([1.0, 9.0]),
        pytest.approx([20.0, 21.0]),
    ]


def test_a_key_that_is_down_when_the_trial_begins_or_ends_is_held(tmp_path: Path) -> None:
    """The console records on after the trial, and keys went down before it began."""
    entries: list[Entry] = [
        pressed(-0.4, "w", "rover"),
        pressed(-0.3, "q", "rover"),
        pressed(-0.2, "q", "rover", down=False),
        pressed(20.0, "w", "rover", down=False),
        pressed(20.1, "w", "rover"),
        pressed(23.0, "w", "rover", down=False),
        pressed(28.0, "a", "rover"),
        pressed(35.0, "a", "rover", down=False),
    ]
    with opened(tmp_path, *entries) as recordings:
        inputs = inputs_of(TrialLog(recordings, BEGIN, ANCHOR.stamp(130.0)))
    assert inputs.by_robot["rover"] == pytest.approx([20.0, 20.1, 23.0, 28.0])
    ends = [[-0.4, 20.0], [-0.3, -0.2], [20.1, 23.0], [28.0, 30.0]]
    assert inputs.held["rover"].tolist() == [pytest.approx(each) for each in ends]
    times, values = inputs.steering("rover")
    assert (times.tolist(), values.tolist()) == (pytest.approx([28.0]), [1.0])


def test_a_key_whose_release_is_missing_is_held_as_long_as_the_console_lives(
    tmp_path: Path,
) -> None:
    """A killed console, a lost focus, and a press that the console did not take."""
    focus = SelectRecord(what=Selection.FOCUS, on=False)
    deaf = pressed(40.0, "d", "rover", repeat=True)
    deaf = (*deaf[:3], dataclasses.replace(deaf[3], outcome=InputOutcome.DEAF))
    entries: list[Entry] = [
        pressed(1.0, "w", "rover"),
        (5.0, "console", RUNE_SELECT, focus),
        deaf,
        pressed(50.0, "a", "rover"),
        (58.0, "console", RUNE_SELECT, SelectRecord(what=Selection.HELP)),
        (90.0, "rover", ROBOT_STATE, state(1.0)),
    ]
    with opened(tmp_path, *entries) as recordings:
        held = inputs_of(TrialLog(recordings, BEGIN, ANCHOR.stamp(180.0))).held["rover"]
    assert held.tolist() == [pytest.approx([1.0, 5.0]), pytest.approx([50.0, 58.5])]


def test_a_release_of_what_was_pressed_while_control_was_withheld_is_no_interaction(
    tmp_path: Path,
) -> None:
    press = pressed(1.0, "w", "rover")
    withheld = dataclasses.replace(press[3], outcome=InputOutcome.WITHHELD)
    entries: list[Entry] = [(*press[:3], withheld), pressed(4.0, "w", "rover", down=False)]
    with opened(tmp_path, *entries) as recordings:
        inputs = inputs_of(TrialLog(recordings, BEGIN))
    assert (inputs.by_robot, inputs.held) == ({}, {})


def test_removed_marks_do_not_count_and_moved_ones_keep_their_first_time(tmp_path: Path) -> None:
    def marks(*points: tuple[int, float]) -> InterestPoints:
        return InterestPoints(
            points=tuple(
                InterestPoint(
                    number=number,
                    kind=PointKind.VICTIM,
                    x=x,
                    y=0.0,
                    thumbnail=NO_PICTURE,
                )
                for number, x in points
            )
        )

    entries: list[Entry] = [
        (1.0, "rover", INTEREST_POINTS, marks((1, 1.0))),
        (2.0, "rover", INTEREST_POINTS, marks((1, 1.0), (2, 2.0))),
        (3.0, "rover", INTEREST_POINTS, marks((2, 2.5))),
    ]
    with opened(tmp_path, *entries) as recordings:
        found = marks_of(TrialLog(recordings, BEGIN), "rover")
        assert [(time, point.number, point.x) for time, point in found] == [
            (pytest.approx(2.0), 2, 2.5)
        ]
