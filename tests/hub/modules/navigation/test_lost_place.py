"""The navigation process when the dead reckoning begins anew."""

from __future__ import annotations

import dataclasses
import itertools
import time
from pathlib import Path
from random import Random

import pytest

from hub.gcm.navigation import Cause, DriveState, GoalCommand, Point, Task
from hub.ipc.message_info import MessageInfo
from hub.modules.navigation.__main__ import Navigation
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.extremes_bus import ExtremesBus

OPERATOR, DRIVER, NEXT_DRIVER = 2, 3, 4
AT_ORIGIN = DriveState(reckoning=11)


@pytest.mark.parametrize(("reckoning", "lost"), [(11, False), (12, True)])
def test_a_goal_ends_when_its_frame_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reckoning: int, *, lost: bool
) -> None:
    ticks = itertools.count(100_000)
    monkeypatch.setattr(time, "monotonic", lambda: next(ticks) * 1e-4)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    robot, _ = read_description(find_robot_file("magellan"))
    navigation = Navigation(ExtremesBus(time.monotonic, Random(7)), robot)  # type: ignore[arg-type]

    def heard(sender: int) -> MessageInfo:
        return MessageInfo(sender, 1, 0, 0.0, time.monotonic())

    navigation.reported(AT_ORIGIN, heard(DRIVER))
    goal = GoalCommand(points=(Point(x=3.0, y=0.0),))
    navigation.go(goal, heard(OPERATOR))
    task = navigation.pilot.task
    assert task.active
    # The driver was started again where its wheels counted from: no jump shows it.
    anew = dataclasses.replace(AT_ORIGIN, reckoning=reckoning)
    navigation.reported(anew, heard(NEXT_DRIVER))
    assert task.active is not lost
    if lost:
        assert (task.state, task.cause) == (Task.CANCELLED, Cause.DRIVER)
        assert task.why == "the robot has lost its place"
