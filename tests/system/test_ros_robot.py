"""A hub drives a simulated robot with ROS: what it says of it, and what the robot gets.

The robot's clock is a day behind, and another of its nodes publishes velocities too.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import Twist
from hub.gcm.navigation import DRIVE_STATE, ROBOT_STATE, STOP, MotionState, RobotState, Stop
from hub.gcm.ranges import RANGES
from tests.conftest import leaving_nothing
from tests.support.held_relay import HeldRelay
from tests.support.ros_robot import SimulatedRos
from tests.system.autopilot_site import Operator
from tests.system.driven_ros import ros_tables
from tests.system.harness import HubProcess, Observer

AHEAD = Twist.planar(0.3, 0.0)
OTHER = "/teleop_joy"
RATE = "/diff_drive_controller.publish_rate"
NO_DRIVER_S = 0.5
LATE_S = 0.3
"""How late a busy machine may be [s]."""


class RosSite:
    """A robot, a hub, and an operator who drives: real processes.

    Attributes:
        robot: The robot.
        relay: Between it and the hub.
        observer: What the hub publishes.
        operator: Who drives.
    """

    def __init__(self, folder: Path) -> None:
        with ExitStack() as stack:
            options = ("--arena", "empty", "--clock", "-86400", "--other-publisher", OTHER)
            self.robot = stack.enter_context(closing(SimulatedRos(folder, *options)))
            self.relay = stack.enter_context(closing(HeldRelay(self.robot.port)))
            tables, modules = ros_tables(self.relay.port), ("driver", "navigation")
            hub = HubProcess(folder, kind="ros", modules=modules, tables=tables)
            self.hub = stack.enter_context(closing(hub))
            watched = (ROBOT_STATE, DRIVE_STATE, RANGES, DIAGNOSTICS)
            self.observer = stack.enter_context(closing(Observer(hub.endpoint, *watched)))
            self.operator = Operator(hub.endpoint, "operator")
            stack.callback(self.operator.client.close)
            self.close = stack.pop_all().close

    def newest(self, definition: Any) -> Any:
        return self.observer.seen[definition.name][-1][1]

    def wait(self, condition: Callable[[], object], why: str, timeout: float = 15.0) -> None:
        """Until something is so; the operator goes on meanwhile."""

        def both() -> bool:
            self.operator.client.listen(0.0)
            return bool(condition())

        self.observer.wait(both, timeout, lambda: f"{why} {self.observer.seen}"[:4000])

    @property
    def state(self) -> RobotState:
        state: RobotState = self.newest(ROBOT_STATE)
        return state

    @property
    def problems(self) -> list[str]:
        return [each.message for each in self.newest(DIAGNOSTICS).status]

    def drive(self) -> None:
        """From neutral, until it moves."""
        states = self.observer.seen[ROBOT_STATE.name]
        self.operator.twist = Twist()
        self.wait(
            lambda: states and self.state.motion is MotionState.STANDING, "it is never ready:"
        )
        self.operator.twist = AHEAD
        self.wait(lambda: self.state.motion is MotionState.MOVING, "it does not drive:")
        since = time.monotonic()
        self.wait(lambda: self.moving(since), "nothing reaches it:")

    def moving(self, since: float = 0.0) -> list[dict[str, Any]]:
        """The commands that reached the robot and ask for motion."""
        return [
            each for each in self.robot.commands() if each["at"] >= since and any(each["twist"])
        ]


@pytest.fixture(scope="module", autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """The hub of a test stays for the next one."""
    with leaving_nothing():
        yield


@pytest.fixture(scope="module")
def site(nothing_left_behind: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosSite]:
    del nothing_left_behind
    with closing(RosSite(tmp_path_factory.mktemp("ros"))) as made:
        yield made


def test_commands_have_no_time_of_their_own_and_what_it_measures_is_fresh(site: RosSite) -> None:
    site.drive()
    newest = site.moving()[-1]
    assert newest["counts"]
    assert newest["stamp"] == 0.0  # a clock that differs can neither block nor prolong it
    measured, _ = site.observer.seen[DRIVE_STATE.name][-1]
    assert abs(time.monotonic() - measured) < LATE_S
    assert site.newest(RANGES).scans[0].ranges.size == 60


def test_another_publisher_of_velocities_is_named(site: RosSite) -> None:
    site.wait(lambda: any(OTHER in each for each in site.problems), "it is not named:")


def test_a_stop_calls_the_service_of_the_robot(site: RosSite) -> None:
    site.drive()
    site.operator.client.publish(STOP, Stop())
    site.wait(lambda: any("service" in each for each in site.robot.lines()), "it is not called:")


def test_silent_odometry_is_no_driver_and_no_velocity(site: RosSite) -> None:
    site.drive()
    site.robot.set_parameter(RATE, 0.0)
    ended = time.monotonic()
    site.wait(lambda: site.state.motion is MotionState.NO_DRIVER, "it counts as driven:")
    seen = time.monotonic()
    assert seen - ended < NO_DRIVER_S + LATE_S
    site.wait(lambda: time.monotonic() > seen + 0.5, "time stands still")
    assert site.moving()[-1]["at"] < seen + 0.1
    site.robot.set_parameter(RATE, 50.0)
    site.drive()


def test_a_bridge_that_starts_again_is_driven_from_neutral(site: RosSite) -> None:
    site.drive()
    before = site.newest(DRIVE_STATE).reckoning
    site.robot.start_again()
    again = time.monotonic()
    site.wait(lambda: site.newest(DRIVE_STATE).reckoning != before, "it is not found again:")
    site.wait(lambda: site.operator.sent and time.monotonic() > again + 1.0, "time stands still")
    assert not site.moving(again)
    site.drive()
