"""The data of a simulated trial: victims, ground and bumps in the arena's own frame."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from hub.gcm.ground_truth import GROUND_TRUTH
from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.vision import IMAGE, Image, ImageCoding
from rune_study.metrics.registry import measure
from rune_study.metrics.trial_time import trial_time
from rune_study.trial_data.measured import DRIVEN, Surroundings, trial_data
from rune_study.trial_data.trial_log import TrialLog
from rune_study.trial_data.truth import RESOLUTION, truth_of
from rune_tui.model.display_state import DisplayState
from rune_tui.model.own_records import (
    RUNE_FRAME,
    RUNE_SHOWN,
    FramePicture,
    FrameRecord,
    FrameRobot,
    ShownRecord,
)
from tests.study.trial_data.test_trial_data import (
    BEGIN,
    NO_PICTURE,
    Entry,
    opened,
    pressed,
    state,
    truth,
)
from tests.support.messages import camera_state

YELLOW = truth_of("yellow")


def test_the_true_ground_has_the_start_but_no_wall() -> None:
    reached = YELLOW.reachable
    row, column = (int(each) for each in YELLOW.grid.cells(YELLOW.start.x, YELLOW.start.y))
    assert reached[row, column]
    assert not (reached & YELLOW.grid.blocked).any()
    assert 5.0 < np.count_nonzero(reached) * RESOLUTION**2 < 200.0
    assert len(YELLOW.surface) > 100
    assert len(YELLOW.victims) > 0


def test_marks_are_compared_in_the_arenas_frame(tmp_path: Path) -> None:
    """The robot's map begins at the start, turned by a quarter against the arena."""
    x, y = YELLOW.victims[0]
    at = dataclasses.replace(truth(x - 2.0), y=y, theta=math.pi / 2)
    mark = InterestPoint(number=1, kind=PointKind.VICTIM, x=0.0, y=-2.1, thumbnail=NO_PICTURE)
    entries: list[Entry] = [
        (0.0, "rover", GROUND_TRUTH, at),
        (0.0, "rover", ROBOT_STATE, state(0.0)),
        (5.0, "rover", INTEREST_POINTS, InterestPoints(points=(mark,))),
        (9.0, "rover", GROUND_TRUTH, at),
    ]
    with opened(tmp_path, *entries) as recordings:
        around = Surroundings(time=trial_time(0.0, 10.0), truth=YELLOW)
        data = trial_data({"rover": TrialLog(recordings, BEGIN)}, around)
    assert data.marks is not None
    found = measure(data)
    assert found["victims_found"].value == 1
    assert found["victims_error"].value == pytest.approx(0.1)
    assert found["first_victim"].value == pytest.approx(5.0)


def test_pauses_are_cut_out_and_progress_is_what_was_driven(tmp_path: Path) -> None:
    entries: list[Entry] = [
        *((float(t), "rover", GROUND_TRUTH, truth(0.5 * t)) for t in range(11)),
        pressed(1.0, "w", "rover"),
        pressed(4.5, "w", "rover"),
        pressed(7.0, "d", "rover"),
    ]
    with opened(tmp_path, *entries) as recordings:
        time = trial_time(0.0, 10.0, [(4.0, 6.0)])
        around = Surroundings(time=time, effectiveness=DRIVEN)
        data = trial_data({"rover": TrialLog(recordings, BEGIN)}, around)
    (robot,) = data.robots
    assert data.length == 8.0
    assert robot.inputs == pytest.approx([1.0, 5.0])
    assert robot.progress is not None
    assert robot.progress.values[-1] == pytest.approx(5.0)
    assert measure(data)["driven"].value == pytest.approx(5.0)
    assert not measure(data)["victims_found"].known


def test_a_robot_has_the_inputs_of_its_role(tmp_path: Path) -> None:
    entries: list[Entry] = [
        (0.0, "magellan", GROUND_TRUTH, truth(0.0)),
        (1.0, "red", ROBOT_STATE, state(0.0)),
        pressed(1.0, "w", "red"),
    ]
    with opened(tmp_path, *entries) as recordings:
        around = Surroundings(time=trial_time(0.0, 2.0))
        data = trial_data({"red": TrialLog(recordings, BEGIN)}, around)
    assert [(each.name, each.inputs.tolist()) for each in data.robots] == [
        ("red", [pytest.approx(1.0)])
    ]


def test_steering_keys_and_the_answer_of_the_robot_are_found(tmp_path: Path) -> None:
    entries: list[Entry] = [
        *(
            (0.1 * t, "rover", GROUND_TRUTH, dataclasses.replace(truth(0.0), linear=0.5 * (t > 12)))
            for t in range(30)
        ),
        pressed(1.0, "w", "rover"),
        pressed(1.5, "a", "rover"),
        (0.9, "rover", IMAGE, picture()),
        (1.4, "rover", IMAGE, picture()),
        frame(1, 1.0, 1),
        frame(2, 1.5, 2),
        (1.1, "console", RUNE_SHOWN, ShownRecord(number=1, handed=1.1, answered=1.2)),
        (1.6, "console", RUNE_SHOWN, ShownRecord(number=2, handed=1.6, answered=1.7)),
    ]
    with opened(tmp_path, *entries) as recordings:
        around = Surroundings(time=trial_time(0.0, 3.0))
        data = trial_data({"rover": TrialLog(recordings, BEGIN)}, around)
    (robot,) = data.robots
    assert robot.keys is not None
    assert robot.keys.values.tolist() == [1.0]
    assert data.photons is not None
    assert data.photons.tolist() == [pytest.approx(0.7)]


def frame(number: int, seconds: float, picture_number: int) -> Entry:
    """A frame with one picture of the rover's main camera."""
    seen = FramePicture(camera="", number=picture_number, interval_s=0.1)
    none = np.zeros(0, np.uint32)
    robot = FrameRobot(
        robot="rover",
        link=1,
        map=0,
        messages=none,
        diagnostics=none,
        publishers=none,
        pictures=(seen,),
    )
    record = FrameRecord(
        number=number,
        now=100.0 + seconds,
        clock="12:00:00",
        columns=80,
        rows=24,
        arranged=1,
        drawn=True,
        crc32=1,
        display=DisplayState(latency=0.0, frames_per_s=0.0, bytes_per_s=0.0, coarseness=0),
        robots=(robot,),
    )
    return (seconds, "console", RUNE_FRAME, record)


def picture() -> Image:
    return Image(
        camera=camera_state(),
        coding=ImageCoding.RAW,
        width_px=1,
        height_px=1,
        channels=3,
        data=np.zeros(3, np.uint8),
    )


def test_a_session_and_its_metrics_know_the_same_places_of_victims() -> None:
    for here, there in zip(YELLOW.victims_in_map(), YELLOW.victims.tolist(), strict=True):
        assert YELLOW.start.outward(*here) == pytest.approx(there)
