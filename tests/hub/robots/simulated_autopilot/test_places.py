"""A simulated autopilot that loses its place, finds it by a camera, and other extras."""

import pytest

from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.wire.definitions import BY_NAME
from tests.support.mavlink_numbers import GUIDED, HOLD
from tests.support.simulated_station import NEUTRAL, World, velocity

POSITION_FLAG = 16


def flags(station):
    station.frames.clear()
    assert station.command(512, BY_NAME["EKF_STATUS_REPORT"].number) == 0
    return station.of("EKF_STATUS_REPORT")[-1]["flags"]


def set_value(station, name, value):
    station.send("PARAM_SET", {"target_system": 1, "param_id": name, "param_value": value})


def test_a_rover_that_loses_its_place_holds_after_eight_seconds():
    world = World("rover")
    station = world.station()
    station.stream(NEUTRAL["rover"])
    world.wait(2.0)
    assert station.mode(GUIDED) == 0
    assert station.arm() == 0
    station.stream(NEUTRAL["rover"], velocity(0.5))
    set_value(station, "SIM_GPS1_ENABLE", 0)
    world.wait(7.5)
    assert world.autopilot.vehicle.mode == GUIDED
    world.wait(1.0)
    assert world.autopilot.vehicle.mode == HOLD
    assert not flags(station) & POSITION_FLAG
    assert station.mode(GUIDED) == 4


def test_a_camera_gives_a_rover_its_place_without_satellites():
    settings = {"EK3_SRC1_POSXY": 6, "EK3_SRC1_VELXY": 6, "VISO_TYPE": 1}
    world = World("rover", settings=settings)
    station = world.station()
    world.wait(2.0)
    station.stream(("VISION_POSITION_ESTIMATE", {}))
    world.wait(2.0)
    assert not flags(station) & POSITION_FLAG  # it has no origin
    assert not station.of("LOCAL_POSITION_NED")
    station.send("SET_GPS_GLOBAL_ORIGIN", {"target_system": 1})
    world.wait(0.4)
    assert not flags(station) & POSITION_FLAG
    world.wait(0.5)
    assert flags(station) & POSITION_FLAG


@pytest.mark.parametrize("receiver", [True, False])
def test_the_channels_say_whether_there_is_a_receiver_also_with_sticks(receiver):
    world = World("rover", settings={"SIM_RC_FAIL": not receiver})
    station = world.station()
    station.stream(NEUTRAL["rover"])
    world.wait(3.0)
    telemetry = Telemetry()
    for frame in station.frames:
        telemetry.take(frame, world.now)
    assert telemetry.receiver is receiver


def test_a_sub_has_lights_gain_and_a_camera_that_turns():
    world = World("sub")
    station = world.station()
    world.wait(2.0)

    def named(name):
        return [each["value"] for each in station.of("NAMED_VALUE_FLOAT") if each["name"] == name]

    def press(button):
        for buttons in (1 << button, 0):
            station.send("MANUAL_CONTROL", {"target": 1, "z": 500, "buttons": buttons})

    before = named("Lights1")[-1]
    for _ in range(2):
        press(14)
    press(11)
    world.wait(1.0)
    assert named("Lights1")[-1] == pytest.approx(before + 0.25)
    assert named("PilotGain")[-1] == 0.75
    assert station.command(1000, -20.0, 0.0) == 0
    world.wait(1.0)
    turn = station.of("GIMBAL_DEVICE_ATTITUDE_STATUS")[-1]["q"]
    assert turn[2] == pytest.approx(-0.1736, abs=1e-3)
    assert station.command(183, 9, 1500) == 4
    assert "Channel 9 is already in use" in station.texts()
    assert station.command(531, 1) == 3


def test_long_texts_come_in_chunks():
    world = World("rover")
    station = world.station()
    world.wait(1.0)
    station.frames.clear()
    world.autopilot.vehicle.say(4, "a" * 50 + "b" * 20)
    world.wait(0.1)
    first, second = station.of("STATUSTEXT")
    assert (first["text"], second["text"]) == ("a" * 50, "b" * 20)
    assert first["id"] == second["id"] > 0
    assert (first["chunk_seq"], second["chunk_seq"]) == (0, 1)


def test_a_calibration_is_answered_when_it_is_done():
    world = World("rover")
    station = world.station()
    world.wait(1.0)
    assert station.command(241, 1) is None
    world.wait(1.9)
    assert not station.of("COMMAND_ACK")
    world.wait(0.3)
    assert station.of("COMMAND_ACK")


def test_an_armed_vehicle_does_not_restart():
    world = World("rover")
    station = world.station()
    station.stream(NEUTRAL["rover"])
    world.wait(2.0)
    assert station.arm() == 0
    assert station.command(246, 1) == 4
    world.wait(1.0)
    assert world.autopilot.vehicle.armed


def test_it_echoes_timesync_and_no_ping():
    world = World("blimp")
    station = world.station()
    station.send("TIMESYNC", {"ts1": 1234})
    station.send("PING", {"seq": 1})
    assert [frame["ts1"] for frame in station.of("TIMESYNC")] == [1234]
    assert not station.of("PING")
