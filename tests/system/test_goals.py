"""Goals, turns, assistance and landmarks on a real hub."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack, closing
from typing import Any

import numpy as np
import pytest

from hub.gcm import map_coding, mapping, navigation
from hub.gcm.common import REQUEST_DATA, RequestData
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import Assistance, MotionState, Task
from hub.ipc.definition import MessageDefinition
from hub.pose import Pose
from tests.support.waiting import until
from tests.system.harness import HubProcess, Observer

HUB = {"modules": ("driver", "navigation")}
COMMANDS = (
    navigation.GOAL_COMMAND,
    navigation.TURN_COMMAND,
    navigation.ASSISTANCE_COMMAND,
    navigation.LANDMARK_CORRECTION,
    navigation.VELOCITY_COMMAND,
    navigation.STOP,
)


class Scene:
    """A hub, somebody who commands, and what the robot says."""

    def __init__(self, hub: HubProcess, stack: ExitStack) -> None:
        self.hub = hub
        definitions = navigation.ROBOT_STATE, navigation.NAVIGATION_STATUS, navigation.GROUND_TRUTH
        self.observer = stack.enter_context(closing(Observer(hub.endpoint, *definitions)))
        self.client = self.observer.client
        self.client.define(*COMMANDS)
        self.client.wait_defined(5.0)
        self.client.wait_subscribed(5.0)
        self.tasks_before = self.status.number

    def say(self, definition: MessageDefinition[Any], value: Any) -> None:
        self.client.publish(definition, value)

    def go(self, *places: tuple[float, float]) -> None:
        """Go to places that are given as seen from where the robot is [m]."""
        seen = (self.pose.outward(x, y) for x, y in places)
        points = tuple(navigation.Point(x=x, y=y) for x, y in seen)
        self.say(navigation.GOAL_COMMAND, navigation.GoalCommand(points=points))

    def push(self, linear: float, angular: float = 0.0) -> None:
        """One command of a stick that is held; the neutral one before it comes when it must."""
        if self.state.motion not in (MotionState.MOVING, MotionState.STANDING):
            self.say(navigation.VELOCITY_COMMAND, TwistStamped())
        self.say(navigation.VELOCITY_COMMAND, TwistStamped.planar(linear, angular))
        self.client.listen(0.05)

    @property
    def state(self) -> navigation.RobotState:
        newest: navigation.RobotState = self.observer.seen[navigation.ROBOT_STATE.name][-1][1]
        return newest

    @property
    def pose(self) -> Pose:
        """Where the robot stands in `map`."""
        return Pose(x=self.state.x, y=self.state.y, theta=self.state.theta)

    @property
    def status(self) -> navigation.NavigationStatus:
        history = self.observer.seen[navigation.NAVIGATION_STATUS.name]
        newest: navigation.NavigationStatus = history[-1][1]
        return newest

    def wait_for(self, task: Task, timeout: float = 30.0) -> None:
        self.observer.wait(
            lambda: self.status.task is task and self.status.number > self.tasks_before,
            timeout,
            lambda: f"never {task.name}: {self.status}",
        )


@pytest.fixture
def scene(lasting_hub: HubProcess, stack: ExitStack) -> Scene:
    """The robot stands."""
    scene = Scene(lasting_hub, stack)
    scene.observer.wait(lambda: scene.state.linear == scene.state.angular == 0.0, 10.0)
    return scene


def test_a_goal_and_a_turn_are_carried_out(scene: Scene) -> None:
    goal = scene.pose.outward(1.0, 0.3)
    scene.go((1.0, 0.3))
    scene.observer.wait(lambda: scene.state.motion is MotionState.GOING, 5.0, "it does not go")
    scene.wait_for(Task.REACHED)
    assert math.dist((scene.state.x, scene.state.y), goal) < 0.25
    assert scene.status.sender != 0
    scene.say(navigation.TURN_COMMAND, navigation.TurnCommand(angle=1.0))
    scene.wait_for(Task.TURNING)
    scene.wait_for(Task.REACHED)
    scene.observer.wait(lambda: scene.state.motion is MotionState.STANDING, 5.0)
    assert scene.status.number == scene.tasks_before + 2


@pytest.mark.parametrize("how", ["stop", "no points", "stick"])
def test_anybody_ends_a_goal(scene: Scene, how: str) -> None:
    scene.go((8.0, 0.0))
    scene.observer.wait(lambda: scene.observer.truth.linear > 0.2, 10.0, "it does not go")
    if how == "stop":
        scene.say(navigation.STOP, navigation.Stop(reason="a test"))
    elif how == "no points":
        scene.go()
    else:
        scene.say(navigation.VELOCITY_COMMAND, TwistStamped.planar(0.1, 0.0))
    scene.wait_for(Task.CANCELLED, 5.0)
    assert scene.status.why
    scene.observer.wait(lambda: scene.observer.truth.commanded_linear == 0.0, 5.0, "it goes on")


def test_neutral_commands_of_an_idle_console_do_not_end_a_goal(scene: Scene) -> None:
    scene.go((1.0, 0.0))
    scene.wait_for(Task.GOING)
    while scene.status.task is Task.GOING:
        scene.say(navigation.VELOCITY_COMMAND, TwistStamped())
        scene.client.listen(0.1)
    assert scene.status.task is Task.REACHED


def test_goals_that_are_nowhere_do_not_move_it(scene: Scene) -> None:
    scene.go((math.nan, 0.0))
    scene.go((1.0, math.inf))
    scene.say(navigation.TURN_COMMAND, navigation.TurnCommand(angle=math.nan))
    scene.go((0.5, 0.0))
    scene.wait_for(Task.REACHED)
    assert scene.status.number == scene.tasks_before + 1


def test_a_map_shows_the_way(scene: Scene) -> None:
    resolution, side = 0.05, 200
    cells = np.zeros((side, side), dtype=np.int8)
    cells[60:140, 112:114] = 100  # a wall across the straight way that only the map knows
    here = scene.pose

    def answer(request: mapping.MapRequest) -> mapping.Map:
        del request
        data = map_coding.encode(cells)
        return mapping.Map(
            stamp=0.0,
            resolution=resolution,
            width_cells=side,
            height_cells=side,
            origin_x=here.x - 5.0,
            origin_y=here.y - 5.0,
            data=data,
        )

    scene.client.respond(mapping.MAP_REQUEST, mapping.MAP, answer)
    scene.client.wait_defined(5.0)
    scene.go(here.inward(here.x + 2.0, here.y))
    scene.observer.wait(lambda: len(scene.status.path) > 2, 10.0, "it has no way")
    assert max(abs(point.y - here.y) for point in scene.status.path) > 1.5
    scene.observer.wait(lambda: scene.status.distance_left > 3.0, 5.0, "it goes straight")
    scene.go()
    scene.wait_for(Task.CANCELLED)


def test_assistance_stops_before_a_wall_and_says_so(
    start_hub: Callable[..., HubProcess], stack: ExitStack
) -> None:
    scene = Scene(start_hub(arena="yellow", modules=HUB["modules"]), stack)

    def stopped() -> bool:
        scene.push(0.5)
        return scene.state.held_back == 1.0 and abs(scene.state.linear) < 1e-3

    # From its start it looks along a corridor with a doorway; it has to turn to see a wall.
    before = scene.state.theta

    def turned() -> bool:
        scene.push(0.0, 1.0)
        return scene.state.theta - before > 0.6

    until(turned, 20.0, "it does not turn", meanwhile=lambda: None)
    until(stopped, 30.0, "it does not stop", meanwhile=lambda: None)
    assert scene.observer.truth.contacts == 0
    assert scene.state.assistance is Assistance.ON

    scene.say(
        navigation.ASSISTANCE_COMMAND, navigation.AssistanceCommand(assistance=Assistance.OFF)
    )

    def touched() -> bool:
        scene.push(0.5)
        return bool(scene.observer.truth.contacts)

    until(touched, 20.0, "it is still held back", meanwhile=lambda: None)
    assert scene.state.assistance is Assistance.OFF
    assert "assistance is off" in scene.hub.log.read_text()


def test_a_landmark_moves_the_pose(scene: Scene) -> None:
    seen = Pose(theta=scene.state.theta).outward(2.0, 0.0)
    real = scene.state.x + 3.0 - seen[0], scene.state.y + 1.0 - seen[1]
    scene.say(
        navigation.LANDMARK_CORRECTION,
        navigation.LandmarkCorrection(
            x=scene.state.x + 3.0, y=scene.state.y + 1.0, seen_x=2.0, seen_y=0.0
        ),
    )
    scene.observer.wait(
        lambda: math.dist((scene.state.x, scene.state.y), real) < 0.05, 5.0, "it stays"
    )


def test_the_status_comes_on_request(scene: Scene) -> None:
    scene.client.define(REQUEST_DATA)
    scene.client.wait_defined(5.0)
    history = scene.observer.seen[navigation.NAVIGATION_STATUS.name]

    def asked() -> bool:
        # It comes every half second by itself: one soon after another was asked for.
        before = len(history)
        scene.observer.wait(lambda: len(history) > before, 5.0)
        scene.say(REQUEST_DATA, RequestData(message=navigation.NAVIGATION_STATUS.name))
        scene.client.listen(0.1)
        scene.client.listen(0.1)
        return history[-1][0] - history[before][0] < 0.3 and len(history) > before + 1

    until(asked, 20.0, "it does not come", meanwhile=lambda: None)
