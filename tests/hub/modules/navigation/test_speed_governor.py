"""The governor stops the robot when in doubt, whatever happens and in whatever order."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import Cause, MotionState
from hub.modules.navigation.speed_governor import (
    ARMED_S,
    DRIVER_SILENCE_S,
    IGNORE_S,
    SETTLE_S,
    SILENCE_S,
    STALL_S,
)
from tests.hub.modules.navigation.governed import STEP, A, B, Scene, driving, under_way


def test_does_not_move_before_a_neutral_command_came() -> None:
    scene = Scene()
    scene.command(A, 0.5)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.WAITING
    assert scene.governor.refused == 1


def test_follows_fresh_commands() -> None:
    scene = driving()
    scene.wait(0.1)
    assert scene.velocity == (0.4, -0.5)
    assert scene.state is MotionState.MOVING


def test_stops_when_commands_stop_coming() -> None:
    scene = driving()
    scene.wait(SILENCE_S - 0.02)
    assert scene.velocity == (0.4, -0.5)
    scene.wait(0.04)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.SILENCE


def test_says_when_the_wheels_must_stand_next() -> None:
    scene = Scene()
    assert scene.governor.deadline == math.inf
    scene = driving()
    scene.wait(0.1)
    scene.command(A, 0.4, age=0.05)
    assert scene.governor.deadline == pytest.approx(scene.now + SILENCE_S - 0.05)
    scene.driver_lives = False
    silent_at = scene.governor.deadline
    assert not scene.governor.velocity(silent_at - 1e-6).neutral
    assert scene.governor.velocity(silent_at).neutral
    assert scene.governor.state(silent_at) is MotionState.SILENCE
    assert scene.governor.deadline == math.inf


def test_says_when_a_task_must_steer_again() -> None:
    scene = Scene()
    assert not scene.governor.begin_task(scene.now)
    assert scene.governor.deadline == pytest.approx(SILENCE_S)
    scene.wait(SILENCE_S)
    assert scene.governor.held is Cause.BUSY
    assert scene.governor.deadline == math.inf


def test_drives_again_after_silence_only_from_neutral() -> None:
    scene = driving()
    scene.wait(0.5)
    scene.command(A, 0.4)
    assert scene.velocity == (0.0, 0.0)
    scene.command(A, 0.0)
    scene.command(A, 0.4)
    assert scene.velocity == (0.4, 0.0)


def test_drives_again_after_a_stop_only_from_neutral() -> None:
    scene = driving()
    scene.governor.stop()
    scene.command(A, 0.4)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.STOPPED


def test_counts_what_makes_whoever_drives_become_neutral_first() -> None:
    scene = driving()
    counted = [scene.governor.stops]
    for happens in (
        scene.governor.stop,
        scene.governor.driver_restarted,
        lambda: scene.governor.controlled_by(B, A),
        lambda: scene.hold(A, 0.0, 0.2),
        lambda: (scene.command(A, 0.4), scene.wait(0.5)),  # it falls silent
    ):
        happens()
        counted.append(scene.governor.stops - sum(counted))
    assert counted == [0, 1, 1, 1, 0, 1]


def test_neutral_of_another_does_not_undo_a_stop() -> None:
    scene = driving(A)
    scene.governor.stop()
    scene.command(B, 0.0)
    scene.hold(A, 0.4, 1.0)
    assert scene.velocity == (0.0, 0.0)


def test_neutral_of_another_sender_does_not_brake_the_driving_one() -> None:
    scene = driving(A)
    scene.command(B, 0.0)
    assert scene.velocity == (0.4, -0.5)


def test_no_sender_takes_over_from_the_driving_one() -> None:
    scene = driving(A)
    scene.command(B, 0.0)
    scene.command(B, -0.4)
    assert scene.velocity == (0.4, -0.5)
    scene.command(A, 0.0)
    scene.command(B, -0.4)
    assert scene.velocity == (-0.4, 0.0)


def test_a_neutral_command_is_one_s_own() -> None:
    scene = Scene()
    scene.command(A, 0.0)
    scene.command(B, 0.3)
    assert scene.velocity == (0.0, 0.0)


def test_an_old_neutral_command_does_not_count() -> None:
    scene = Scene()
    scene.command(A, 0.0)
    scene.wait(ARMED_S + 0.05)
    scene.command(A, 0.3)
    assert scene.velocity == (0.0, 0.0)


def test_standing_still_is_no_silence() -> None:
    scene = Scene()
    scene.command(A, 0.0)
    scene.wait(0.9)
    assert scene.state is MotionState.STANDING


def test_refuses_a_command_that_was_queued_somewhere() -> None:
    scene = driving()
    scene.wait(0.1)
    scene.command(A, 0.2, age=SILENCE_S)
    assert scene.velocity == (0.4, -0.5)


def test_an_old_command_holds_only_for_the_rest_of_its_time() -> None:
    scene = driving()
    scene.wait(0.25)
    scene.command(A, 0.2, age=0.2)
    assert scene.velocity == (0.2, 0.0)
    scene.wait(0.12)
    assert scene.velocity == (0.0, 0.0)


def test_refuses_what_is_no_number() -> None:
    scene = driving()
    for value in (math.nan, math.inf, -math.inf):
        scene.command(A, value, 0.0)
        scene.command(A, 0.0, value)
    assert scene.velocity == (0.4, -0.5)
    assert scene.governor.refused == 6


def test_a_driver_that_comes_back_does_not_find_the_robot_moving() -> None:
    scene = driving()
    scene.driver_lives = False
    scene.hold(A, 0.4, DRIVER_SILENCE_S + 0.2)
    assert scene.state is MotionState.NO_DRIVER
    scene.driver_lives = True
    scene.hold(A, 0.4, 0.5)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.STOPPED


def test_what_was_queued_while_navigation_itself_was_away_is_not_followed() -> None:
    scene = Scene()
    scene.command(A, 0.0)
    scene.now += STALL_S + 0.5
    scene.governor.driver_reported(scene.now)
    scene.command(B, 0.0)
    scene.command(B, 0.4)
    assert scene.velocity == (0.0, 0.0)
    scene.wait(IGNORE_S + 0.02)
    scene.command(B, 0.0)
    scene.command(B, 0.4)
    assert scene.velocity == (0.4, 0.0)


def test_a_task_drives_without_a_neutral_command() -> None:
    scene = under_way()
    assert scene.velocity == (0.3, 0.2)
    assert scene.state is MotionState.GOING
    scene.governor.steer(9.0, -9.0, scene.now)
    assert scene.velocity == (0.5, -1.0)


def test_a_task_that_falls_silent_stops() -> None:
    scene = under_way()
    scene.wait(SILENCE_S - 0.02)
    assert scene.velocity == (0.3, 0.2)
    scene.wait(0.04)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.GOING
    assert scene.governor.held is Cause.BUSY


def test_a_task_that_was_held_steers_when_all_is_fresh_again() -> None:
    scene = under_way()
    scene.now += STALL_S + 2.0
    assert scene.velocity == (0.0, 0.0)
    assert scene.governor.held is Cause.BUSY
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.0, 0.0), "what it knows is old"
    scene.wait(SETTLE_S + 0.05)
    assert scene.governor.held is Cause.NONE
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.3, 0.2)


def test_a_task_goes_on_with_a_driver_that_comes_back_or_began_anew() -> None:
    scene = under_way()
    scene.driver_lives = False
    for _ in range(100):
        scene.wait(0.05)
        scene.governor.steer(0.3, 0.2, scene.now)
        if scene.state is MotionState.NO_DRIVER:
            assert scene.velocity == (0.0, 0.0)
    assert scene.governor.held is Cause.DRIVER
    assert scene.governor.has_task
    scene.driver_lives = True
    scene.wait(SETTLE_S + 0.05)
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.3, 0.2)
    scene.governor.driver_restarted()
    assert scene.velocity == (0.0, 0.0)
    scene.wait(SETTLE_S + 0.05)
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.3, 0.2)


def test_a_stop_ends_a_task_that_is_held() -> None:
    scene = under_way()
    scene.now += STALL_S + 0.1
    assert scene.governor.held is Cause.BUSY or scene.velocity == (0.0, 0.0)
    scene.governor.stop()
    scene.wait(1.0)
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.0, 0.0)
    assert scene.governor.held is Cause.NONE
    assert scene.state is MotionState.STOPPED


TASK_EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["steer", "stop", "begin", "driver dies", "driver lives", "away"]),
        st.integers(0, 40),
        st.floats(0.0, 0.9),
    ),
    max_size=40,
)


@given(TASK_EVENTS)
def test_a_task_never_moves_without_fresh_steering_and_a_driver(
    events: list[tuple[str, int, float]],
) -> None:
    scene = under_way()
    steered = reported = scene.now
    for kind, steps, away in events:
        if kind == "stop":
            scene.governor.stop()
        elif kind == "begin":
            scene.governor.begin_task(scene.now)
        elif kind == "away":
            scene.now += away
        elif kind == "steer":
            scene.governor.steer(0.3, 0.2, scene.now)
            steered = scene.now
        else:
            scene.driver_lives = kind == "driver lives"
        for _ in range(steps):
            scene.wait(STEP)
            reported = scene.now if scene.driver_lives else reported
            if scene.velocity != (0.0, 0.0):
                assert scene.now - steered <= SILENCE_S + 2.0 * STEP
                assert scene.now - reported <= DRIVER_SILENCE_S + 2.0 * STEP


def test_neutral_commands_do_not_end_a_task_and_others_do() -> None:
    scene = under_way()
    scene.command(A, 0.0)
    assert scene.velocity == (0.3, 0.2)
    scene.command(A, -0.1)
    assert scene.velocity == (-0.1, 0.0)
    assert scene.state is MotionState.MOVING
    scene = under_way()
    scene.command(B, 0.4)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.STANDING


def test_a_stop_ends_a_task_for_good() -> None:
    scene = under_way()
    scene.governor.stop()
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.0, 0.0)


def test_a_task_does_not_begin_while_somebody_drives_or_no_driver_reports() -> None:
    scene = driving()
    assert "drives" in scene.governor.begin_task(scene.now)
    assert scene.velocity == (0.4, -0.5)
    scene = Scene()
    scene.driver_lives = False
    scene.wait(DRIVER_SILENCE_S + 0.1)
    assert "driver" in scene.governor.begin_task(scene.now)


def test_when_a_task_has_ended_it_steers_no_more() -> None:
    scene = under_way()
    scene.governor.end_task()
    scene.governor.steer(0.3, 0.2, scene.now)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.STANDING


EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["command", "stop", "driver dies", "driver lives", "away"]),
        st.integers(0, 50),
        st.sampled_from([A, B]),
        st.sampled_from([0.0, 0.1, -0.3, 0.5, 9.0, -9.0]),
        st.floats(0.0, 0.6),
    ),
    max_size=60,
)


@given(EVENTS)
def test_never_moves_without_a_fresh_command_and_never_too_fast(
    events: list[tuple[str, int, int, float, float]],
) -> None:
    scene = Scene()
    newest = -1.0
    for kind, steps, sender, value, age in events:
        for _ in range(steps):
            scene.wait(STEP)
            if scene.now - newest > SILENCE_S + 1e-9:
                assert scene.velocity == (0.0, 0.0)
        if kind == "command":
            scene.command(sender, value, value, age)
            newest = max(newest, scene.now - age)
        elif kind == "stop":
            scene.governor.stop()
            assert scene.velocity == (0.0, 0.0)
        elif kind == "away":
            scene.now += age
        else:
            scene.driver_lives = kind == "driver lives"
        linear, angular = scene.velocity
        assert abs(linear) <= 0.5
        assert abs(angular) <= 1.0
