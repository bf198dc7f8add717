"""Whom a simulated autopilot obeys: two stations, signatures, other vehicles on the link."""

import math
import struct

import pytest

from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from tests.support.mavlink_numbers import ACRO, GUIDED
from tests.support.simulated_station import NEUTRAL, World, blimp_sticks, velocity

KEY = bytes(range(32))
OTHER_KEY = bytes(32 * [7])


def armed_rover(mode=GUIDED, **settings):
    world = World("rover", settings=settings)
    station = world.station()
    station.stream(NEUTRAL["rover"])
    world.wait(2.0)
    assert station.mode(mode) == 0
    assert station.arm() == 0
    return world, station


def test_another_station_moves_it_by_setpoints_not_by_sticks():
    world, _ = armed_rover(ACRO)
    other = world.station(254)
    other.stream(("MANUAL_CONTROL", {"target": 1, "z": 300}))
    world.wait(3.0)
    assert world.motion.state.ahead == 0.0
    assert other.mode(GUIDED) == 0
    other.stream(velocity(1.0))
    world.wait(3.0)
    assert world.motion.state.ahead == pytest.approx(1.0, abs=0.02)
    assert other.command(400, 0) == 0
    assert not world.autopilot.vehicle.armed


def test_only_its_own_station_is_obeyed_with_the_option():
    world, station = armed_rover(MAV_OPTIONS=1)
    other = world.station(254)
    other.stream(velocity(1.0))
    world.wait(2.0)
    assert other.command(400, 0) is None
    assert world.motion.state.ahead == 0.0
    assert station.command(400, 0) == 0


def test_an_answer_names_the_station_that_asked_and_texts_go_to_all():
    world, station = armed_rover()
    other = world.station(254)
    world.wait(0.1)
    other.frames.clear()
    assert other.command(400, 0) == 0
    (answer,) = other.of("COMMAND_ACK")
    assert (answer["target_system"], answer["target_component"]) == (254, 190)
    assert "Throttle disarmed" in station.texts()
    assert "Throttle disarmed" in other.texts()


def test_setpoints_are_no_life_of_the_station():
    world, station = armed_rover(FS_GCS_ENABLE=1, FS_GCS_TIMEOUT=2, FS_TIMEOUT=0.1)
    station.alive = False
    station.stream(velocity(1.0))
    world.wait(4.0)
    assert world.autopilot.vehicle.mode == 4


def test_a_station_that_was_never_heard_is_not_missed():
    world = World("rover", settings={"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 1, "FS_TIMEOUT": 0.1})
    station = world.station()
    station.alive = False
    world.wait(2.0)
    assert station.mode(GUIDED) == 0
    assert station.arm() == 0
    station.stream(velocity(1.0))
    world.wait(6.0)
    assert world.autopilot.vehicle.mode == GUIDED
    assert world.motion.state.ahead == pytest.approx(1.0, abs=0.02)


def test_one_of_two_stations_with_the_same_number_hides_the_loss_of_the_other():
    world, station = armed_rover(FS_GCS_ENABLE=1, FS_GCS_TIMEOUT=1, FS_TIMEOUT=0.1)
    world.station(255)
    station.alive = False
    station.stream()
    world.wait(4.0)
    assert world.autopilot.vehicle.mode == GUIDED


def test_sticks_of_a_lost_receiver_stay_neutral_when_the_failsafe_is_switched_off():
    world, station = armed_rover(ACRO, SIM_RC_FAIL=1, FS_TIMEOUT=1.5)
    station.stream(("MANUAL_CONTROL", {"target": 1, "z": 300}))
    world.wait(3.0)
    station.stream()
    world.wait(1.0)
    fields = {"target_system": 1, "param_id": "FS_THR_ENABLE", "param_value": 0.0}
    station.send("PARAM_SET", fields)
    station.stream(("MANUAL_CONTROL", {"target": 1, "z": 300}))
    world.wait(3.0)
    assert world.motion.state.ahead == pytest.approx(0.0, abs=0.02)


def test_a_sub_whose_failsafe_held_its_depth_obeys_sticks_again_at_once():
    world = World("sub", settings={"FS_GCS_ENABLE": 3, "FS_GCS_TIMEOUT": 2}, depth=9.0)
    station = world.station()
    ahead = ("MANUAL_CONTROL", {"target": 1, "x": 500, "z": 500})
    station.stream(NEUTRAL["sub"])
    world.wait(2.0)
    assert station.mode(16) == 0
    assert station.arm() == 0
    station.stream(ahead)
    station.alive = False
    world.wait(1.0)
    station.stream()
    world.wait(8.0)
    assert world.autopilot.vehicle.mode == 2
    station.stream(ahead)
    world.wait(3.0)
    assert world.motion.state.ahead == pytest.approx(0.52, abs=0.03)


def test_orders_to_another_vehicle_change_nothing():
    world, station = armed_rover()
    for name, fields in (
        ("COMMAND_LONG", {"command": 400, "target_system": 2, "target_component": 1}),
        velocity(1.0, target_system=2),
        ("RC_CHANNELS_OVERRIDE", {"target_system": 2, "chan3_raw": 2000}),
        ("PARAM_SET", {"target_system": 2, "param_id": "WP_SPEED", "param_value": 9.0}),
    ):
        station.send(name, fields)
    world.wait(2.0)
    assert world.autopilot.vehicle.armed
    assert world.motion.state.ahead == 0.0
    assert world.autopilot.parameters["WP_SPEED"] == 2.0


def signed_command(key, stamp=None):
    clock = SigningClock(wall_clock=lambda: stamp) if stamp else SigningClock()
    packer = FramePacker(255, 190, Signer(key, clock, 3))
    return packer.pack("COMMAND_LONG", command=400, param1=0.0, target_system=1, target_component=1)


def test_with_a_key_only_signed_frames_count_but_on_the_first_link():
    world = World("rover")
    first, other = world.station(number=0), world.station(number=1)
    world.wait(2.0)
    fields = {"secret_key": KEY, "target_system": 1, "target_component": 1}
    first.send("SETUP_SIGNING", fields)
    other.frames.clear()
    assert other.command(400, 0) is None
    world.wait(1.1)
    assert other.beat().raw[2] == 1  # the vehicle signs
    for wrong in (signed_command(OTHER_KEY), signed_command(KEY, stamp=1.5e9)):
        other.raw(wrong)
    assert not other.of("COMMAND_ACK")
    other.raw(signed_command(KEY))
    assert other.of("COMMAND_ACK")
    assert first.command(400, 0) == 0
    parser = FrameParser(Signer(KEY, SigningClock()))
    assert parser.feed(other.beat().raw)[0].signed


def test_a_key_is_not_taken_while_it_is_armed():
    _, station = armed_rover()
    fields = {"secret_key": KEY, "target_system": 1, "target_component": 1}
    station.send("SETUP_SIGNING", fields)
    assert station.command(400, 0) == 0


def test_noise_and_numbers_that_are_none_move_nothing():
    world, station = armed_rover()
    station.raw(bytes(range(256)) * 20)
    for value in (math.nan, math.inf, -math.inf):
        station.send(*velocity(value))
        station.send(*velocity(0.0, value))
        for number in (176, 400, 511, 512, 1000, 183, 99):
            station.command(number, value, value)
        fields = {"target_system": 1, "param_id": "WP_SPEED", "param_value": value}
        station.send("PARAM_SET", fields)
    world.wait(1.0)
    state = world.motion.state
    assert (state.ahead, state.turn) == (0.0, 0.0)
    assert world.autopilot.vehicle.armed
    assert world.autopilot.parameters["WP_SPEED"] == 2.0


def test_parameters_are_listed_read_and_set():
    world = World("sub")
    station = world.station()
    world.wait(1.0)
    station.send("PARAM_REQUEST_LIST", {"target_system": 1, "target_component": 1})
    world.wait(1.0)
    values = station.of("PARAM_VALUE")
    assert [frame["param_index"] for frame in values] == list(range(values[0]["param_count"]))
    station.frames.clear()
    named = {"target_system": 1, "target_component": 1, "param_index": -1}
    for name in ("JS_GAIN_DEFAULT", "NO_SUCH_NAME"):
        station.send("PARAM_REQUEST_READ", named | {"param_id": name})
    fields = {"target_system": 1, "param_id": "SURFACE_MAX_THR", "param_value": 0.1}
    station.send("PARAM_SET", fields)
    read, was_set = station.of("PARAM_VALUE")
    assert (read["param_id"], read["param_value"], read["param_type"]) == (
        "JS_GAIN_DEFAULT",
        0.5,
        9,
    )
    (tenth,) = struct.unpack("<f", struct.pack("<f", 0.1))
    assert was_set["param_value"] == tenth


@pytest.mark.parametrize("kind", ["rover", "sub", "blimp"])
@pytest.mark.parametrize("value", [-3e38, -1.0, 0.0, 500.0, 3e38])
def test_no_value_of_a_parameter_ends_it(kind, value):
    world = World(kind, settings={"SIM_RC_FAIL": 1}, depth=5.0 if kind == "sub" else 0.0)
    station = world.station()
    station.stream(NEUTRAL[kind])
    world.wait(2.0)
    station.arm()
    for name in world.autopilot.parameters.names:
        fields = {"target_system": 0, "param_id": name, "param_value": value}
        station.send("PARAM_SET", fields)
    for fields in ({"x": -32768, "y": 32767, "z": 32767, "r": -32768, "buttons": 65535}, {}):
        station.stream(("MANUAL_CONTROL", {"target": 1, **fields}), blimp_sticks(c1=1, c2=65534))
        for mode in range(22):
            station.mode(mode)
            world.wait(0.1)
    station.send("MISSION_REQUEST_LIST", {})
    station.command(511, BY_NAME["ATTITUDE"].number, 3e38)
    station.command(510, BY_NAME["ATTITUDE"].number)
    station.send("SETUP_SIGNING", {"secret_key": KEY, "initial_timestamp": 2**64 - 1})
    station.command(400, 0)
    station.command(246, 1)
    world.wait(2.0)
    state = world.motion.state
    assert all(map(math.isfinite, (state.ahead, state.north, state.yaw, state.down)))
