"""What a vehicle is sent after a doubt: nothing that moves, and at last a neutral velocity."""

import math

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.vehicle.reasons import warnings
from tests.support.mavlink_numbers import BLIMP, ROVER, SUB
from tests.support.scripted_autopilot import ScriptedAutopilot, in_phase, moves

STICKS = {
    ROVER: "SET_POSITION_TARGET_LOCAL_NED",
    SUB: "MANUAL_CONTROL",
    BLIMP: "RC_CHANNELS_OVERRIDE",
}


@pytest.mark.parametrize("kind", STICKS)
@pytest.mark.parametrize("silence", ["mute", "deaf"])
def test_a_vehicle_that_is_gone_gets_neutral_velocities_for_a_short_while_then_nothing(
    kind, silence
):
    """A TCP connection keeps what was sent meanwhile, and delivers it when the link is back."""
    bench = ScriptedAutopilot(kind).driving()
    bench.velocity(ahead=0.15)
    bench.run(0.2)
    setattr(bench, silence, True)
    in_phase(bench, AutopilotPhase.GONE)
    bench.run(3.2)
    sticks = [(at, frame) for at, frame in bench.sent if frame.name == STICKS[kind]]
    assert not moves(sticks[-1][1])
    since = bench.now
    bench.run(3.0)
    assert STICKS[kind] not in bench.names(since)


def test_after_a_pause_of_the_hub_velocities_wait_for_a_neutral_one():
    """The heartbeats that waited on the link look fresh then, and the velocity is old."""
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.run(0.2)
    bench.now += 0.9
    since = bench.now
    bench.heartbeat()
    bench.vehicle.step(bench.now)
    bench.velocity(ahead=0.5)
    bench.run(0.2)
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    assert not any(bench.moving(since))
    bench.velocity()
    bench.velocity(ahead=0.5)
    assert any(bench.moving(since))


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_no_neutral_velocity(odd):
    bench = ScriptedAutopilot().driving()
    bench.vehicle.drive(bench.now)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.DRIVING)
    bench.run(1.0)
    since = bench.now
    bench.velocity(ahead=odd)
    bench.velocity(ahead=0.5)
    bench.run(0.2)
    assert not any(bench.moving(since))


def test_values_of_a_message_that_comes_no_more_are_not_kept():
    bench = ScriptedAutopilot(SUB).driving()
    bench.tell("VFR_HUD", alt=-3.0)
    bench.tell("LOCAL_POSITION_NED", x=1.0, y=2.0, z=3.0, vx=0.4)
    assert bench.vehicle.telemetry.y == 1.0
    bench.silent = {"LOCAL_POSITION_NED"}
    bench.run(1.0)
    assert bench.vehicle.telemetry.y == 1.0
    bench.run(1.0)
    read = bench.vehicle.telemetry
    assert all(map(math.isnan, (read.x, read.y, read.z, read.velocity.linear.x, read.climb)))
    assert "it sends LOCAL_POSITION_NED no more" in "".join(warnings(bench.vehicle, bench.now))
    bench.silent = {"EKF_STATUS_REPORT", "SYS_STATUS"}
    bench.run(5.5)
    assert not read.position
    assert not read.armable
    assert math.isnan(read.depth)
    bench.silent = set()
    bench.run(1.0)
    assert read.position
    assert read.silent == {"VFR_HUD"}


def test_an_attitude_that_comes_no_more_is_not_kept():
    bench = ScriptedAutopilot().driving()
    bench.silent = {"ATTITUDE"}
    bench.run(2.0)
    assert bench.vehicle.phase is AutopilotPhase.LEARNING
    assert math.isnan(bench.vehicle.telemetry.roll)
