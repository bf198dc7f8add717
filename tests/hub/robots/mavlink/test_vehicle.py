"""The vehicle's phases, row by row, with a clock of the test's own."""

import math

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from tests.support.scripted_autopilot import (
    BLIMP,
    ROVER,
    SUB,
    ScriptedAutopilot,
    in_phase,
    moves,
    reason,
)

GUIDED, HOLD, MANUAL = 15, 4, 0
DEPTH_HOLD, POSITION_HOLD, SURFACE = 2, 16, 9
SET_MODE, ARM, INTERVAL = 176, 400, 511


# Linking and learning.


def test_only_a_heartbeat_of_an_autopilot_links():
    bench = ScriptedAutopilot()
    bench.mute = True
    bench.run(1.5)
    assert bench.names() == ["HEARTBEAT", "HEARTBEAT"]
    assert reason(bench) == "no heartbeat came yet"
    for kind, autopilot, component in ((6, 8, 1), (26, 8, 154), (30, 3, 1), (10, 3, 191)):
        bench.tell("HEARTBEAT", component=component, type=kind, autopilot=autopilot)
        assert bench.vehicle.phase is AutopilotPhase.LINKING
    bench.heartbeat()
    assert bench.vehicle.phase is AutopilotPhase.LEARNING


def test_streams_and_parameters_are_asked_for_and_then_it_is_disarmed():
    bench = in_phase(ScriptedAutopilot(SUB), AutopilotPhase.DISARMED)
    assert len(bench.commands(INTERVAL)) == len(bench.vehicle.profile.rates)
    assert bench.vehicle.parameters.values["PILOT_SPEED"] == 50.0
    bench.run(3.0)
    assert bench.vehicle.phase is AutopilotPhase.DISARMED


def test_without_answers_learning_ends_after_four_seconds():
    bench = ScriptedAutopilot()
    bench.refused = {(INTERVAL, number, rate): 2 for number in (30.0,) for rate in (50000.0,)}
    bench.parameters.clear()
    began = bench.now
    in_phase(bench, AutopilotPhase.DISARMED)
    assert 1.0 < bench.now - began < 4.2


def test_a_vehicle_that_starts_is_learnt_until_it_has_started():
    bench = ScriptedAutopilot(status=2, mode=16)
    bench.run(8.0)
    assert bench.vehicle.phase is AutopilotPhase.LEARNING
    assert reason(bench) == "it starts"
    bench.vehicle.set_mode("hold", bench.now)
    bench.run(1.0)
    assert bench.commands(SET_MODE) == []
    bench.status = 3
    in_phase(bench, AutopilotPhase.DISARMED)


# Arming.


def test_nothing_arms_or_changes_the_mode_unasked():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.velocity()
    bench.velocity(ahead=1.0)
    bench.vehicle.drive(bench.now)
    bench.run(20.0)
    assert bench.commands(ARM) == bench.commands(SET_MODE) == []
    assert not any(moves(frame) for _, frame in bench.sent)


@pytest.mark.parametrize(("kind", "mode"), [(ROVER, GUIDED), (SUB, POSITION_HOLD), (BLIMP, 2)])
def test_arming_asks_for_the_driving_mode_and_then_once_to_arm(kind, mode):
    bench = in_phase(ScriptedAutopilot(kind, mode=1), AutopilotPhase.DISARMED)
    bench.vehicle.arm(bench.now)
    assert bench.vehicle.phase is AutopilotPhase.ARMING
    in_phase(bench, AutopilotPhase.DRIVING)
    assert bench.commands(SET_MODE) == [(1.0, mode, 0.0)]
    assert bench.commands(ARM) == [(1.0, 0.0, 0.0)]
    assert reason(bench) == "release the stick first"


def test_a_refusal_to_arm_is_told_with_the_vehicles_reasons():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.refused[(ARM, 1.0, 0.0)] = 4
    bench.texts = ["Arm: Gyros inconsistent", "Arm: Radio failsafe on"]
    bench.vehicle.arm(bench.now)
    bench.until(lambda: bench.commands(ARM))
    bench.tell("STATUSTEXT", severity=6, text="EKF3 IMU0 is using GPS")
    in_phase(bench, AutopilotPhase.DISARMED)
    bench.run(0.2)
    bench.tell("STATUSTEXT", severity=2, text="Arm: Compass not healthy")
    assert reason(bench) == (
        "to arm was refused: Arm: Gyros inconsistent; Arm: Radio failsafe on; "
        "Arm: Compass not healthy"
    )
    bench.run(10.0)
    assert len(bench.commands(ARM)) == 1
    assert bench.vehicle.phase is AutopilotPhase.DISARMED


def test_arming_ends_without_an_answer():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.forgets = 99
    bench.vehicle.arm(bench.now)
    began = bench.now
    in_phase(bench, AutopilotPhase.DISARMED)
    assert bench.now - began == pytest.approx(5.0, abs=0.1)
    bench.forgets = 0
    bench.mode = GUIDED
    bench.run(5.0)
    assert bench.commands(ARM) == []


def test_a_sub_without_a_place_is_armed_in_depth_hold():
    bench = ScriptedAutopilot(SUB, mode=19)
    bench.position = False
    bench.driving()
    assert bench.mode == DEPTH_HOLD
    assert bench.commands(SET_MODE) == [(1.0, DEPTH_HOLD, 0.0)]


def test_a_mode_that_is_refused_is_replaced_by_the_next_one():
    bench = ScriptedAutopilot(SUB, mode=19)
    bench.refused[(ARM, 1.0, 0.0)] = 0
    bench.refused[(SET_MODE, 1.0, POSITION_HOLD)] = 4
    bench.driving()
    assert bench.mode == DEPTH_HOLD


def test_a_mode_that_was_accepted_and_forgotten_is_asked_for_again():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.forgets = 1
    bench.driving()
    assert len(bench.commands(SET_MODE)) == 2
    assert len(bench.commands(ARM)) == 1


def test_the_reasons_against_arming_are_bounded():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.bare = True  # nothing says that it can be armed
    bench.tell("SYS_STATUS")
    assert reason(bench) == "it is disarmed, and not ready to be armed"
    for number in range(40):
        bench.tell("STATUSTEXT", severity=2, text=f"PreArm: {number} " + "\x1b" * 40)
        bench.run(0.1)
    assert "PreArm: 3 \\x1b" in reason(bench)
    assert len(reason(bench)) == 900


# Driving.


@pytest.mark.parametrize("kind", [ROVER, SUB, BLIMP])
def test_a_velocity_needs_a_neutral_one_after_each_entry(kind):
    bench = ScriptedAutopilot(kind).driving()
    bench.velocity(ahead=0.2)
    bench.run(0.5)
    assert any(bench.moving())
    entered = bench.now
    bench.mode = HOLD if kind == ROVER else 0
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    bench.velocity(ahead=0.2)
    bench.vehicle.drive(bench.now)
    in_phase(bench, AutopilotPhase.DRIVING)
    bench.velocity(ahead=0.2)
    bench.run(1.0)
    assert reason(bench) == "release the stick first"
    assert not any(bench.moving(entered + 0.1))
    bench.velocity()
    bench.velocity(ahead=0.2)
    bench.run(0.2)
    assert any(bench.moving(entered + 0.1))
    assert reason(bench) == ""


def test_a_new_velocity_leaves_at_once_and_an_old_one_at_20_hz():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    assert moves(bench.sent[-1][1])
    before = len(bench.sent)
    bench.velocity(ahead=0.5)
    assert len(bench.sent) == before
    began = bench.now
    bench.run(2.0)
    assert 30 <= len(list(bench.moving(began + 0.001))) <= 41


def test_a_velocity_is_limited_and_what_is_no_number_is_zero():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=9.0, turn=-9.0)
    assert (bench.vehicle.velocity.ahead, bench.vehicle.velocity.turn) == (1.0, -1.0)
    bench.velocity(ahead=math.nan, turn=math.inf)
    assert bench.vehicle.velocity.neutral


@pytest.mark.parametrize("mode", [MANUAL, HOLD, 10])
def test_nothing_that_moves_is_sent_in_the_mode_of_another(mode):
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.run(0.5)
    bench.mode = mode
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    since = bench.now + 0.001
    bench.velocity(ahead=0.5)
    bench.run(5.0)
    assert not {"MANUAL_CONTROL", "SET_POSITION_TARGET_LOCAL_NED"} & {*bench.names(since)}
    assert bench.commands(SET_MODE, since) == []
    assert "not asked for here" in reason(bench)
    bench.mode = GUIDED  # another station sets it again: that is no order of the operator here
    bench.run(2.0)
    bench.velocity()
    bench.velocity(ahead=0.5)
    bench.run(1.0)
    assert bench.vehicle.phase is AutopilotPhase.ELSEWHERE
    assert not any(bench.moving(since))


def test_an_armed_vehicle_in_the_driving_mode_of_another_is_not_driven():
    bench = in_phase(ScriptedAutopilot(mode=GUIDED, armed=True), AutopilotPhase.ELSEWHERE)
    bench.velocity()
    bench.velocity(ahead=0.5)
    bench.run(2.0)
    assert not any(bench.moving())
    bench.vehicle.drive(bench.now)
    in_phase(bench, AutopilotPhase.DRIVING)


def test_neutral_sticks_come_before_the_driving_mode():
    bench = in_phase(ScriptedAutopilot(mode=HOLD, armed=True), AutopilotPhase.ELSEWHERE)
    bench.run(1.0)
    began = bench.now
    bench.vehicle.drive(began)
    bench.until(lambda: bench.commands(SET_MODE))
    assert bench.now - began == pytest.approx(0.4, abs=0.05)
    assert bench.names(began + 0.001).count("MANUAL_CONTROL") >= 3


def test_a_mode_asked_for_here_gets_neutral_sticks_and_is_not_driven():
    bench = ScriptedAutopilot().driving()
    bench.vehicle.set_mode("hold", bench.now)
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    bench.until(lambda: bench.mode == HOLD)
    since = bench.now
    bench.velocity(ahead=0.5)
    bench.run(3.0)
    assert "MANUAL_CONTROL" in bench.names(since)
    assert not any(bench.moving(since))
    assert "asked for here" in reason(bench)


@pytest.mark.parametrize("place", [True, False])
def test_a_sub_that_is_asked_to_stay_is_not_driven_until_it_is_asked_to_follow(place):
    bench = ScriptedAutopilot(SUB)
    bench.position = place
    bench.driving()
    bench.velocity(ahead=0.2)
    bench.vehicle.stay(bench.now)
    assert not moves(bench.sent[-1][1])
    since = bench.now + 0.001
    bench.until(lambda: bench.mode == DEPTH_HOLD)
    for _ in range(20):
        bench.velocity()
        bench.velocity(ahead=0.2)
        bench.run(0.2)
    assert bench.vehicle.phase is AutopilotPhase.ELSEWHERE
    assert "MANUAL_CONTROL" in bench.names(bench.now - 0.5), "its sticks stay neutral"
    assert not any(bench.moving(since))
    assert reason(bench) == "it is in depth hold, asked for here: ask it to drive"
    bench.vehicle.drive(bench.now)
    in_phase(bench, AutopilotPhase.DRIVING)
    bench.velocity()
    bench.velocity(ahead=0.2)
    assert any(bench.moving(since))


def test_a_sub_is_driven_in_depth_hold_where_that_mode_is_asked_for_by_name():
    bench = ScriptedAutopilot(SUB).driving()
    bench.vehicle.set_mode("depth hold", bench.now)
    bench.until(lambda: bench.mode == DEPTH_HOLD)
    in_phase(bench, AutopilotPhase.DRIVING)


def test_a_refused_mode_keeps_the_sticks_of_the_mode_before_and_says_why():
    bench = ScriptedAutopilot(SUB).driving()
    bench.refused[(SET_MODE, 1.0, SURFACE)] = 4
    bench.texts = ["Mode change failed: SURFACE requires depth"]
    bench.vehicle.set_mode("surface", bench.now)
    bench.run(1.0)
    since = bench.now
    bench.run(1.0)
    assert bench.vehicle.phase is AutopilotPhase.ELSEWHERE
    assert "MANUAL_CONTROL" in bench.names(since)
    assert "requires depth" in reason(bench)
    assert "ask it to drive" in reason(bench)


@pytest.mark.parametrize("order", ["hold", "disarm"])
def test_an_order_ends_the_motion_at_once(order):
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    if order == "disarm":
        bench.vehicle.disarm(bench.now)
    else:
        bench.vehicle.set_mode(order, bench.now)
    assert not moves(bench.sent[-1][1])
    bench.velocity()
    bench.velocity(ahead=0.5)
    assert not moves(bench.sent[-1][1])


def test_a_mode_that_is_not_offered_is_not_asked_for():
    bench = ScriptedAutopilot().driving()
    since = bench.now
    for name in ("circle", "no such mode", ""):
        bench.vehicle.set_mode(name, bench.now)
    bench.run(1.0)
    assert bench.commands(SET_MODE, since) == []


def test_disarming_comes_before_all_and_is_repeated_until_a_heartbeat_shows_it():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.vehicle.drive(bench.now)
    bench.deaf = True
    bench.vehicle.disarm(bench.now)
    bench.run(0.1)
    assert bench.commands(ARM)[-1] == (0.0, 0.0, 0.0)
    assert bench.commands(SET_MODE) == [(1.0, GUIDED, 0.0)]
    bench.tell("COMMAND_ACK", command=ARM, result=0, target_system=255, target_component=190)
    bench.run(0.9)
    bench.deaf = False
    in_phase(bench, AutopilotPhase.DISARMED)
    since = bench.now + 0.001
    bench.run(10.0)
    assert bench.commands(ARM, since) == []


# Silence.


def test_without_heartbeats_it_is_gone_and_only_the_order_to_disarm_is_sent():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.run(1.0)
    bench.mute = True
    in_phase(bench, AutopilotPhase.GONE)
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


# Left alone.


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
