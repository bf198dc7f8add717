"""A vehicle is linked, learnt and armed, with a clock of the test's own."""

import pytest

from hub.gcm.autopilot import AutopilotPhase
from tests.support.mavlink_numbers import (
    ARM,
    BLIMP,
    DEPTH_HOLD,
    GUIDED,
    INTERVAL,
    POSITION_HOLD,
    ROVER,
    SET_MODE,
    SUB,
)
from tests.support.scripted_autopilot import ScriptedAutopilot, in_phase, moves, reason


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


def test_a_refusal_to_arm_has_the_vehicles_reasons():
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
