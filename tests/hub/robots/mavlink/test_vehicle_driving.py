"""A vehicle is driven, and its mode changes, with a clock of the test's own."""

import math

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.vehicle.reasons import warnings
from tests.support.mavlink_numbers import (
    ARM,
    BLIMP,
    DEPTH_HOLD,
    GUIDED,
    HOLD,
    MANUAL,
    POSITION_HOLD,
    ROVER,
    SET_MODE,
    SUB,
    SURFACE,
)
from tests.support.scripted_autopilot import ScriptedAutopilot, in_phase, moves, reason


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


@pytest.mark.parametrize(("kind", "mode"), [(ROVER, "loiter"), (SUB, "position hold")])
def test_a_disarmed_vehicle_without_a_place_is_not_asked_for_a_mode_that_needs_one(kind, mode):
    bench = ScriptedAutopilot(kind)
    bench.position = False
    in_phase(bench, AutopilotPhase.DISARMED)
    bench.vehicle.set_mode(mode, bench.now)
    bench.run(1.0)
    assert not bench.commands(SET_MODE)
    why = "it does not know its place yet"
    assert bench.vehicle.orders.refusal() == f"the mode {mode} was refused: {why}"
    bench.position = True
    bench.run(1.0)
    bench.vehicle.set_mode(mode, bench.now)
    bench.run(1.0)
    assert bench.commands(SET_MODE)
    assert not bench.vehicle.orders.refusal()


@pytest.mark.parametrize(("mode", "x"), [(POSITION_HOLD, 550), (DEPTH_HOLD, 288)])
def test_a_sub_gets_less_stick_in_depth_hold_where_it_is_thrust(mode, x):
    bench = ScriptedAutopilot(SUB)
    bench.parameters["PILOT_SPEED"] = 200.0
    bench.position = mode == POSITION_HOLD
    bench.driving()
    assert bench.mode == mode
    bench.velocity(ahead=0.3)
    assert bench.sent[-1][1]["x"] == pytest.approx(x, abs=30)


def test_a_sub_armed_without_a_place_gets_position_hold_once_it_knows_its_place_and_rests():
    bench = ScriptedAutopilot(SUB)
    bench.position = False
    bench.driving()
    assert bench.mode == DEPTH_HOLD
    bench.velocity(ahead=0.3)
    bench.position = True
    bench.run(5.0)
    assert bench.mode == DEPTH_HOLD
    assert any("changes to position hold" in each for each in warnings(bench.vehicle, bench.now))
    bench.velocity()
    bench.until(lambda: bench.mode == POSITION_HOLD, 3.0)
    bench.run(1.0)
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    assert not [*warnings(bench.vehicle, bench.now)]
    bench.velocity()
    bench.velocity(ahead=0.3)
    assert [*bench.moving(bench.now)]


def test_a_sub_that_refuses_the_better_mode_is_driven_in_depth_hold_and_asked_once():
    bench = ScriptedAutopilot(SUB)
    bench.refused = {(SET_MODE, 1.0, float(POSITION_HOLD)): 4}
    bench.position = False
    bench.driving()
    bench.position = True
    bench.run(10.0)
    assert bench.mode == DEPTH_HOLD
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    assert bench.commands(SET_MODE).count((1.0, float(POSITION_HOLD), 0.0)) == 1
    assert any("ask it to drive" in each for each in warnings(bench.vehicle, bench.now))


def test_a_sub_whose_operator_named_depth_hold_stays_in_it():
    bench = ScriptedAutopilot(SUB).driving()
    bench.vehicle.set_mode("depth hold", bench.now)
    bench.run(10.0)
    assert bench.mode == DEPTH_HOLD
    assert not [*warnings(bench.vehicle, bench.now)]


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
    assert reason(bench) == "it is asked for the mode hold"
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    bench.until(lambda: bench.mode == HOLD)
    since = bench.now
    bench.velocity(ahead=0.5)
    bench.run(3.0)
    assert "MANUAL_CONTROL" in bench.names(since)
    assert not any(bench.moving(since))
    assert "asked for here" in reason(bench)


@pytest.mark.parametrize(("kind", "steers"), [(ROVER, True), (ROVER, False), (SUB, False)])
def test_a_vehicle_that_coasts_in_its_hold_brakes_before_it_holds(kind, steers):
    bench = ScriptedAutopilot(kind)
    bench.parameters["SERVO1_FUNCTION"] = 26.0 if steers else 73.0
    bench.driving()
    bench.velocity(ahead=0.3)
    bench.moves = 0.3
    bench.run(0.5)
    asked = bench.now
    bench.vehicle.stay(bench.now)
    for _ in range(10):
        bench.velocity()
        bench.velocity(ahead=0.3)
        bench.run(0.1)
    assert not any(bench.moving(asked + 1e-6)), "nothing drives it any more"
    brakes = steers or kind == SUB
    assert bool(bench.commands(SET_MODE, asked)) is not brakes
    bench.moves = 0.0
    bench.run(0.5)
    bench.velocity()
    bench.velocity(ahead=0.3)
    bench.run(1.5)
    assert len(bench.commands(SET_MODE, asked)) == 1
    assert bench.mode == (HOLD if kind == ROVER else DEPTH_HOLD)
    assert not any(bench.moving(asked + 1e-6))


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
