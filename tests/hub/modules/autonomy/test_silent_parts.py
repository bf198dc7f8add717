"""The robot stands when parts of it fall silent, and goes on when they are back in time."""

from __future__ import annotations

import math

import pytest

from hub.gcm.autonomy import AutonomyCommand, Behaviour, Phase
from hub.gcm.navigation import Cause, MotionState, Point, Task
from hub.modules.autonomy.autonomy_driver import (
    DATA_TIMEOUT_S,
    JUMP,
    STALL_S,
)
from hub.modules.autonomy.goal_watch import LONGEST_S
from hub.modules.autonomy.senses import MAP_OLD_S, NAVIGATION_OLD_S, STATE_OLD_S
from tests.hub.modules.autonomy.scene import ASKED, STEP, Scene, busy, stands_for_good


@pytest.mark.parametrize("behaviour", ASKED)
def test_it_stands_without_fresh_states_of_the_robot(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.driver_reports = False
    scene.wait(STATE_OLD_S + 2 * STEP)
    assert scene.task is Task.CANCELLED
    assert scene.why == "waits: nothing new is known of the robot"
    scene.wait(DATA_TIMEOUT_S + 1.0)
    assert scene.why == "gave up after 60 s: nothing new is known of the robot"
    assert scene.state.phase is Phase.LOST
    scene.driver_reports = True
    assert stands_for_good(scene)


@pytest.mark.parametrize("behaviour", ASKED)
def test_it_goes_on_when_states_come_back_soon(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.driver_reports = False
    scene.wait(2.0)
    scene.driver_reports = True
    scene.wait(1.0)
    assert scene.task is Task.GOING
    assert scene.state.behaviour is behaviour


@pytest.mark.parametrize("behaviour", ASKED)
def test_it_waits_for_almost_a_minute_and_goes_on(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.driver_reports = False
    scene.wait(DATA_TIMEOUT_S - 5.0)
    assert scene.state.phase is Phase.WAITING
    scene.driver_reports = True
    scene.wait(3.0)
    assert scene.task is Task.GOING
    assert scene.state.phase is Phase.ACTIVE


def test_it_does_not_go_on_from_another_place_than_where_the_robot_fell_silent() -> None:
    scene = busy()
    scene.driver_reports = False
    scene.wait(2.0)
    scene.driver_reports = True
    scene.x += 1.1 * JUMP
    scene.wait(1.0)
    assert scene.state.phase is Phase.LOST
    assert scene.why == "the robot is not where it was before it fell silent"
    assert stands_for_good(scene)


def test_a_navigation_that_is_too_busy_is_waited_for() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.cause, scene.said = Cause.BUSY, "waits: navigation is too busy to steer"
    scene.wait(20.0)
    assert scene.state.phase is Phase.WAITING
    assert scene.why == "waits: navigation is too busy to steer"
    assert len(scene.goals) == 1, "the goal is left where it is"
    scene.cause, scene.said = Cause.NONE, ""
    scene.wait(1.0)
    assert scene.state.phase is Phase.ACTIVE
    assert scene.why.startswith("explores: ")


def test_a_navigation_that_was_too_busy_for_too_long_ends_it() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.said = "gave up after 60 s: navigation is too busy to steer"
    scene.wait(2.0)
    scene.end(Task.CANCELLED, cause=Cause.BUSY)
    scene.act()
    assert scene.state.phase is Phase.LOST
    assert scene.why == "gave up after 60 s: navigation is too busy to steer"


def test_a_goal_that_could_not_be_begun_is_sent_again() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.task_began = scene.now
    scene.end(Task.CANCELLED, cause=Cause.DRIVER)
    scene.act()
    scene.wait(3.0)
    assert scene.state.behaviour is Behaviour.EXPLORE
    assert len(scene.targets) == 2


def test_who_was_away_itself_hears_what_came_before_it_judges() -> None:
    scene = busy()
    scene.now += STALL_S + 2.0
    scene.act()
    assert len(scene.goals) == 1, "nothing was stopped"
    scene.hears()
    scene.wait(1.0)
    assert scene.task is Task.GOING
    assert len(scene.goals) == 1


def test_another_operator_takes_it_over() -> None:
    scene = busy()
    scene.pilot.see_other("eve has control now", scene.now)
    scene.end(Task.CANCELLED, MotionState.WAITING, Cause.CONTROL)
    scene.act()
    assert (scene.state.phase, scene.why) == (Phase.TAKEN_OVER, "eve has control now")
    assert stands_for_good(scene)


def test_it_says_how_far_it_is_and_how_long_it_took() -> None:
    scene = busy()
    scene.distance = 9.0
    scene.tell()
    assert scene.state.phase is Phase.ACTIVE
    assert scene.state.seconds == pytest.approx(3.0)
    assert math.isnan(scene.state.ended_s)
    assert scene.state.distance_m == 9.0


def test_headway_on_a_long_way_is_no_lack_of_it() -> None:
    scene = busy()
    scene.distance = 9.0
    for _ in range(6):
        scene.distance -= 1.0
        scene.wait(LONGEST_S - 10.0)
    assert len(scene.goals) == 1


def test_it_stands_when_navigation_is_gone() -> None:
    scene = busy()
    scene.navigation_lives = False
    scene.wait(NAVIGATION_OLD_S + 2 * STEP)
    assert scene.goals[-1].points == ()
    assert scene.why == "waits: navigation does not answer"


def test_it_goes_on_with_a_navigation_that_has_begun_anew() -> None:
    scene = busy()
    scene.number, scene.task, scene.mine = 0, Task.NONE, False
    scene.wait(1.0)
    assert scene.targets == [(1.5, 0.5)] * 2
    assert scene.task is Task.GOING


def test_it_stands_without_a_driver() -> None:
    scene = busy()
    scene.motion = MotionState.NO_DRIVER
    scene.wait(STEP)
    assert scene.task is Task.CANCELLED
    assert scene.why == "waits: the driver is gone"


@pytest.mark.parametrize("behaviour", [Behaviour.EXPLORE, Behaviour.WANDER])
def test_it_stands_without_a_fresh_map(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.grid = None
    scene.wait(MAP_OLD_S + STEP)
    assert scene.task is Task.CANCELLED
    assert scene.why == "waits: the map is old"


def test_it_says_why_there_is_no_map() -> None:
    scene = Scene()
    scene.grid = None
    scene.ask(Behaviour.EXPLORE)
    scene.pilot.miss_map("nobody answers")
    scene.wait(STEP)
    assert scene.goals == []
    assert scene.why == "waits: no map: nobody answers"


def test_a_map_is_asked_for_only_while_it_is_needed() -> None:
    scene = Scene()
    assert not scene.pilot.wants_map(scene.now)
    scene.ask(Behaviour.GO, (1.0, 0.0))
    assert not scene.pilot.wants_map(scene.now)
    scene.ask(Behaviour.WANDER)
    asked = sum(scene.pilot.wants_map(scene.now + k * STEP) for k in range(100))
    assert 4 <= asked <= 6


@pytest.mark.parametrize("behaviour", ASKED)
def test_a_vehicle_that_does_not_follow_ends_it_for_good(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.pilot.see_other("it is in hold", scene.now, Phase.LOST)
    scene.act()
    assert scene.task is Task.CANCELLED
    assert (scene.state.phase, scene.why) == (Phase.LOST, "it is in hold")
    assert stands_for_good(scene)


@pytest.mark.parametrize("behaviour", ASKED)
def test_what_the_robot_cannot_do_is_refused(behaviour: Behaviour) -> None:
    scene = Scene()
    points = (Point(x=1.0, y=0.0),) if behaviour is Behaviour.GO else ()
    command = AutonomyCommand(behaviour=behaviour, points=points)
    scene.pilot.command(command, scene.now, "it is disarmed: arm it")
    scene.act()
    assert (scene.state.phase, scene.why) == (Phase.REFUSED, "it is disarmed: arm it")
    assert stands_for_good(scene)
