"""Vehicles whose rules follow documents only: copters, and those with PX4."""

import math

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.profile import Setpoint
from hub.robots.mavlink.profiles.px4 import PX4_COPTER, PX4_ROVER
from hub.robots.mavlink.profiles.table import profile_of
from hub.robots.mavlink.vehicle.reasons import warnings, why
from tests.support.scripted_autopilot import ScriptedAutopilot, moves

QUAD, PX4, HOLD = 2, 12, 0x0304_0000
ON_GROUND, IN_AIR = 1, 2


def flying(mode=4):
    """A copter that a pilot has brought into the air."""
    bench = ScriptedAutopilot(QUAD, mode=mode, armed=True)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.ELSEWHERE)
    bench.tell("EXTENDED_SYS_STATE", landed_state=IN_AIR)
    return bench


def test_a_copter_on_the_ground_is_not_armed_and_not_driven():
    bench = ScriptedAutopilot(QUAD, mode=5)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.DISARMED)
    bench.vehicle.arm(bench.now)
    bench.run(6.0)
    assert bench.commands(400) == bench.commands(176) == []
    bench.armed = True
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.ELSEWHERE)
    bench.tell("EXTENDED_SYS_STATE", landed_state=ON_GROUND)
    bench.vehicle.drive(bench.now)
    bench.run(2.0)
    assert bench.commands(176) == []
    assert why(bench.vehicle, bench.now).startswith("it is on the ground, and Rune does not")


def test_a_copter_in_the_air_follows_velocities_and_on_the_ground_no_longer():
    bench = flying()
    bench.vehicle.drive(bench.now)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.DRIVING)
    bench.velocity()
    bench.velocity(ahead=0.4, left=0.3, up=0.2, turn=0.1)
    sent = bench.sent[-1][1]
    assert [sent[field] for field in ("vx", "vy", "vz", "yaw_rate")] == pytest.approx(
        [0.4, -0.3, -0.2, -0.1]
    )
    bench.tell("EXTENDED_SYS_STATE", landed_state=ON_GROUND)
    bench.run(0.1)
    since = bench.now
    bench.velocity(up=0.5)
    bench.run(2.0)
    assert bench.vehicle.phase is AutopilotPhase.ELSEWHERE
    assert not any(bench.moving(since))
    assert any("never compared" in text for text in warnings(bench.vehicle, bench.now))


def test_px4_modes_are_asked_for_by_main_and_sub_mode():
    bench = ScriptedAutopilot(10, autopilot=PX4, mode=HOLD, armed=True)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.ELSEWHERE)
    bench.vehicle.drive(bench.now)
    bench.until(lambda: bench.commands(176))
    assert bench.commands(176) == [(1.0, 3.0, 0.0)]
    bench.vehicle.set_mode("hold", bench.now)
    bench.run(0.2)
    assert bench.commands(176)[-1] == (1.0, 4.0, 3.0)


@pytest.mark.parametrize(
    ("profile", "parameters", "wanted", "sticks"),
    [
        (
            PX4_ROVER,
            {"RO_SPEED_LIM": 2.0, "RO_YAW_RATE_LIM": 90.0},
            Setpoint(ahead=-0.5, turn=math.radians(45.0)),
            {"z": 375, "y": -500},
        ),
        (
            PX4_COPTER,
            {
                "MPC_VEL_MANUAL": 10.0,
                "MPC_Z_VEL_MAX_UP": 3.0,
                "MPC_Z_VEL_MAX_DN": 1.0,
                "MPC_MAN_Y_MAX": 150.0,
            },
            Setpoint(ahead=1.0, left=2.0, up=-0.5, turn=math.radians(-15.0)),
            {"x": 100, "y": -200, "z": 250, "r": 100},
        ),
        (PX4_ROVER, {}, Setpoint(ahead=1.0, turn=1.0), {"z": 500, "y": 0}),
        (PX4_COPTER, {}, Setpoint(ahead=1.0, up=1.0), {"x": 0, "y": 0, "z": 500, "r": 0}),
    ],
)
def test_px4_gets_sticks_and_none_where_its_limits_are_not_known(
    profile, parameters, wanted, sticks
):
    assert profile.setpoint(wanted, parameters, math.nan) == (("MANUAL_CONTROL", sticks),)


def test_a_vehicle_that_does_not_tell_its_limits_does_not_move_and_says_so():
    bench = ScriptedAutopilot(12)
    del bench.parameters["PILOT_SPEED"]
    bench.driving()
    bench.velocity(ahead=0.3)
    assert not moves(bench.sent[-1][1])
    bench.velocity(turn=0.3)
    assert moves(bench.sent[-1][1])
    assert [*warnings(bench.vehicle, bench.now)] == [
        "it does not tell PILOT_SPEED: it does not move where these are needed"
    ]


@pytest.mark.parametrize(
    ("autopilot", "kind", "name"),
    [(3, 10, "rover"), (3, 11, "boat"), (3, 13, "copter"), (PX4, 11, "boat"), (PX4, 14, "copter")],
)
def test_kinds_by_autopilot_and_type(autopilot, kind, name):
    profile = profile_of(autopilot, kind)
    assert profile.name == name
    assert profile_of(autopilot, 1) is None
    assert all(number in profile.modes for number in (*profile.offered, *profile.drives))
    assert {*profile.alone.values()} <= {*profile.modes}
