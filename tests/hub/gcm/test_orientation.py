"""Rotation matrices, quaternions and angles are the same orientations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.geometry import Quaternion
from hub.gcm.orientation import angles, quaternion, roll_pitch_yaw, rotation

ANGLES = st.tuples(
    st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi)
)


def matrix(w: float, x: float, y: float, z: float) -> np.ndarray:
    """The rotation of a unit quaternion, as textbooks have it."""
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
    )


@given(angles=ANGLES)
def test_quaternion_and_matrix_turn_alike(angles: tuple[float, float, float]) -> None:
    assert matrix(*quaternion(*angles)) == pytest.approx(rotation(*angles), abs=1e-12)


@given(angles=ANGLES)
def test_angles_of_a_quaternion_are_the_same_orientation(
    angles: tuple[float, float, float],
) -> None:
    back = roll_pitch_yaw(*quaternion(*angles))
    assert abs(back[1]) <= math.pi / 2.0
    assert rotation(*back) == pytest.approx(rotation(*angles), abs=2e-6)


UPRIGHT = st.sampled_from((-math.pi / 2.0, math.pi / 2.0))


@given(outer=ANGLES, inner=ANGLES, upright=st.none() | UPRIGHT)
def test_angles_of_a_matrix_are_the_same_orientation(
    outer: tuple[float, float, float], inner: tuple[float, float, float], upright: float | None
) -> None:
    turn = rotation(*outer) @ rotation(*inner)
    if upright is not None:  # on a mast that stands, straight up or down
        turn = rotation(0.0, 0.0, outer[2]) @ rotation(inner[0], upright, inner[2])
    assert rotation(*angles(turn)) == pytest.approx(turn, abs=1e-7)


@given(yaw=st.floats(-3.1, 3.1), pitch=st.sampled_from((-1.0, 1.0)))
def test_a_robot_on_its_nose_or_tail_keeps_its_heading(yaw: float, pitch: float) -> None:
    upright = pitch * math.pi / 2.0
    assert roll_pitch_yaw(*quaternion(0.0, upright, yaw)) == pytest.approx((0.0, upright, yaw))


def test_length_of_a_quaternion_is_of_no_account_and_no_length_is_level() -> None:
    long = tuple(1.0005 * part for part in quaternion(0.1, -0.2, 0.3))
    assert roll_pitch_yaw(*long) == pytest.approx((0.1, -0.2, 0.3))
    assert roll_pitch_yaw(0.0, 0.0, 0.0, 0.0) == (0.0, 0.0, 0.0)


def test_a_message_has_the_orientation_of_its_angles() -> None:
    given = Quaternion.of(0.1, -0.2, 2.5)
    assert (given.w, given.x, given.y, given.z) == quaternion(0.1, -0.2, 2.5)
    assert given.roll_pitch_yaw == pytest.approx((0.1, -0.2, 2.5))
    assert Quaternion().roll_pitch_yaw == (0.0, 0.0, 0.0)
