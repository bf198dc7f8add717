"""The simulated robot's own navigation drives its wheels to goals, by the rules of Nav2."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.gcm.geometry import Twist
from hub.robots.simulated_ros.own_navigation import PERIOD
from hub.robots.simulated_ros.robot import SimulatedRosRobot
from hub.ros.goal_messages import CancelAnswer, GoalPlace, GoalStatus

FIRST, SECOND = "01" * 16, "02" * 16


class Wheels:
    """A robot in an arena with its own navigation, and the time."""

    def __init__(self, arena: str = "empty", *, old: bool = False) -> None:
        self.robot = SimulatedRosRobot(arena, timeout=0.5)
        self.now = 1e9
        self.robot.advance(0.01, self.now)
        self.navigation = self.robot.navigation(old=old)
        self.start = self.robot.pose
        self.velocities: list[Twist | None] = []

    def go(self, ahead: float, left: float = 0.0, name: str = FIRST, frame: str = "map") -> bool:
        x, y = self.start.outward(ahead, left)
        return self.navigation.begin(name, GoalPlace(frame=frame, x=x, y=y, theta=1.0))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD)):
            velocity = self.navigation.velocity(self.robot.pose, self.robot.odom, PERIOD)
            self.velocities.append(velocity)
            if velocity is not None:
                self.robot.controller.take(velocity, 0.0, self.now)
            for _ in range(5):
                self.now += PERIOD / 5
                self.robot.advance(PERIOD / 5, self.now)

    def state(self, name: str = FIRST) -> GoalStatus:
        return next(each.status for each in self.navigation.goals if each.name == name)

    def failure(self) -> tuple[int, str] | None:
        found = self.navigation.end_of(FIRST)
        return (found[1].code, found[1].text) if found is not None else None


@pytest.mark.parametrize("frame", ["map", "odom"])
def test_it_drives_there_turns_and_stands(frame: str) -> None:
    wheels = Wheels()
    assert wheels.go(1.0, 0.5, frame=frame) or frame == "odom"
    if frame == "odom":
        x, y = wheels.robot.odom.inward(*wheels.start.outward(1.0, 0.5))
        place = GoalPlace(frame="odom", x=x, y=y, theta=1.0 - wheels.robot.odom.theta)
        assert wheels.navigation.begin(FIRST, place)
    wheels.run(2.0)
    assert wheels.state() is GoalStatus.DRIVES
    assert 0.0 < wheels.navigation.left < 1.2
    wheels.run(15.0)
    assert wheels.state() is GoalStatus.REACHED
    here = wheels.robot.pose
    assert math.dist(wheels.start.outward(1.0, 0.5), (here.x, here.y)) < 0.15
    assert abs(here.theta - 1.0) < 0.15
    assert wheels.velocities[-1] is None
    assert wheels.robot.motion == pytest.approx((0.0, 0.0), abs=1e-3)


def test_a_cancel_stops_it_with_one_zero() -> None:
    wheels = Wheels()
    wheels.go(2.0)
    wheels.run(2.0)
    assert wheels.navigation.cancel(SECOND) is CancelAnswer.UNKNOWN
    assert wheels.navigation.cancel(FIRST) is CancelAnswer.BEGINS
    assert wheels.state() is GoalStatus.CANCELLED
    wheels.velocities.clear()
    wheels.run(1.0)
    assert wheels.velocities[0] == Twist()
    assert set(wheels.velocities[1:]) == {None}
    assert wheels.navigation.cancel(FIRST) is CancelAnswer.ENDED
    assert wheels.navigation.cancel("") is CancelAnswer.BEGINS


def test_a_place_without_a_way_is_aborted_and_one_in_no_frame_refused() -> None:
    wheels = Wheels("yellow")
    wheels.go(500.0)
    wheels.run(0.1)
    assert wheels.state() is GoalStatus.ABORTED
    assert wheels.failure() == (208, "Failed to create a valid plan to the goal")
    assert not wheels.go(1.0, name=SECOND, frame="base_link")
    assert not wheels.go(math.nan, name=SECOND)
    assert len(wheels.navigation.goals) == 1


def test_without_headway_it_gives_up() -> None:
    wheels = Wheels()
    wheels.go(2.0)
    for _ in range(round(7.0 / PERIOD)):
        wheels.navigation.velocity(wheels.start, wheels.robot.odom, PERIOD)
    assert wheels.state() is GoalStatus.DRIVES
    assert wheels.failure() is None
    for _ in range(round(2.0 / PERIOD)):
        wheels.navigation.velocity(wheels.start, wheels.robot.odom, PERIOD)
    assert wheels.state() is GoalStatus.ABORTED
    assert wheels.failure() == (105, "Failed to make progress")


@pytest.mark.parametrize(
    ("old", "end"), [(False, GoalStatus.ABORTED), (True, GoalStatus.CANCELLED)]
)
def test_another_goal_takes_the_place_of_the_first(old: bool, end: GoalStatus) -> None:  # noqa: FBT001
    wheels = Wheels(old=old)
    wheels.go(1.0)
    wheels.go(2.0, name=SECOND)
    assert (wheels.state(), wheels.state(SECOND)) == (end, GoalStatus.DRIVES)


def test_it_keeps_away_from_walls() -> None:
    """In the yellow arena, round a corner."""
    wheels = Wheels("yellow")
    grid = wheels.robot.message("/map")
    rows, columns = np.nonzero(grid["data"] == 100)
    edge, origin = grid["info"]["resolution"], grid["info"]["origin"].position
    x, y = origin.x + (columns + 0.5) * edge, origin.y + (rows + 0.5) * edge
    wheels.navigation.begin(FIRST, GoalPlace(frame="map", x=4.3, y=0.9, theta=0.0))
    nearest = math.inf
    while wheels.state() is GoalStatus.DRIVES:
        wheels.run(0.2)
        here = wheels.robot.pose
        nearest = min(nearest, float(np.hypot(x - here.x, y - here.y).min()))
    assert wheels.state() is GoalStatus.REACHED
    assert nearest - edge / 2.0 > 0.18
