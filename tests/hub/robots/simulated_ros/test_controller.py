"""A controller of wheels follows commands by the times in their headers."""

import math

import pytest

from hub.gcm.geometry import Twist
from hub.robots.simulated_ros.controller import TIMEOUT, DiffDriveController

NOW = 1.7e9
AHEAD = Twist.planar(0.4, 0.0)
DAY = 86_400.0


def stops_after(controller, stamp):
    """For how long it follows a command of this stamp [s]; inf: for a day."""
    if not controller.take(AHEAD, stamp, NOW):
        return 0.0
    return next(
        (after for after in (0.0, 0.4, 0.6, 10.4, 10.6) if not moves(controller, after)), math.inf
    )


def moves(controller, after):
    return not controller.velocity(NOW + after).neutral


@pytest.mark.parametrize(
    ("stamp", "seconds"),
    [(0.0, 0.6), (NOW, 0.6), (NOW - 0.6, 0.0), (NOW + 10.0, 10.6), (NOW + DAY, math.inf)],
)
def test_a_command_counts_from_the_time_in_its_header(stamp, seconds):
    assert stops_after(DiffDriveController(TIMEOUT), stamp) == seconds


def test_without_a_timeout_the_last_command_holds():
    assert stops_after(DiffDriveController(0.0), 0.0) == math.inf


def test_after_a_halt_it_waits_for_a_neutral_command():
    controller = DiffDriveController(TIMEOUT)
    controller.take(AHEAD, 0.0, NOW)
    controller.halt()
    assert not moves(controller, 0.0)
    assert not controller.take(AHEAD, 0.0, NOW)
    assert controller.take(Twist(), 0.0, NOW)
    assert controller.take(AHEAD, 0.0, NOW)
    assert moves(controller, 0.0)
