"""A vehicle among others on its link: other vehicles, other stations, unknown types."""

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.vehicle.reasons import warnings
from tests.support.mavlink_numbers import ARM, HOLD, POSITION_HOLD, SET_MODE, SUB
from tests.support.scripted_autopilot import ScriptedAutopilot, in_phase, moves, reason


def test_the_first_vehicle_wins_and_the_other_is_named():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    for number in range(2, 200):
        bench.tell("HEARTBEAT", system=number, type=12, autopilot=3, base_mode=128)
        bench.tell("ATTITUDE", system=number, roll=1.0)
    assert bench.vehicle.system == 1
    assert bench.vehicle.telemetry.roll == 0.0
    assert len(bench.vehicle.identity.others) == 64
    (text,) = warnings(bench.vehicle, bench.now)
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


def test_another_kind_with_the_same_number_is_named_and_neither_is_driven():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.heartbeat(type=SUB, custom_mode=POSITION_HOLD)
    bench.run(0.1)
    assert bench.vehicle.profile.name == "rover"
    not_driven_as_twins(bench)


def not_driven_as_twins(bench):
    """Nothing moves two vehicles with one number, whatever is asked; to disarm both is possible."""
    assert bench.vehicle.phase is AutopilotPhase.LEARNING
    assert reason(bench) == "two vehicles answer with its number: give one of them another number"
    sticks = [frame for _, frame in bench.sent if "vx" in frame.fields]
    assert not moves(sticks[-1]), "the last velocity was a neutral one"
    since = bench.now + 0.001
    bench.vehicle.drive(bench.now)
    bench.vehicle.set_mode("hold", bench.now)
    bench.vehicle.arm(bench.now)
    bench.vehicle.left_alone(LeftAlone.STAND, bench.now)
    bench.velocity()
    bench.velocity(ahead=0.5)
    bench.run(2.0)
    assert bench.commands(SET_MODE, since) == bench.commands(ARM, since) == []
    assert not {"MANUAL_CONTROL", "SET_POSITION_TARGET_LOCAL_NED"} & {*bench.names(since)}
    bench.vehicle.disarm(bench.now)
    bench.run(0.1)
    assert bench.commands(ARM, since)


def test_two_alike_with_one_number_are_known_by_the_times_since_their_starts():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    for _ in range(10):
        bench.run(0.05)
        bench.tell("ATTITUDE", time_boot_ms=500_000_000)
    not_driven_as_twins(bench)
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.DISARMED)
    assert reason(bench) == "it is disarmed: arm it"


def test_two_alike_with_one_number_are_known_by_their_boards():
    bench = ScriptedAutopilot().driving()
    bench.tell("AUTOPILOT_VERSION", uid=7)
    bench.run(0.1)
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    bench.tell("AUTOPILOT_VERSION", uid=8)
    bench.run(0.1)
    not_driven_as_twins(bench)


def test_another_vehicle_in_the_place_of_one_is_not_driven():
    """Its clock is ahead: one that was booted is behind."""
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.booted -= 1000.0
    bench.run(0.2)
    assert bench.vehicle.phase is AutopilotPhase.LEARNING
    assert reason(bench) == "another vehicle sends with its number"
    in_phase(bench, AutopilotPhase.ELSEWHERE)


def test_a_sender_in_the_place_of_another_is_not_driven():
    bench = ScriptedAutopilot().driving()
    bench.vehicle.another_sender(bench.now)
    bench.run(0.2)
    assert reason(bench) == "another vehicle sends with its number"
    in_phase(bench, AutopilotPhase.ELSEWHERE)


def stations(bench):
    return [(level.name, text) for level, text in bench.vehicle.stations.problems(bench.now)]


SAME = (
    "ERROR",
    "another ground station has the number 255 too: while one of the two lives, the vehicle's "
    "failsafe does not see the loss of the other; end it, or give it another number",
)


def test_other_ground_stations_are_named_until_they_are_gone():
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    for _, frame in bench.sent:
        bench.hear(frame)
    assert stations(bench) == [], "what comes back is an echo"
    bench.tell("HEARTBEAT", system=254, component=190, type=6, autopilot=8)
    assert stations(bench) == [("WARN", "ground station 254 is connected to it, and may drive it")]
    bench.tell("MANUAL_CONTROL", system=254, component=190, target=1, x=500)
    assert stations(bench) == [("ERROR", "ground station 254 drives it too: end one of the two")]
    bench.run(11.0)
    assert stations(bench) == []
    bench.tell("MANUAL_CONTROL", system=254, component=190, target=2)
    assert stations(bench) == [], "it drives another vehicle"


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("HEARTBEAT", {"type": 6, "autopilot": 8}),
        ("MANUAL_CONTROL", {"target": 1}),
        ("RC_CHANNELS_OVERRIDE", {"target_system": 1}),
    ],
)
def test_a_ground_station_of_the_same_number_is_an_alarm(name, fields):
    bench = in_phase(ScriptedAutopilot(), AutopilotPhase.DISARMED)
    bench.tell(name, system=255, component=230, **fields)
    assert stations(bench) == [SAME]


def test_an_answer_to_a_command_that_was_not_sent_shows_a_station_of_the_same_number():
    bench = ScriptedAutopilot().driving()
    for _ in range(3):  # late answers, and those to an order that was sent several times
        bench.tell("COMMAND_ACK", command=ARM, target_system=255, target_component=190)
    bench.tell("COMMAND_ACK", command=42, target_system=254, target_component=190)
    assert stations(bench) == []
    bench.run(60.0)
    assert stations(bench) == []
    bench.tell("COMMAND_ACK", command=SET_MODE, target_system=255, target_component=190)
    assert stations(bench) == [SAME]


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


@pytest.mark.parametrize("autopilot", [0, 3, 8])
@pytest.mark.parametrize("kind", [6, 18, 26, 30, 33, 36, 40, 44])
def test_a_part_of_a_vehicle_that_uses_the_autopilots_number_is_not_the_vehicle(kind, autopilot):
    """Some gimbals and cameras are sold with component 1."""
    bench = ScriptedAutopilot()
    bench.tell("HEARTBEAT", type=kind, autopilot=autopilot, base_mode=128)
    assert bench.vehicle.phase is AutopilotPhase.LINKING
    bench = bench.driving()
    bench.tell("HEARTBEAT", type=kind, autopilot=autopilot)
    assert bench.vehicle.profile.name == "rover"
    assert bench.vehicle.phase is AutopilotPhase.DRIVING
    assert not [*warnings(bench.vehicle, bench.now)]
