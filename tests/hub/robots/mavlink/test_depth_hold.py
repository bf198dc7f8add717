"""A Sub that does not know its place is driven in depth hold, where speeds are thrust."""

import math

import pytest

from hub.robots.mavlink.profiles.profile import Setpoint
from tests.support.mavlink_numbers import DEPTH_HOLD
from tests.support.simulated_radio import RadioDrive


@pytest.mark.parametrize(
    "wanted",
    [
        Setpoint(ahead=0.15),
        Setpoint(ahead=0.3),
        Setpoint(ahead=0.5),
        Setpoint(ahead=-0.3),
        Setpoint(ahead=0.3, left=0.2),
        Setpoint(ahead=-0.2, left=-0.3),
    ],
)
def test_a_sub_in_depth_hold_has_the_speed_that_is_asked_for(wanted):
    drive = RadioDrive("sub", seed=1, depth=5.0).drive()
    drive.vehicle.set_mode("depth hold", drive.now)
    drive.run(3.0)
    assert drive.vehicle.mode == DEPTH_HOLD
    drive.wanted = wanted
    drive.run(8.0)
    state = drive.world.motion.state
    assert state.ahead == pytest.approx(wanted.ahead, rel=0.1)
    assert -state.right == pytest.approx(wanted.left, rel=0.2, abs=0.01)
    assert math.hypot(state.ahead, state.right) <= 1.1 * math.hypot(wanted.ahead, wanted.left)
