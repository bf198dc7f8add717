"""A vehicle falls silent or is left alone, with a clock of the test's own."""

import math

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from tests.support.mavlink_numbers import (
    ARM,
    BLIMP,
    DEPTH_HOLD,
    GUIDED,
    HOLD,
    INTERVAL,
    MANUAL,
    ROVER,
    SET_MODE,
    SUB,
    SURFACE,
)
from tests.support.scripted_autopilot import ScriptedAutopilot, in_phase, reason


def test_without_heartbeats_it_is_gone_and_only_the_order_to_disarm_is_sent():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.run(1.0)
    bench.mute = True
    in_phase(bench, AutopilotPhase.GONE)
    bench.run(2.0)
    since = bench.now + 0.001
    bench.velocity()
    bench.velocity(ahead=0.5)
    bench.vehicle.drive(bench.now)
    bench.vehicle.set_mode("hold", bench.now)
    bench.vehicle.arm(bench.now)
    bench.run(2.0)
    assert {*bench.names(since)} == {"HEARTBEAT", "TIMESYNC"}
    bench.vehicle.disarm(bench.now)
    bench.run(0.2)
    assert bench.commands(ARM, since) == [(0.0, 0.0, 0.0)]


def test_a_vehicle_that_does_not_hear_is_gone_after_a_second():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.deaf = True
    began = bench.now
    in_phase(bench, AutopilotPhase.GONE)
    assert 0.8 < bench.now - began < 1.4
    assert "does not answer" in reason(bench)


def test_after_silence_it_drives_from_neutral_only():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.deaf = True
    in_phase(bench, AutopilotPhase.GONE)
    since = bench.now + 0.001
    bench.deaf = False
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.DRIVING)
    bench.velocity(ahead=0.5)
    bench.run(1.0)
    assert not any(bench.moving(since))
    bench.velocity()
    bench.velocity(ahead=0.5)
    assert any(bench.moving(since))


def test_an_order_that_was_not_carried_out_ends_with_silence():
    bench = in_phase(ScriptedAutopilot(mode=HOLD, armed=True), AutopilotPhase.ELSEWHERE)
    bench.deaf = True
    bench.vehicle.drive(bench.now)
    in_phase(bench, AutopilotPhase.GONE)
    bench.run(30.0)
    since = bench.now
    bench.deaf = False
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    bench.run(5.0)
    assert bench.commands(SET_MODE, since) == []


def test_a_fast_boot_is_noticed_by_the_time_since_the_start():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.run(0.5)
    streams = len(bench.commands(INTERVAL))
    bench.boot()
    bench.armed, bench.mode = True, GUIDED  # even if no heartbeat ever showed another state
    bench.run(2.0)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.ELSEWHERE)
    assert len(bench.commands(INTERVAL)) >= 2 * streams
    assert reason(bench).endswith("ask it to drive")


@pytest.mark.parametrize("gap", [0.02, 0.06, 0.1, 0.3])
def test_parameters_are_read_again_whenever_the_first_attitude_of_a_boot_comes(gap):
    """What was read between the heartbeat that shows the boot and that frame is forgotten."""
    bench = ScriptedAutopilot()
    in_phase(bench, AutopilotPhase.DISARMED)
    before = set(bench.vehicle.parameters.values)
    bench.status, bench.silent = 2, {"ATTITUDE"}
    bench.boot()
    bench.run(1.4)
    bench.status = 3
    bench.run(gap)
    bench.silent = set()
    in_phase(bench, AutopilotPhase.DISARMED)
    assert set(bench.vehicle.parameters.values) == before != set()


def test_telemetry_that_falls_silent_is_asked_for_again():
    bench = ScriptedAutopilot().driving()
    bench.bare = True
    began = bench.now
    in_phase(bench, AutopilotPhase.LEARNING)
    assert bench.now - began < 1.7
    assert reason(bench) == "its telemetry is silent"
    bench.bare = False
    in_phase(bench, AutopilotPhase.DRIVING)
    assert bench.vehicle.must_be_neutral


def test_a_disarm_order_outlives_learning():
    bench = ScriptedAutopilot().driving()
    bench.bare = True
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.LEARNING)
    bench.vehicle.disarm(bench.now)
    in_phase(bench, AutopilotPhase.DISARMED)
    assert not bench.armed


@pytest.mark.parametrize(
    ("kind", "action", "mode"),
    [
        (ROVER, LeftAlone.STAND, HOLD),
        (SUB, LeftAlone.HOLD_HEIGHT, DEPTH_HOLD),
        (SUB, LeftAlone.SURFACE, SURFACE),
        (BLIMP, LeftAlone.STAND, 3),
    ],
)
def test_left_alone_it_gets_the_mode_of_the_action(kind, action, mode):
    bench = ScriptedAutopilot(kind).driving()
    bench.vehicle.left_alone(action, bench.now)
    bench.until(lambda: bench.mode == mode)
    bench.run(1.0)
    assert bench.vehicle.phase is AutopilotPhase.ELSEWHERE


def test_left_alone_it_brakes_to_rest_before_its_mode_changes():
    bench = ScriptedAutopilot(SUB).driving()
    bench.moves = 0.3
    bench.velocity(ahead=0.3)
    bench.run(1.0)
    bench.vehicle.left_alone(LeftAlone.STAND, bench.now)
    since = bench.now
    bench.velocity()
    bench.velocity(ahead=0.3)  # of a task that goes on
    bench.run(2.0)
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    assert not list(bench.moving(since))
    bench.moves = 0.0
    bench.until(lambda: bench.mode == DEPTH_HOLD, 0.2)


def test_left_alone_a_sub_that_learns_its_place_gets_the_mode_of_the_action_and_no_better_one():
    bench = ScriptedAutopilot(SUB)
    bench.position = False
    bench.driving()
    bench.moves = 0.3
    bench.run(1.0)
    bench.vehicle.left_alone(LeftAlone.SURFACE, bench.now)
    bench.position = True
    since = bench.now
    bench.run(6.0)
    assert bench.commands(SET_MODE, since) == [(1.0, float(SURFACE), 0.0)]


@pytest.mark.parametrize("knows", [True, False])
def test_left_alone_its_mode_changes_also_where_it_drifts_or_its_speed_is_not_known(knows):
    bench = ScriptedAutopilot(SUB).driving()
    bench.moves = 0.3 if knows else math.nan
    bench.run(1.0)
    bench.vehicle.left_alone(LeftAlone.STAND, bench.now)
    bench.until(lambda: bench.mode == DEPTH_HOLD, 4.2 if knows else 0.2)


def test_left_alone_does_not_fight_the_mode_of_another():
    bench = ScriptedAutopilot().driving()
    bench.mode = MANUAL
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    since = bench.now
    bench.vehicle.left_alone(LeftAlone.STAND, bench.now)
    bench.run(5.0)
    assert bench.commands(SET_MODE, since) == []


def test_left_alone_while_gone_it_is_asked_when_it_is_back():
    bench = ScriptedAutopilot(SUB).driving()
    bench.deaf = True
    in_phase(bench, AutopilotPhase.GONE)
    bench.vehicle.left_alone(LeftAlone.SURFACE, bench.now)
    bench.run(5.0)
    bench.deaf = False
    bench.until(lambda: bench.mode == SURFACE)
