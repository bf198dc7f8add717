"""Navigation leaves goals to the robot's own navigation, and ends them at every doubt."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import (
    DRIVE_COMMAND,
    DRIVE_STATE,
    GOAL_COMMAND,
    NAVIGATION_STATUS,
    STOP,
    TURN_COMMAND,
    VELOCITY_COMMAND,
    Cause,
    GoalCommand,
    LandmarkCorrection,
    Point,
    Stop,
    Task,
    TurnCommand,
)
from hub.gcm.own_navigation import DRIVE_GOAL, OWN_NAVIGATION, DriveGoal, OwnGoal, OwnNavigation
from hub.modules.navigation.__main__ import Navigation
from hub.modules.navigation.own_pilot import REPORT_S, SENT_S
from hub.robots.robot_file import find_robot_file, read_description
from hub.robots.ros_table import RosTable
from tests.hub.modules.navigation.test_lost_place import AT_ORIGIN
from tests.hub.modules.timed_bus import TimedBus
from tests.support.cases import for_each

TICK = 0.05


class Drive:
    """Navigation, and a driver that reports what a test says.

    Attributes:
        report: What the driver reports of the robot's own navigation; None: nothing.
        driver: Whether the driver reports the robot's motion.
    """

    def __init__(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, expected: bool = False
    ) -> None:
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
        self.bus = TimedBus(monkeypatch)
        robot, _ = read_description(find_robot_file("magellan"))
        if expected:
            robot = dataclasses.replace(robot, ros=RosTable(navigation="/navigate_to_pose"))
        self.navigation = Navigation(self.bus, robot)  # type: ignore[arg-type]
        self.report: OwnNavigation | None = OwnNavigation(available=1)
        self.driver = True
        self.run(0.3)

    @property
    def task(self) -> Any:
        return self.navigation.pilot.task

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK)):
            if self.driver:
                self.bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
            if self.report is not None:
                self.bus.send(OWN_NAVIGATION, self.report, "driver")
            self.bus.wait(TICK)

    def go(self, *places: tuple[float, float], theta: float = math.nan) -> DriveGoal | None:
        """An operator sends a goal; returns what the driver gets."""
        points = tuple(Point(x=x, y=y) for x, y in places or ((3.0, 4.0),))
        self.bus.send(GOAL_COMMAND, GoalCommand(points=points, theta=theta), "console")
        return self.goal

    def says(self, state: OwnGoal, **more: Any) -> None:
        """The driver reports this of the newest goal."""
        goal = self.goal
        assert goal is not None
        self.report = OwnNavigation(available=1, number=goal.number, goal=state, **more)
        self.run(2 * TICK)

    def sent(self, definition: Any) -> list[Any]:
        return [value for _, name, value in self.bus.published if name == definition.name]

    @property
    def goal(self) -> DriveGoal | None:
        """What was published last for the driver; None: a velocity, which is zero."""
        names = {DRIVE_GOAL.name, DRIVE_COMMAND.name}
        last = [value for _, name, value in self.bus.published if name in names][-1]
        if isinstance(last, DriveGoal):
            return last
        assert last.neutral
        return None

    def ended(self, state: Task, cause: Cause) -> bool:
        return self.goal is None and (self.task.state, self.task.cause) == (state, cause)


@pytest.fixture
def drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Drive:
    return Drive(tmp_path, monkeypatch)


def test_without_it_rune_drives_to_goals_itself(drive: Drive) -> None:
    for report in (None, OwnNavigation(available=0)):
        drive.report = report
        drive.run(REPORT_S + 0.1)
        drive.go()
        drive.run(1.0)
        assert drive.task.active
        assert not drive.task.by_robot
        assert not drive.sent(DRIVE_GOAL)
        drive.bus.send(GOAL_COMMAND, GoalCommand(), "console")


def test_a_goal_waits_for_the_word_of_the_driver_where_the_robot_file_names_the_action(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = Drive(tmp_path, monkeypatch, expected=True)
    drive.report = None
    drive.run(REPORT_S + 0.1)
    assert drive.go() is None
    assert drive.ended(Task.CANCELLED, Cause.BUSY)
    assert "has not said yet" in drive.task.why
    for available in (0, 1):
        drive.report = OwnNavigation(available=available)
        drive.run(0.1)
        drive.go()
        assert drive.task.by_robot is bool(available)


def test_a_goal_is_repeated_and_no_velocity_is_sent(drive: Drive) -> None:
    goal = drive.go()
    assert goal is not None
    assert (goal.x, goal.y) == (3.0, 4.0)
    assert goal.theta == pytest.approx(math.atan2(4.0, 3.0)), "it comes in this direction"
    drive.says(OwnGoal.DRIVES)
    drive.bus.published.clear()
    drive.run(1.0)
    sent = drive.sent(DRIVE_GOAL)
    assert len(sent) >= 19
    assert set(sent) == {goal}
    assert not drive.sent(DRIVE_COMMAND)
    assert drive.task.distance_left == 5.0
    drive.says(OwnGoal.DRIVES, distance_left=7.5)
    assert drive.task.distance_left == 7.5
    assert drive.task.route is None


def test_each_point_is_a_goal_and_the_last_one_has_the_heading(drive: Drive) -> None:
    first = drive.go((1.0, 0.0), (1.0, 2.0), theta=-1.0)
    drive.says(OwnGoal.REACHED)
    second = drive.goal
    assert first is not None
    assert second is not None
    assert (first.x, first.y, first.theta) == (1.0, 0.0, 0.0)
    assert (second.x, second.y, second.theta) == (1.0, 2.0, -1.0)
    assert first.number != second.number
    drive.says(OwnGoal.REACHED)
    assert drive.ended(Task.REACHED, Cause.NONE)


@for_each(
    ("state", "task", "cause"),
    [
        (OwnGoal.ABORTED, Task.BLOCKED, Cause.CLOSED),
        (OwnGoal.REFUSED, Task.BLOCKED, Cause.CLOSED),
        (OwnGoal.CANCELLED, Task.CANCELLED, Cause.REPLACED),
        (OwnGoal.LOST, Task.CANCELLED, Cause.DRIVER),
    ],
)
def test_a_goal_ends_as_the_robot_says(
    drive: Drive, state: OwnGoal, task: Task, cause: Cause
) -> None:
    drive.go()
    drive.says(OwnGoal.DRIVES)
    drive.says(state, why="the robot says why")
    assert drive.ended(task, cause)
    assert drive.task.why == "the robot says why"
    drive.run(1.0)
    assert drive.goal is None


def test_a_stop_a_stick_a_turn_or_the_operators_word_ends_it_at_once(drive: Drive) -> None:
    ends: dict[Cause, tuple[Any, ...]] = {
        Cause.STOP: ((STOP, Stop(reason="test")),),
        Cause.STICK: (
            (VELOCITY_COMMAND, TwistStamped()),
            (VELOCITY_COMMAND, TwistStamped.planar(0.0001, 0.0)),
            (VELOCITY_COMMAND, TwistStamped()),
        ),
        Cause.WITHDRAWN: ((GOAL_COMMAND, GoalCommand()),),
    }
    for cause, messages in ends.items():
        assert drive.go() is not None
        drive.says(OwnGoal.DRIVES)
        for definition, value in messages:
            drive.bus.send(definition, value, "console")
        assert drive.ended(Task.CANCELLED, cause)
        drive.run(1.0)
        assert drive.goal is None
    assert drive.go() is not None
    drive.bus.send(TURN_COMMAND, TurnCommand(angle=1.0), "console")
    drive.run(0.1)
    assert not isinstance(drive.bus.published[-1][2], DriveGoal)
    assert drive.task.state is Task.TURNING


def test_a_driver_that_falls_silent_ends_it_and_nothing_begins_again(drive: Drive) -> None:
    drive.go()
    drive.says(OwnGoal.DRIVES)
    drive.driver = False
    drive.run(0.6)
    assert drive.ended(Task.CANCELLED, Cause.DRIVER)
    drive.driver = True
    drive.run(2.0)
    assert drive.goal is None
    drive.report = OwnNavigation(available=1)
    drive.go()
    drive.report = None
    drive.run(REPORT_S + 0.2)
    assert drive.ended(Task.CANCELLED, Cause.DRIVER)


def test_a_goal_that_nobody_takes_ends(drive: Drive) -> None:
    drive.go()
    drive.run(REPORT_S + 0.2)
    assert drive.ended(Task.CANCELLED, Cause.DRIVER)
    drive.go()
    drive.says(OwnGoal.SENT)
    drive.run(SENT_S + 0.2)
    assert drive.ended(Task.CANCELLED, Cause.DRIVER)


def test_a_silent_robot_is_said_while_its_goal_goes_on(drive: Drive) -> None:
    drive.go()
    drive.says(OwnGoal.DRIVES, heard_s=2.2)
    assert drive.task.active
    assert drive.task.why == "waits: the robot's own navigation was silent for 2 s"
    drive.says(OwnGoal.DRIVES, heard_s=0.1)
    assert drive.task.why == ""


def test_a_goal_lies_in_odom_where_the_map_was_corrected(drive: Drive) -> None:
    landmark = LandmarkCorrection(x=1.5, y=0.0, seen_x=1.0, seen_y=0.0)
    drive.navigation.pilot.correct(landmark, drive.bus.now)
    odom = drive.navigation.pilot.correction.odom
    assert odom.x > 0.0
    goal = drive.go()
    assert goal is not None
    assert odom.outward(goal.x, goal.y) == pytest.approx((3.0, 4.0))


def test_the_end_of_navigation_ends_it(drive: Drive) -> None:
    assert drive.go() is not None
    drive.navigation.finish()
    assert drive.goal is None


def test_a_reason_that_the_robot_gives_after_its_end_is_passed_on(drive: Drive) -> None:
    drive.go()
    drive.says(OwnGoal.ABORTED, why="it gave up")
    assert drive.ended(Task.BLOCKED, Cause.CLOSED)
    number, ended = drive.task.number, drive.task.ended
    before = len(drive.sent(NAVIGATION_STATUS))
    assert drive.report is not None
    drive.report = dataclasses.replace(drive.report, why="it gave up: no path")
    drive.run(2 * TICK)
    assert (drive.task.number, drive.task.ended) == (number, ended)
    assert drive.sent(NAVIGATION_STATUS)[before].why == "it gave up: no path"
    assert drive.goal is None
    late = drive.report
    drive.go((1.0, 1.0))
    drive.report = late
    drive.run(2 * TICK)
    assert drive.task.active
    assert not drive.task.why
