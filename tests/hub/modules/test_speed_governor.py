"""The governor stops the robot when in doubt, whatever happens and in whatever order."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import MotionState
from hub.modules.navigation.speed_governor import DRIVER_SILENCE_S, SILENCE_S, SpeedGovernor


def governor() -> SpeedGovernor:
    made = SpeedGovernor(0.5, 1.0, 0.0)
    made.driver_reported(0.0)
    return made


def driving(at: float = 0.0) -> SpeedGovernor:
    made = governor()
    made.command(0.0, 0.0, at, at)
    made.command(0.4, -0.5, at, at)
    return made


def test_does_not_move_before_a_neutral_command_came() -> None:
    made = governor()
    made.command(0.5, 0.0, 0.0, 0.0)
    assert made.velocity(0.0) == (0.0, 0.0)
    assert made.state(0.0) is MotionState.WAITING
    assert made.refused == 1


def test_follows_fresh_commands() -> None:
    made = driving()
    assert made.velocity(0.1) == (0.4, -0.5)
    assert made.state(0.1) is MotionState.MOVING


def test_stops_when_commands_stop_coming() -> None:
    made = driving()
    assert made.velocity(SILENCE_S - 0.001) == (0.4, -0.5)
    assert made.velocity(SILENCE_S) == (0.0, 0.0)
    assert made.state(SILENCE_S) is MotionState.SILENCE


def test_drives_again_after_silence_only_from_neutral() -> None:
    made = driving()
    made.command(0.4, 0.0, 0.5, 0.5)
    assert made.velocity(0.5) == (0.0, 0.0)
    made.command(0.0, 0.0, 0.6, 0.6)
    made.command(0.4, 0.0, 0.7, 0.7)
    assert made.velocity(0.7) == (0.4, 0.0)


def test_drives_again_after_a_stop_only_from_neutral() -> None:
    made = driving()
    made.stop()
    made.command(0.4, 0.0, 0.1, 0.1)
    assert made.velocity(0.1) == (0.0, 0.0)
    assert made.state(0.1) is MotionState.STOPPED


def test_standing_still_is_no_silence() -> None:
    made = governor()
    made.command(0.0, 0.0, 0.0, 0.0)
    assert made.state(0.9) is MotionState.STANDING


def test_refuses_a_command_that_was_queued_somewhere() -> None:
    made = driving()
    made.command(0.2, 0.0, 0.0, 0.35)
    assert made.velocity(0.35) == (0.0, 0.0)


def test_an_old_command_holds_only_for_the_rest_of_its_time() -> None:
    made = driving()
    made.command(0.2, 0.0, 0.05, 0.25)
    assert made.velocity(0.3) == (0.2, 0.0)
    assert made.velocity(0.05 + SILENCE_S) == (0.0, 0.0)


def test_refuses_what_is_no_number() -> None:
    made = driving()
    for value in (math.nan, math.inf, -math.inf):
        made.command(value, 0.0, 0.1, 0.1)
        made.command(0.0, value, 0.1, 0.1)
    assert made.velocity(0.1) == (0.4, -0.5)
    assert made.refused == 6


def test_a_driver_that_comes_back_does_not_find_the_robot_moving() -> None:
    made = driving()
    for step in range(1, 30):
        made.command(0.4, 0.0, step * 0.1, step * 0.1)
    now = DRIVER_SILENCE_S + 2.0
    assert made.state(now) is MotionState.NO_DRIVER
    made.driver_reported(now)
    made.command(0.4, 0.0, now, now)
    assert made.velocity(now) == (0.0, 0.0)


EVENTS = st.lists(
    st.tuples(
        st.sampled_from(["command", "stop", "driver"]),
        st.floats(0.0, 0.5),
        st.sampled_from([0.0, 0.1, -0.3, 0.5, 9.0, -9.0]),
        st.floats(0.0, 0.6),
    ),
    max_size=60,
)


@given(EVENTS)
def test_never_moves_without_a_fresh_command_and_never_too_fast(
    events: list[tuple[str, float, float, float]],
) -> None:
    made = governor()
    now, newest = 0.0, -1.0
    for kind, pause, value, delay in events:
        # Between two events the robot must stop by itself, at whatever moment it is looked at.
        linear, angular = made.velocity(now + pause)
        if now + pause - newest >= SILENCE_S:
            assert (linear, angular) == (0.0, 0.0)
        now += pause
        if kind == "command":
            made.command(value, value, now - delay, now)
            newest = max(newest, now - delay) if delay < SILENCE_S else newest
        elif kind == "stop":
            made.stop()
            assert made.velocity(now) == (0.0, 0.0)
        else:
            made.driver_reported(now)
        linear, angular = made.velocity(now)
        assert abs(linear) <= 0.5
        assert abs(angular) <= 1.0
