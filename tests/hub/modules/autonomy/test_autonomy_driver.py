"""The robot does by itself what it was asked for, and nothing that anybody objects to."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.autonomy import Behaviour, DrivingMode, Phase
from hub.gcm.navigation import Cause, MotionState, Task
from hub.modules.autonomy.autonomy_driver import (
    FARTHEST_POINT,
    MOST_POINTS,
    RELEASE_S,
)
from hub.modules.autonomy.goal_watch import ACCEPTED_S, LONGEST_S, MAX_SENDS
from hub.modules.autonomy.senses import NAVIGATION_OLD_S, STATE_OLD_S
from tests.hub.modules.autonomy.scene import ASKED, STEP, Scene, busy, stands_for_good
from tests.support.cases import for_each


def test_it_does_nothing_unasked() -> None:
    scene = Scene()
    scene.wait(10.0)
    assert scene.goals == []
    assert scene.state.behaviour is Behaviour.HOLD
    assert scene.state.pilot is DrivingMode.NOBODY
    assert scene.why == "there was no command yet"


def test_it_goes_to_a_point_and_then_holds() -> None:
    scene = busy()
    assert scene.targets == [(1.5, 0.5)]
    assert (scene.state.x, scene.state.y) == (1.5, 0.5)
    scene.arrive()
    assert scene.state.behaviour is Behaviour.HOLD
    assert scene.why == "it is there"
    assert scene.state.phase is Phase.DONE
    assert scene.state.asked is Behaviour.GO
    assert math.isnan(scene.state.x)
    took = scene.state.seconds
    assert took == pytest.approx(3.0)
    assert stands_for_good(scene)
    assert scene.state.seconds == took
    assert scene.state.ended_s == pytest.approx(30.0)


def test_it_follows_points_in_one_go() -> None:
    scene = Scene()
    scene.ask(Behaviour.FOLLOW, (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    assert [len(goal.points) for goal in scene.goals] == [3]
    assert scene.why == "follows 3 points"


def test_it_returns_to_where_the_map_begins() -> None:
    assert busy(Behaviour.RETURN).targets == [(0.0, 0.0)]


def test_a_way_that_is_blocked_is_tried_again_from_the_points_that_are_left() -> None:
    scene = Scene()
    scene.ask(Behaviour.FOLLOW, (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    scene.wait(1.0)
    scene.left = 2
    scene.end(Task.BLOCKED)
    scene.act()
    assert len(scene.goals) == 1, "it rests first"
    scene.wait(4.0)
    assert [len(goal.points) for goal in scene.goals] == [3, 2]


def test_a_point_to_which_there_is_no_way_is_given_up() -> None:
    scene = busy()
    for _ in range(10):
        if scene.task is Task.GOING:
            scene.end(Task.BLOCKED)
        scene.wait(3.0)
    assert len(scene.targets) == 3
    assert scene.why == "tried 3 times: so it is"
    assert scene.state.phase is Phase.BLOCKED
    assert stands_for_good(scene)


@pytest.mark.parametrize("behaviour", ASKED)
def test_the_operators_stick_takes_over_at_once(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.driver = 3
    scene.end(Task.CANCELLED, MotionState.MOVING)
    scene.act()
    assert scene.state.behaviour is Behaviour.HOLD
    assert scene.state.pilot is DrivingMode.OPERATOR
    assert scene.why == "the operator took over"
    assert scene.goals[-1].points, "nothing that could disturb the operator was sent"
    scene.driver, scene.motion = 0, MotionState.STANDING
    assert stands_for_good(scene)


def test_a_stick_between_two_goals_takes_over_too() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.end(Task.REACHED, MotionState.MOVING)
    scene.act()
    assert scene.why == "the operator took over"
    scene.motion = MotionState.STANDING
    assert stands_for_good(scene)


def test_a_stick_that_only_navigation_has_seen_takes_over_too() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.driver = 3
    scene.tell()
    scene.act()
    assert scene.why == "the operator took over"


def test_a_stick_that_only_autonomy_has_seen_takes_over_too() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.pilot.see_stick(scene.now)
    scene.act()
    assert scene.why == "the operator took over"
    assert scene.state.phase is Phase.TAKEN_OVER
    assert scene.task is Task.CANCELLED
    assert stands_for_good(scene)


def test_it_does_not_go_on_if_it_may_have_missed_a_stop() -> None:
    scene = busy()
    scene.driver_reports = False
    scene.wait(2.0)
    scene.driver_reports, scene.motion = True, MotionState.STOPPED
    scene.wait(1.0)
    assert scene.why == "the robot was stopped while little was known of it"
    assert stands_for_good(scene)


def test_a_stop_between_two_goals_ends_it_even_if_only_navigation_got_it() -> None:
    scene = busy()
    scene.end(Task.BLOCKED)
    scene.wait(0.5)
    scene.motion = MotionState.STOPPED
    scene.wait(5.0)
    assert scene.why == "stopped: navigation got a stop"
    assert scene.state.phase is Phase.STOPPED
    assert len(scene.targets) == 1
    assert stands_for_good(scene)


@pytest.mark.parametrize("rests", [True, False])
@pytest.mark.parametrize("behaviour", ASKED)
def test_it_ends_when_the_robot_has_lost_its_place(behaviour: Behaviour, *, rests: bool) -> None:
    scene = busy(behaviour)
    scene.frame = 7
    scene.wait(0.5)
    if rests:
        scene.end(Task.BLOCKED)
        scene.act()
    goals = len(scene.targets)
    scene.frame = 8
    scene.wait(5.0)
    assert scene.why == "the robot has lost its place"
    assert scene.state.phase is Phase.LOST
    assert len(scene.targets) == goals
    assert scene.task is not Task.GOING
    assert stands_for_good(scene)


def test_a_robot_that_was_stopped_before_goes_when_it_is_asked() -> None:
    scene = Scene()
    scene.motion = MotionState.STOPPED
    scene.hears()
    scene.ask(Behaviour.GO, (1.0, 0.0))
    assert scene.targets == [(1.0, 0.0)]


def test_a_goal_that_crosses_the_operators_stick_is_taken_back() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.driver = 3
    scene.end(Task.CANCELLED, MotionState.MOVING)
    scene.act()
    # Navigation gets the last goal only now, after the operator has let go again.
    scene.driver = 0
    scene.number += 1
    scene.end(Task.GOING, MotionState.GOING)
    scene.act()
    assert scene.goals[-1].points == ()
    assert scene.task is Task.CANCELLED


def test_who_asks_while_driving_may_let_go_first() -> None:
    scene = Scene()
    scene.motion = MotionState.MOVING
    scene.hears()
    scene.ask(Behaviour.GO, (1.0, 0.0))
    scene.wait(RELEASE_S / 2)
    assert scene.goals == []
    assert scene.why == "waits: the operator still drives"
    scene.motion = MotionState.STANDING
    scene.wait(STEP)
    assert scene.targets == [(1.0, 0.0)]


def test_who_drives_on_after_asking_keeps_the_robot() -> None:
    scene = Scene()
    scene.motion = MotionState.MOVING
    scene.hears()
    scene.ask(Behaviour.GO, (1.0, 0.0))
    scene.wait(RELEASE_S + 0.5)
    assert scene.why == "the operator took over"
    assert scene.goals == []


@for_each("behaviour", ASKED)
def test_a_stop_ends_everything(behaviour: Behaviour) -> None:
    scene = busy(behaviour)
    scene.pilot.see_stop("lunch", scene.now)
    scene.end(Task.CANCELLED, MotionState.STOPPED, Cause.STOP)
    scene.act()
    assert scene.why == "stopped: lunch"
    assert stands_for_good(scene)


def test_a_stop_is_seen_even_if_only_navigation_got_it() -> None:
    scene = busy()
    scene.end(Task.CANCELLED, MotionState.STOPPED, Cause.STOP)
    scene.act()
    assert scene.why == "so it is"
    assert scene.state.phase is Phase.STOPPED
    assert stands_for_good(scene)


def test_asking_to_hold_stops_the_robot() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.ask(Behaviour.HOLD)
    assert scene.task is Task.CANCELLED
    assert scene.why == "asked to hold"
    assert stands_for_good(scene)


def test_a_goal_that_takes_for_ever_counts_as_blocked() -> None:
    scene = busy()
    scene.wait(3 * LONGEST_S + 20.0)
    assert scene.why == "tried 3 times: so it is"
    assert scene.task is Task.CANCELLED


def test_somebody_elses_goal_ends_it() -> None:
    scene = busy()
    scene.number += 1
    scene.mine = False
    scene.tell()
    scene.act()
    assert scene.why == "somebody else sent the robot elsewhere"
    assert scene.task is Task.GOING, "the other goal is left alone"
    assert len(scene.goals) == 1


def test_somebody_elses_goal_while_it_rests_ends_it() -> None:
    scene = busy()
    scene.end(Task.BLOCKED)
    scene.act()
    scene.number += 1
    scene.task, scene.mine = Task.GOING, False
    scene.wait(5.0)
    assert scene.why == "somebody else sent the robot elsewhere"
    assert len(scene.goals) == 1


def test_a_command_replaces_somebody_elses_goal() -> None:
    scene = Scene()
    scene.number, scene.task, scene.motion = 4, Task.GOING, MotionState.GOING
    scene.hears()
    scene.accepts = False
    scene.ask(Behaviour.GO, (1.0, 0.0))
    scene.wait(1.0)
    assert scene.state.behaviour is Behaviour.GO
    assert scene.targets == [(1.0, 0.0)]


def test_a_goal_that_is_not_yet_taken_is_taken_back_too() -> None:
    scene = Scene()
    scene.accepts = False
    scene.ask(Behaviour.GO, (1.0, 0.0))
    scene.ask(Behaviour.HOLD)
    assert [goal.points != () for goal in scene.goals] == [True, False]


def test_a_new_command_replaces_the_old_one() -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.ask(Behaviour.GO, (0.5, 1.0))
    scene.wait(1.0)
    assert scene.targets[-1] == (0.5, 1.0)
    assert scene.state.behaviour is Behaviour.GO


def test_a_goal_that_navigation_does_not_take_is_sent_again_and_then_given_up() -> None:
    scene = Scene()
    scene.accepts = False
    scene.ask(Behaviour.GO, (1.0, 0.0))
    scene.wait(MAX_SENDS * ACCEPTED_S + 2.0)
    assert scene.targets == [(1.0, 0.0)] * MAX_SENDS
    assert scene.why == "navigation does not take the goal"


@pytest.mark.parametrize(
    ("behaviour", "points"),
    [
        (Behaviour.GO, []),
        (Behaviour.GO, [(0.0, 0.0), (1.0, 0.0)]),
        (Behaviour.GO, [(math.nan, 0.0)]),
        (Behaviour.GO, [(0.0, math.inf)]),
        (Behaviour.FOLLOW, []),
        (Behaviour.FOLLOW, [(0.0, 0.0)] * (MOST_POINTS + 1)),
        (Behaviour.FOLLOW, [(0.0, 0.0), (0.0, -1.1 * FARTHEST_POINT)]),
    ],
)
def test_a_command_that_makes_no_sense_stops(
    behaviour: Behaviour, points: list[tuple[float, float]]
) -> None:
    scene = busy(Behaviour.EXPLORE)
    scene.ask(behaviour, *points)
    assert scene.task is Task.CANCELLED
    assert "point" in scene.why
    assert stands_for_good(scene)


def stick(scene: Scene) -> None:
    scene.driver = 3
    if scene.task is Task.GOING:
        scene.task = Task.CANCELLED
    scene.motion = MotionState.MOVING


def let_go(scene: Scene) -> None:
    scene.driver, scene.motion = 0, MotionState.STANDING


def stop(scene: Scene) -> None:
    scene.driver = 0
    scene.pilot.see_stop("", scene.now)
    scene.end(Task.CANCELLED, MotionState.STOPPED)


def ended(task: Task) -> Callable[[Scene], None]:
    def end(scene: Scene) -> None:
        if scene.task is Task.GOING:
            scene.end(task)

    return end


EVENTS: dict[str, Callable[[Scene], object]] = {
    "explore": lambda scene: scene.ask(Behaviour.EXPLORE),
    "go": lambda scene: scene.ask(Behaviour.GO, (1.0, 0.0)),
    "hold": lambda scene: scene.ask(Behaviour.HOLD),
    "stick": stick,
    "let go": let_go,
    "stop": stop,
    "reached": ended(Task.REACHED),
    "blocked": ended(Task.BLOCKED),
    "deaf": lambda scene: setattr(scene, "driver_reports", False),
    "hears": lambda scene: setattr(scene, "driver_reports", True),
    "mute": lambda scene: setattr(scene, "navigation_lives", False),
    "speaks": lambda scene: setattr(scene, "navigation_lives", True),
}


@given(st.lists(st.tuples(st.sampled_from(list(EVENTS)), st.integers(0, 12)), max_size=25))
def test_nothing_is_sent_while_it_holds_or_is_deaf(events: list[tuple[str, int]]) -> None:
    scene = Scene()
    state_at = navigation_at = scene.now
    for event, steps in events:
        EVENTS[event](scene)
        for _ in range(steps):
            before = len(scene.targets)
            held = scene.state.behaviour is Behaviour.HOLD
            scene.wait(STEP)
            state_at = scene.now if scene.driver_reports else state_at
            navigation_at = scene.now if scene.navigation_lives else navigation_at
            assert scene.why
            assert not held or scene.state.behaviour is Behaviour.HOLD
            if len(scene.targets) > before:
                assert not held
                assert scene.now - state_at <= STATE_OLD_S
                assert scene.now - navigation_at <= NAVIGATION_OLD_S
                assert not (scene.driver and scene.navigation_lives)
