"""Who drives after the driver restarted or control changed, and what limits each motion."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import Freedom, Motion
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import MotionState
from hub.modules.navigation.speed_governor import (
    SpeedGovernor,
)
from tests.hub.modules.navigation.governed import A, B, Scene, driving


def test_driver_that_began_anew_waits_for_neutral_and_so_does_the_operator() -> None:
    scene = Scene()
    scene.command(A, 0.0, 0.0)
    scene.command(A, 0.3, 0.0)
    assert scene.governor.state(scene.now) is MotionState.MOVING
    scene.governor.driver_restarted()
    scene.command(A, 0.3, 0.0)
    assert scene.governor.velocity(scene.now).neutral
    assert scene.governor.state(scene.now) is MotionState.WAITING
    scene.command(A, 0.0, 0.0)
    scene.command(A, 0.3, 0.0)
    assert scene.velocity == (0.3, 0.0)


def test_robot_that_is_handed_over_stands_until_its_new_operator_sends_neutral():
    scene = driving()
    scene.governor.controlled_by(B, A)
    assert scene.velocity == (0.0, 0.0)
    assert scene.state is MotionState.WAITING
    for sender in (A, B):
        scene.hold(sender, 0.3, 0.2)
        assert scene.velocity == (0.0, 0.0)
    scene.command(B, 0.0)
    scene.command(B, 0.3)
    assert scene.velocity == (0.3, 0.0)


def test_who_drives_a_free_robot_drives_on_when_they_get_control():
    scene = driving()
    scene.governor.controlled_by(A, 0)
    assert scene.velocity != (0.0, 0.0)


def test_who_loses_control_is_stopped_and_drives_again_from_neutral_only():
    scene = driving()
    scene.governor.controlled_by(A, 0)
    scene.governor.controlled_by(0, A)
    assert scene.velocity == (0.0, 0.0)
    scene.hold(A, 0.3, 0.2)
    assert scene.velocity == (0.0, 0.0)
    scene.command(A, 0.0)
    scene.command(A, 0.3)
    assert scene.velocity == (0.3, 0.0)


def test_a_task_goes_on_when_its_operator_loses_control():
    scene = Scene()
    assert not scene.governor.begin_task(scene.now)
    scene.governor.controlled_by(0, A)
    assert scene.state is MotionState.GOING


def test_who_drives_a_free_robot_is_stopped_when_somebody_else_gets_control():
    scene = driving()
    scene.governor.controlled_by(B, 0)
    assert scene.velocity == (0.0, 0.0)


@given(
    st.dictionaries(st.sampled_from(list(Freedom)), st.floats(0.1, 3.0)),
    st.tuples(*[st.floats(-9.0, 9.0)] * 6),
)
def test_each_motion_is_limited_and_a_missing_one_is_0(
    limits: dict[Freedom, float], parts: tuple[float, ...]
) -> None:
    twist = Twist(
        linear=Vector3(x=parts[0], y=parts[1], z=parts[2]),
        angular=Vector3(x=parts[3], y=parts[4], z=parts[5]),
    )
    scene = Scene()
    scene.governor = SpeedGovernor(
        [Motion(freedom=each, limit=limit, acceleration=1.0) for each, limit in limits.items()], 0.0
    )
    scene.governor.driver_reported(0.0)
    scene.command(A, 0.0)
    scene.governor.command(A, twist, 0.0, 0.0)
    given_twist = scene.governor.velocity(0.0)
    linear, angular = given_twist.linear, given_twist.angular
    values = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    for freedom, wanted, value in zip(Freedom, parts, values, strict=True):
        limit = limits.get(freedom, 0.0)
        assert value == max(-limit, min(limit, wanted))


def test_any_motion_that_is_no_number_is_refused() -> None:
    scene = driving()
    for linear in (Vector3(y=math.nan), Vector3(z=math.inf)):
        scene.governor.command(A, Twist(linear=linear), scene.now, scene.now)
    scene.governor.command(A, Twist(angular=Vector3(x=math.nan)), scene.now, scene.now)
    assert scene.velocity == (0.4, -0.5)
    assert scene.governor.refused == 3
