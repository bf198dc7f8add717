"""Repeated pictures with new stamps are old once the robot has moved, and new ones never are."""

import dataclasses

import numpy as np
import pytest

from hub.modules.vision.picture_watch import FAR, MOVED, PictureWatch
from hub.modules.vision.travel import HeadTravel, Travel
from tests.support.messages import camera_state, robot_state

RATE = 10.0
SHAPE = (48, 64, 3)
RANDOM = np.random.default_rng(7)
PLACE = np.kron(RANDOM.integers(0, 255, (12, 200, 3)), np.ones((4, 4, 1))).astype(np.int16)
"""A wide scene of blocks, of which a camera sees a part."""


def picture(x=0.0, noise=0.0):
    """What a camera sees at a place [m], with noise [shades]."""
    begin = round(40.0 * x)
    seen = PLACE[:, begin : begin + SHAPE[1]] + RANDOM.normal(0.0, noise, SHAPE)
    return np.clip(seen, 0, 255).astype(np.uint8)


def ages(frames, speed=0.3, stands=0):
    """The ages of pictures [s] while a robot stands for some of them, and drives then [m/s]."""
    watch, found = PictureWatch(), []
    for number, frame in enumerate(frames):
        now = number / RATE
        newness = watch.judge(frame, now, speed * max(0, number - stands) / RATE)
        found.append((now - newness.measured, newness.same_s))
    return np.array(found)


def test_a_repeated_picture_is_as_old_as_the_first_once_the_robot_has_moved():
    found = ages([picture()] * 100, stands=50)
    assert (found[:50, 0] == 0.0).all()
    assert found[49, 1] == pytest.approx(4.9)
    moved = 50 + round(MOVED / 0.3 * RATE) + 1
    assert (found[moved:, 0] == found[moved:, 1]).all()
    assert found[-1, 0] == pytest.approx(9.9)


def test_a_repeated_picture_behind_a_noisy_coder_is_as_old_as_the_motion():
    found = ages([picture(noise=1.5) for _ in range(150)], stands=50)
    moved = 50 + round(FAR / 0.3 * RATE) + 1
    assert (found[: moved - 2, 0] == 0.0).all()
    assert found[-1, 0] == pytest.approx(10.0, abs=0.2)
    assert (found[:, 1] == 0.0).all()


@pytest.mark.parametrize("noise", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("speed", [0.05, 0.3, 1.0])
def test_a_camera_that_lives_is_never_old(noise, speed):
    frames = [picture(speed * max(0, number - 20) / RATE, noise) for number in range(120)]
    assert (ages(frames, speed, stands=20)[:, 0] == 0.0).all()


def test_a_camera_that_lives_before_a_wall_or_in_the_dark_is_not_old():
    frames = [np.clip(RANDOM.normal(20.0, 2.0, SHAPE), 0, 255).astype(np.uint8) for _ in range(90)]
    assert (ages(frames)[:, 0] == 0.0).all()


def test_a_slow_camera_repeats_its_picture_for_a_short_time():
    frames = [picture(0.3 * (number - number % 4) / RATE) for number in range(80)]
    assert ages(frames)[:, 0].max() < 0.5


def test_a_new_picture_ends_it():
    found = ages([*[picture()] * 60, picture(2.0), picture(2.1)])
    assert found[59, 0] > 5.0
    assert (found[60:] == 0.0).all()


def test_motion_is_way_and_turns_of_robot_and_head():
    travel = Travel()
    for number, (linear, angular) in enumerate(((0.4, 0.0), (0.4, 0.0), (0.0, 0.5), (0.01, 0.01))):
        travel.moved(robot_state(linear=linear, angular=angular), number * 0.1)
    assert travel.total == pytest.approx(0.04 + 0.05)
    travel.moved(robot_state(linear=0.4), 9.0)
    assert travel.total == pytest.approx(0.09), "it is not known how it moved meanwhile"
    head = HeadTravel()
    for pan in (0.0, 0.2, 0.1):
        head.moved(dataclasses.replace(camera_state(), pan=pan))
    assert head.total == pytest.approx(0.3)
