"""Frames for another ground station."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.robots.mavlink.forwarding import PASSED, FrameForwarder, passable
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker


def frames(count: int) -> list[bytes]:
    packer = FramePacker(1, 1)
    return [packer.pack("ATTITUDE", time_boot_ms=number + 1, yaw=1.0) for number in range(count)]


def test_datagrams_have_whole_frames_in_order_wherever_the_stream_is_cut() -> None:
    sent = frames(200)
    stream = b"noise" + b"".join(sent)
    forwarder = FrameForwarder()
    datagrams = [
        each
        for at in range(0, len(stream), 3000)
        for each in forwarder.datagrams(stream[at : at + 3000])
    ]
    assert b"".join(datagrams) == b"".join(sent)
    assert forwarder.passed == 200
    assert max(map(len, datagrams)) <= 1400
    assert len(datagrams) < 20
    starts = {each[:10] for each in sent}
    assert all(each[:10] in starts for each in datagrams)


def test_what_comes_back_is_counted_and_nothing_of_it_passes_that_is_not_listed() -> None:
    forwarder = FrameForwarder()
    assert forwarder.came_back(b"".join(frames(3)) + b"noise") == b""
    assert (forwarder.returned, forwarder.passed) == (3, 0)


def passed(name: str, system: int = 1, **fields: object) -> bool:
    names = {each.name for each in BY_NAME[name].fields}
    target = "target_system" if "target_system" in names else "target"
    if target in names:
        fields[target] = system
    frame = FramePacker(255, 190).pack(name, **fields)
    return [each.raw for each in passable(frame, 1)] == [frame]


@pytest.mark.parametrize(
    "name",
    [
        "HEARTBEAT",
        "MANUAL_CONTROL",
        "RC_CHANNELS_OVERRIDE",
        "SET_POSITION_TARGET_LOCAL_NED",
        "REQUEST_DATA_STREAM",
        "SETUP_SIGNING",
        "SET_GPS_GLOBAL_ORIGIN",
        "VISION_POSITION_ESTIMATE",
        "TIMESYNC",
    ],
)
def test_what_drives_or_keeps_alive_does_not_pass(name: str) -> None:
    assert not passed(name)


@pytest.mark.parametrize("name", sorted(PASSED))
def test_questions_and_commands_pass_to_this_vehicle_only(name: str) -> None:
    assert passed(name)
    assert passed(name, system=0)
    assert not passed(name, system=2)


@pytest.mark.parametrize("command", [511, 181, 182, 183, 184, 187, 209, 310])
def test_rates_of_streams_and_what_drives_motors_directly_do_not_pass(command: int) -> None:
    assert passed("COMMAND_LONG", command=176)
    assert not passed("COMMAND_LONG", command=command)
    assert not passed("COMMAND_INT", command=command)


def test_a_flood_is_bounded() -> None:
    flood = FramePacker(255, 190).pack("PARAM_REQUEST_LIST", target_system=1) * 5000
    assert len(list(passable(flood, 1))) == 64


@given(st.binary(max_size=500))
def test_any_bytes_pass_nothing_that_is_not_listed(data: bytes) -> None:
    for frame in passable(data, 1):
        assert frame.name in PASSED
