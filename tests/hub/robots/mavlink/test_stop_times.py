"""Times to stand, against those that were measured on simulated vehicles."""

import math

import pytest

from hub.robots.mavlink.profiles.ardublimp import BLIMP
from hub.robots.mavlink.profiles.arducopter import COPTER
from hub.robots.mavlink.profiles.ardurover import BOAT, ROVER
from hub.robots.mavlink.profiles.ardusub import SUB
from hub.robots.mavlink.profiles.px4 import PX4_COPTER, PX4_ROVER
from hub.robots.mavlink.profiles.stop_times import stop_times
from hub.robots.robot_file import find_robot_file, read_description

NEVER = math.inf
STEERS = {"SERVO1_FUNCTION": 26.0}
QUIET = {"FS_GCS_ENABLE": 0.0, "FS_THR_ENABLE": 0.0}
SAFE_ROVER = {
    "FS_GCS_ENABLE": 1.0,
    "FS_GCS_TIMEOUT": 2.0,
    "FS_THR_ENABLE": 1.0,
    "FS_TIMEOUT": 0.1,
}


@pytest.mark.parametrize(
    ("profile", "parameters", "speed", "measured"),
    [
        (ROVER, {}, 1.0, 1.36),
        (ROVER, {}, 0.53, 0.88),
        (ROVER, STEERS, 1.0, 2.6),
        (SUB, {}, 0.31, 1.81),
        (SUB, {}, 0.26, 2.0),
        (BLIMP, {}, 0.15, 1.86),
        (BLIMP, {}, 0.2, 1.6),
    ],
)
def test_after_zero(profile, parameters, speed, measured):
    zero, _ = profile.stops(parameters, speed, receiver=False)
    assert zero == pytest.approx(measured, rel=0.2)


@pytest.mark.parametrize(
    ("profile", "parameters", "speed", "receiver", "measured"),
    [
        (ROVER, QUIET, 1.0, True, 4.3),
        (ROVER, QUIET, 1.0, False, 4.3),
        (ROVER, {"FS_THR_ENABLE": 1.0, "FS_TIMEOUT": 1.5}, 1.0, False, 3.1),
        (ROVER, {"FS_THR_ENABLE": 1.0, "FS_TIMEOUT": 0.1}, 1.0, False, 1.66),
        (ROVER, {"FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 5.0, "FS_TIMEOUT": 1.5}, 1.0, True, 4.2),
        (ROVER, {"FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 2.0, "FS_TIMEOUT": 0.5}, 1.0, True, 3.6),
        (ROVER, {"FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 1.2, "FS_TIMEOUT": 0.1}, 1.0, True, 2.4),
        (ROVER, SAFE_ROVER, 0.53, False, 1.37),
        (SUB, {"FS_PILOT_INPUT": 2.0, "FS_PILOT_TIMEOUT": 3.0}, 0.5, False, 6.9),
        (SUB, {"FS_PILOT_INPUT": 1.0, "FS_PILOT_TIMEOUT": 0.5}, 0.31, False, 3.2),
        (SUB, {"FS_PILOT_INPUT": 0.0, "FS_GCS_ENABLE": 4.0}, 0.31, False, NEVER),
        (SUB, {"FS_PILOT_INPUT": 0.0, "FS_GCS_ENABLE": 3.0}, 0.31, False, NEVER),
        (SUB, {"FS_PILOT_INPUT": 0.0, "FS_GCS_ENABLE": 0.0}, 0.31, False, NEVER),
        (BLIMP, {"RC_OVERRIDE_TIME": 3.0}, 0.2, True, 4.5),
        (BLIMP, {"RC_OVERRIDE_TIME": 0.5}, 0.2, True, 2.0),
        (BLIMP, {"RC_OVERRIDE_TIME": 0.5, "FS_THR_ENABLE": 1.0}, 0.15, False, 17.6),
        (BLIMP, {"RC_OVERRIDE_TIME": 3.0, "FS_THR_ENABLE": 1.0}, 0.15, False, 20.3),
        (BLIMP, {"RC_OVERRIDE_TIME": 0.5, "FS_THR_ENABLE": 0.0}, 0.15, False, NEVER),
    ],
)
def test_after_a_cut(profile, parameters, speed, receiver, measured):
    _, cut = profile.stops(parameters, speed, receiver=receiver)
    assert cut == pytest.approx(measured, rel=0.2)


def test_a_rover_that_steers_coasts_in_hold():
    _, cut = ROVER.stops(SAFE_ROVER | STEERS, 1.0, receiver=False)
    assert cut > 4.0


def test_what_is_not_known_is_not_said():
    _, cut = SUB.stops({}, 0.3, receiver=False)
    assert math.isnan(cut)
    for profile in (COPTER, PX4_ROVER, PX4_COPTER):
        assert all(map(math.isnan, profile.stops({}, 0.3, receiver=False)))


ALL_SAFE = {
    each.name: each.allowed[0] for profile in (ROVER, SUB, BLIMP) for each in profile.wanted
}


@pytest.mark.parametrize("profile", [ROVER, SUB, BLIMP])
def test_times_are_known_only_where_all_was_read_that_decides(profile):
    robot, _ = read_description(find_robot_file("magellan"))
    read = {**ALL_SAFE, "SERVO1_FUNCTION": 73.0}
    zero, cut = stop_times(profile, read, robot, receiver=False)
    assert 0.0 < zero < cut
    for name in profile.unread({}):
        fewer = {each: value for each, value in read.items() if each != name}
        assert all(map(math.isnan, stop_times(profile, fewer, robot, receiver=False))), name
    both = [stop_times(profile, read, robot, receiver=each) for each in (False, True)]
    longest = tuple(map(max, zip(*both, strict=True)))
    assert stop_times(profile, read, robot, receiver=None) == longest


def test_only_what_was_recorded_is_verified():
    assert {each.name for each in (ROVER, SUB, BLIMP) if each.verified} == {"rover", "sub", "blimp"}
    assert not any(each.verified for each in (BOAT, COPTER, PX4_ROVER, PX4_COPTER))
