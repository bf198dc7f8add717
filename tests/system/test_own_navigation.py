"""A robot's own navigation drives to goals of a hub, and every stop of the hub ends that.

Everything is real but the robot: its bridge, the hub and its modules are processes. The trace of
the robot has the velocities of Rune and the goal of its own navigation.
"""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import Twist
from hub.gcm.navigation import (
    GOAL_COMMAND,
    NAVIGATION_STATUS,
    ROBOT_STATE,
    STOP,
    Cause,
    GoalCommand,
    MotionState,
    Point,
    Stop,
    Task,
)
from hub.gcm.own_navigation import OWN_NAVIGATION
from tests.conftest import leaving_nothing
from tests.support.held_relay import TO_HUB, TO_ROBOT, HeldRelay
from tests.support.ros_robot import SimulatedRos
from tests.system.autopilot_site import Operator
from tests.system.driven_ros import ros_tables
from tests.system.harness import HubProcess, Observer, in_soak

SOON_S = 0.35
"""From an event to the end of the goal at the robot [s]; a killed navigation takes 0.3 s more."""
SILENCE_S = 0.3
LATE_S = 0.5
"""How late a busy machine may be [s]."""
MODULES = ("driver", "navigation")
_MOST_TRIES = 5
"""Goals until one is not ended by a busy machine."""


class NavigatingSite:
    """A robot with navigation of its own, a hub, and somebody who sends goals.

    Attributes:
        robot: The robot.
        relay: Between it and the hub.
        hub: The hub.
        observer: What the hub publishes.
        operator: Who sends goals.
    """

    def __init__(self, folder: Path, *options: str, action: str = "/navigate_to_pose") -> None:
        with ExitStack() as stack:
            made = SimulatedRos(folder, "--arena", "empty", *options)
            self.robot = stack.enter_context(closing(made))
            self.relay = stack.enter_context(closing(HeldRelay(self.robot.port)))
            service = 'stop_service = "/e_stop"\n'
            tables = ros_tables(self.relay.port)
            own = f'navigation = "{action}"\n'
            tables = tables.replace(service, f"{service}{own}")
            self._folder, self._tables = folder, tables
            self.hub = stack.enter_context(closing(self._hub()))
            watched = (ROBOT_STATE, NAVIGATION_STATUS, DIAGNOSTICS, OWN_NAVIGATION)
            self.observer = stack.enter_context(closing(Observer(self.hub.endpoint, *watched)))
            self.operator = Operator(self.hub.endpoint, "operator")
            stack.callback(self.operator.client.close)
            self.close = stack.pop_all().close

    def _hub(self) -> HubProcess:
        return HubProcess(self._folder, kind="ros", modules=MODULES, tables=self._tables)

    def pid(self, module: str) -> int:
        """The process of a module now, by the log of the hub."""
        found = re.findall(rf"{module} started \(pid (\d+)\)", self.hub.log.read_text())
        return int(found[-1])

    def newest(self, definition: Any) -> Any:
        seen = self.observer.seen[definition.name]
        return seen[-1][1] if seen else None

    def wait(self, condition: Callable[[], object], why: str, timeout: float = 20.0) -> None:
        """Until something is so; the operator goes on meanwhile."""

        def both() -> bool:
            self.operator.client.listen(0.0)
            return bool(condition())

        self.observer.wait(both, timeout, lambda: f"{why} {self.newest(NAVIGATION_STATUS)}")

    def goals(self, since: float = 0.0) -> list[tuple[float, str]]:
        """When the robot began and ended goals; the end has no name."""
        found = (each for each in self.robot.lines() if "goal" in each)
        return [(each["at"], each["goal"]) for each in found if each["at"] >= since]

    def velocities(self, since: float) -> list[tuple[float, bool]]:
        """When velocities of Rune reached the robot, and whether they ask for motion."""
        found = self.robot.commands()
        return [(each["at"], any(each["twist"])) for each in found if each["at"] >= since]

    @property
    def task(self) -> tuple[Task, Cause]:
        status = self.newest(NAVIGATION_STATUS)
        return status.task, status.cause

    def go(self, x: float = 8.0) -> float:
        """Send a goal, and wait until the robot drives to it; returns when that began."""
        began = (self._begin(x) for _ in range(_MOST_TRIES))
        found = next((each for each in began if each is not None), None)
        assert found is not None, "the machine is too busy to drive"
        return found

    @property
    def was_busy(self) -> bool:
        """Whether the task ended because a module had no time."""
        return self.task[0] is Task.CANCELLED and self.task[1] in (Cause.BUSY, Cause.DRIVER)

    def _begin(self, x: float) -> float | None:
        """Send a goal once; None: it ended before the robot moved, as the machine was busy."""
        self.operator.twist = Twist()
        asked = time.monotonic()

        def ready() -> bool:
            """By what navigation and driver say from now on: a frozen one may have to end first."""
            seen = [self.observer.seen[each.name] for each in (ROBOT_STATE, OWN_NAVIGATION)]
            if not all(each and each[-1][0] > asked for each in seen):
                return False
            own = self.newest(OWN_NAVIGATION)
            stands = self.newest(ROBOT_STATE).motion is MotionState.STANDING
            return bool(stands and own.available and not own.ending)

        self.wait(ready, "it is never ready:")
        state, since = self.newest(ROBOT_STATE), time.monotonic()
        x = state.x + (x if state.x < 0.0 else -x)  # the arena is wide enough to both sides
        goal = GoalCommand(points=(Point(x=x, y=state.y),))
        refused = -1

        def begun() -> bool:
            """A navigation that has just started may not know the robot's own yet."""
            nonlocal refused
            status = self.newest(NAVIGATION_STATUS)
            if refused < 0 or (status.why.startswith("not begun") and status.number > refused):
                refused = 0 if refused < 0 else status.number
                self.operator.client.publish(GOAL_COMMAND, goal)
            return bool(self.goals(since))

        self.wait(begun, "the robot gets no goal:")
        moves = lambda: abs(self.newest(ROBOT_STATE).linear) > 0.1  # noqa: E731
        self.wait(lambda: moves() or self.was_busy, "it does not move:")
        return None if self.was_busy else self.goals(since)[0][0]

    def ended(self, since: float) -> float:
        """When the robot's goal ended after an event."""
        self.wait(lambda: any(not name for _, name in self.goals(since)), "the goal goes on:")
        return next(at for at, name in self.goals(since) if not name)


@pytest.fixture(scope="module", autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """The hub of a test stays for the next one."""
    with leaving_nothing():
        yield


@pytest.fixture(scope="module")
def site(
    nothing_left_behind: None, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[NavigatingSite]:
    del nothing_left_behind
    with closing(NavigatingSite(tmp_path_factory.mktemp("own"))) as made:
        yield made


def test_it_drives_there_by_itself_and_rune_is_silent_meanwhile(site: NavigatingSite) -> None:
    for _ in range(_MOST_TRIES):
        began = site.go(0.5)
        ended = site.ended(began)
        site.wait(lambda: site.task[0] is not Task.GOING, "the task goes on:")
        if not site.was_busy:
            break
    assert site.task == (Task.REACHED, Cause.NONE)
    sent = [at for at, _ in site.velocities(began + 0.1) if at < ended]
    assert not sent, "Rune sent velocities while the robot drove itself"


def test_a_place_without_a_path_is_given_up_for_the_reason_of_the_robot(
    site: NavigatingSite,
) -> None:
    since = time.monotonic()
    goal = GoalCommand(points=(Point(x=500.0, y=0.0),))
    site.operator.client.publish(GOAL_COMMAND, goal)
    why = "Failed to create a valid plan to the goal (error 208)"
    site.wait(lambda: site.newest(NAVIGATION_STATUS).why.endswith(why), "it says no reason:")
    assert site.task == (Task.BLOCKED, Cause.CLOSED)
    assert not any(moves for _, moves in site.velocities(since))


def test_a_stop_ends_the_goal_at_once_and_zeros_follow(site: NavigatingSite) -> None:
    site.go()
    sent = time.monotonic()
    site.operator.client.publish(STOP, Stop(reason="test"))
    ended = site.ended(sent)
    assert ended - sent < SOON_S + LATE_S
    site.wait(lambda: site.task == (Task.CANCELLED, Cause.STOP), "the task goes on:")
    site.wait(lambda: len(site.velocities(sent)) >= 15, "too few zeros:")
    assert not any(moves for _, moves in site.velocities(sent))
    site.wait(lambda: abs(site.newest(ROBOT_STATE).linear) < 0.01, "it does not stand:")


def test_a_stick_ends_the_goal_and_then_drives(site: NavigatingSite) -> None:
    site.go()
    sent = time.monotonic()
    site.operator.twist = Twist.planar(-0.2, 0.0)
    ended = site.ended(sent)
    assert ended - sent < SOON_S + LATE_S
    site.wait(lambda: site.newest(ROBOT_STATE).linear < -0.1, "it does not follow the stick:")
    moving = [at for at, moves in site.velocities(sent) if moves]
    assert moving[0] >= ended
    assert site.task == (Task.CANCELLED, Cause.STICK)


@pytest.mark.parametrize("how", [signal.SIGKILL, *in_soak(signal.SIGSTOP)])
def test_a_navigation_that_is_killed_or_frozen_ends_the_goal(
    site: NavigatingSite, how: signal.Signals
) -> None:
    site.go()
    sent = time.monotonic()
    os.kill(site.pid("navigation"), how)
    assert site.ended(sent) - sent < SOON_S + SILENCE_S + LATE_S
    site.wait(lambda: site.velocities(sent), "no zero comes:")
    assert not any(moves for _, moves in site.velocities(sent))


@pytest.mark.soak
def test_the_next_driver_ends_the_goal_of_one_that_was_killed(site: NavigatingSite) -> None:
    site.go()
    sent = time.monotonic()
    os.kill(site.pid("driver"), signal.SIGKILL)
    site.ended(sent)
    assert [name for _, name in site.goals(sent)] == [""], "a goal was sent again"


@pytest.mark.soak
def test_a_cut_line_leaves_the_goal_and_the_line_that_is_back_ends_it(
    site: NavigatingSite,
) -> None:
    site.go()
    site.relay.hold(TO_ROBOT, TO_HUB)
    held = time.monotonic()
    site.wait(lambda: site.task[0] is Task.CANCELLED, "the task goes on:")
    assert site.task[1] is Cause.DRIVER
    assert not site.goals(held), "nothing of Rune reaches the robot"
    site.relay.go_on()
    site.ended(held)
    assert [name for _, name in site.goals(held)] == [""], "a goal was sent again"


def test_a_hub_that_is_killed_ends_the_goal(site: NavigatingSite) -> None:
    """The last test of this site."""
    site.go()
    sent = time.monotonic()
    os.kill(site.hub.process.pid, signal.SIGKILL)
    site.operator.twist = None
    assert site.ended(sent) - sent < SOON_S + LATE_S


@pytest.mark.soak
def test_a_hub_that_ends_ends_the_goal_before(tmp_path: Path) -> None:
    with closing(NavigatingSite(tmp_path)) as made:
        made.go()
        sent = time.monotonic()
        made.operator.twist = None
        made.hub.close()
        assert made.ended(sent) - sent < 2.0 + LATE_S
        assert made.velocities(sent), "no zero came"
        assert not any(moves for _, moves in made.velocities(sent))


@pytest.mark.soak
def test_move_base_of_ros_1_is_driven_and_stopped_too(tmp_path: Path) -> None:
    with closing(NavigatingSite(tmp_path, "--ros1", action="/move_base")) as made:
        test_it_drives_there_by_itself_and_rune_is_silent_meanwhile(made)
        test_a_stop_ends_the_goal_at_once_and_zeros_follow(made)
