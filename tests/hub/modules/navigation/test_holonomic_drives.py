"""A base that also drives sideways, with a laser: what its pilot lets it do among furniture."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest

from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import GoalCommand, Point, Task
from hub.modules.driver.reports import drive_state
from hub.pose import Pose
from hub.robots.description import RobotDescription
from hub.robots.robot_file import read_description
from hub.sim.arena import load_arena
from tests.hub.modules.navigation.drives import Drive, random_start
from tests.support.repetitions import repetitions

YELLOW = load_arena("yellow")
EMPTY = load_arena("empty")
ROBOT_FILE = """
name = "crab"
kind = "simulated-magellan"
[limits]
sway = 0.4
[[range]]
name = "laser"
kind = "laser"
beams = 360
nearest = 0.1
farthest = 8.0
"""


@pytest.fixture(scope="module")
def crab(tmp_path_factory: pytest.TempPathFactory) -> RobotDescription:
    path: Path = tmp_path_factory.mktemp("crab") / "robot.toml"
    path.write_text(ROBOT_FILE)
    robot, problems = read_description(path)
    assert not problems
    return robot


@pytest.mark.parametrize("seed", range(repetitions(5, 40)))
def test_full_speed_in_any_direction_touches_nothing(crab: RobotDescription, seed: int) -> None:
    drive = Drive(YELLOW, random_start(YELLOW, seed), seed, crab)
    for turn in range(3):
        direction = seed + 2.1 * turn
        drive.push(0.5 * math.cos(direction), 0.0, 3.0, sway=0.4 * math.sin(direction))
        assert drive.truth.contacts == 0


def test_sideways_at_a_wall_it_stands_and_drives_along_and_away(crab: RobotDescription) -> None:
    drive = Drive(EMPTY, Pose(x=0.0, y=8.8), 1, crab)
    drive.push(0.0, 0.0, 6.0, sway=0.4)
    assert drive.truth.contacts == 0
    assert drive.pilot.held_back == 1.0
    assert 9.5 < drive.truth.y < 9.695
    before = drive.truth
    drive.push(0.4, 0.0, 2.0)
    assert drive.truth.x - before.x > 0.3
    drive.push(0.0, 0.0, 1.0, sway=-0.4)
    assert before.y - drive.truth.y > 0.2
    assert drive.truth.contacts == 0


def test_a_measured_slide_towards_a_wall_holds_the_way_along_it_back(
    crab: RobotDescription,
) -> None:
    drive = Drive(EMPTY, Pose(x=0.0, y=9.6), 1, crab)
    drive.push(0.0, 0.0, 0.3)
    sensors = drive.robot.sensors(drive.now)
    given = []
    for slide in (0.0, 0.8):
        moving = dataclasses.replace(sensors, velocity=Twist(linear=Vector3(y=slide)))
        drive.pilot.reported(drive_state(moving, drive.now), drive.now, drive.now)
        given.append(drive.pilot.assisted(Twist.planar(0.2, 0.0), drive.now).linear.x)
    assert given[0] > 0.1
    assert given[1] < 0.5 * given[0]


def test_in_the_open_sideways_motion_is_not_held_back(crab: RobotDescription) -> None:
    drive = Drive(EMPTY, EMPTY.start, 1, crab)
    drive.push(0.4, 0.2, 1.0, sway=-0.3)
    assert drive.pilot.held_back < 0.01
    assert drive.given == Twist(
        linear=Vector3(x=pytest.approx(0.4), y=pytest.approx(-0.3)), angular=Vector3(z=0.2)
    )


def test_motions_that_lead_up_or_tilt_are_passed_on(crab: RobotDescription) -> None:
    drive = Drive(EMPTY, EMPTY.start, 1, crab)
    drive.push(0.0, 0.0, 0.1)
    wanted = Twist(linear=Vector3(z=0.2), angular=Vector3(x=0.1, y=-0.1))
    assert drive.pilot.assisted(wanted, drive.now) == wanted


def test_a_goal_is_reached_with_a_laser_alone(crab: RobotDescription) -> None:
    drive = Drive(YELLOW, Pose(x=5.25, y=5.0, theta=math.pi / 2.0), 1, crab)
    drive.push(0.0, 0.0, 0.1)
    drive.pilot.go(GoalCommand(points=(Point(x=1.6, y=0.0),)), 7, drive.now)
    drive.carry_out(30.0)
    assert drive.pilot.task.state is Task.REACHED
    assert drive.truth.contacts == 0
