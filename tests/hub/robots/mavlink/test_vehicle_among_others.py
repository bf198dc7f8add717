"""A vehicle among others on its link: other vehicles, other stations, unknown types."""

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.vehicle.reasons import warnings
from tests.support.scripted_autopilot import (
    SUB,
    ScriptedAutopilot,
    in_phase,
    reason,
)

HOLD, POSITION_HOLD = 4, 16
SET_MODE = 176


def test_the_first_vehicle_wins_and_the_other_is_named():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    for number in range(2, 200):
        bench.tell("HEARTBEAT", system=number, type=12, autopilot=3, base_mode=128)
        bench.tell("ATTITUDE", system=number, roll=1.0)
    assert bench.vehicle.system == 1
    assert bench.vehicle.telemetry.roll == 0.0
    assert len(bench.vehicle.others) == 64
    (text,) = warnings(bench.vehicle)
    assert text == (
        "other vehicles are on its link, with the numbers 2, 3, 4, 5, 6, 7, 8, 9; Rune drives 1"
    )


def test_a_vehicle_is_chosen_by_its_number():
    bench = ScriptedAutopilot(system=7)
    bench.run(2.0)
    assert bench.vehicle.phase is AutopilotPhase.LINKING
    assert reason(bench) == "no heartbeat came yet, with the numbers 1"
    bench.tell("HEARTBEAT", system=7, type=12, autopilot=3)
    assert bench.vehicle.profile.name == "sub"


def test_another_kind_with_the_same_number_changes_nothing_and_is_named():
    bench = ScriptedAutopilot().driving()
    bench.heartbeat(type=SUB, custom_mode=POSITION_HOLD)
    assert bench.vehicle.profile.name == "rover"
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    (text,) = warnings(bench.vehicle)
    assert text == "another kind of vehicle uses the number 1: give it another one"


def test_a_number_may_have_another_vehicle_after_it_was_gone():
    bench = ScriptedAutopilot().driving()
    bench.mute = True
    in_phase(bench, AutopilotPhase.GONE)
    bench.mute, bench.kind, bench.mode = False, SUB, POSITION_HOLD
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    assert bench.vehicle.profile.name == "sub"


def test_answers_to_another_station_are_not_taken():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.deaf = True
    bench.vehicle.arm(bench.now)
    bench.run(0.1)
    for station, component in ((254, 190), (255, 1)):
        bench.tell(
            "COMMAND_ACK",
            command=SET_MODE,
            result=4,
            target_system=station,
            target_component=component,
        )
    assert bench.vehicle.phase is AutopilotPhase.ARMING
    bench.tell("COMMAND_ACK", command=SET_MODE, result=4, target_system=255, target_component=190)
    in_phase(bench, AutopilotPhase.DISARMED)
    assert reason(bench) == "the mode guided was refused: failed"


def test_echoes_that_were_not_sent_prove_nothing():
    bench = ScriptedAutopilot().driving()
    bench.deaf = True
    for _ in range(20):
        bench.run(0.1)
        bench.tell("TIMESYNC", tc1=1, ts1=12345)
    assert bench.vehicle.phase is AutopilotPhase.GONE


@pytest.mark.parametrize(("kind", "autopilot"), [(1, 3), (99, 3), (10, 5)])
def test_a_vehicle_of_an_unknown_type_is_only_watched(kind, autopilot):
    bench = ScriptedAutopilot(kind, autopilot=autopilot, armed=True)
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    bench.vehicle.drive(bench.now)
    bench.vehicle.set_mode("guided", bench.now)
    bench.vehicle.left_alone(LeftAlone.STAND, bench.now)
    bench.velocity()
    bench.velocity(ahead=1.0)
    bench.run(3.0)
    assert bench.commands(SET_MODE) == []
    assert {*bench.names()} <= {"HEARTBEAT", "TIMESYNC", "COMMAND_LONG"}
    assert "only watches" in reason(bench)


def test_a_lost_place_is_told_and_the_mode_that_the_vehicle_takes_is_kept():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.position = False
    bench.run(1.0)
    assert reason(bench) == "it does not know its place"
    bench.mode, bench.status = HOLD, 5
    in_phase(bench, AutopilotPhase.ELSEWHERE)
    since = bench.now + 0.001
    bench.run(3.0)
    assert bench.commands(SET_MODE, since) == []
    assert "one of its failsafes acts" in reason(bench)
