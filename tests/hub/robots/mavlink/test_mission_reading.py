"""Reading the mission, geofence and rally points of a vehicle, in simulated time."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hub.robots.mavlink.asking.mission import MOST_ITEMS, MissionKind, MissionReading
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from tests.support.fake_vehicle import FakeVehicle, asked


def item(command: int = 16, frame: int = 3, **fields: Any) -> dict[str, Any]:
    return {"command": command, "frame": frame, "x": 338103130, "y": -1183938670, "z": 5.0} | fields


def vehicle() -> FakeVehicle:
    made = FakeVehicle()
    made.missions = {
        0: [item(), item(command=177, frame=2, param1=1.0), item(frame=1, x=12345, y=-20000)],
        1: [item(command=5001, param1=3.0)] * 3,
    }
    return made


def read(one: FakeVehicle) -> MissionReading:
    reading = MissionReading(one.system)
    assert asked(reading, one)
    return reading


def test_all_lists_are_read_and_acknowledged() -> None:
    one = vehicle()
    reading = read(one)
    assert reading.missing == {}
    assert [(each.kind, each.number, each.name) for each in reading.items] == [
        (MissionKind.MISSION, 0, "waypoint"),
        (MissionKind.MISSION, 1, "jump"),
        (MissionKind.MISSION, 2, "waypoint"),
        (MissionKind.FENCE, 0, "fence polygon inside"),
        (MissionKind.FENCE, 1, "fence polygon inside"),
        (MissionKind.FENCE, 2, "fence polygon inside"),
    ]
    first, _, local = reading.items[:3]
    assert (first.latitude, first.longitude) == pytest.approx((33.810313, -118.393867))
    assert math.isnan(first.x)
    assert (local.x, local.y) == pytest.approx((1.2345, -2.0))
    assert one.heard.count("MISSION_ACK") == 3


def test_lost_answers_are_asked_for_again() -> None:
    one = vehicle()
    one.lost = {("MISSION_COUNT", 0), ("MISSION_ITEM_INT", 1), ("MISSION_ITEM_INT", 4)}
    reading = read(one)
    assert len(reading.items) == 6
    assert reading.missing == {}


def test_a_list_that_does_not_come_whole_is_missing_and_the_next_is_read() -> None:
    one = vehicle()
    one.lost = {("MISSION_ITEM_INT", place) for place in range(2, 7)}
    reading = read(one)
    assert reading.missing == {MissionKind.MISSION: "it does not answer"}
    assert [each.kind for each in reading.items] == [MissionKind.MISSION] * 2 + [
        MissionKind.FENCE
    ] * 3


def test_a_refused_list_is_missing() -> None:
    reading = MissionReading(1)
    packer, parser = FramePacker(1, 1), FrameParser()
    for kind in MissionKind:
        assert [name for name, _ in reading.due(0.0)][-1] == "MISSION_REQUEST_LIST"
        for frame in parser.feed(packer.pack("MISSION_ACK", type=3, mission_type=int(kind))):
            reading.received(frame, 0.0)
    assert reading.missing == dict.fromkeys(MissionKind, "it has no such list (result 3)")


def test_a_huge_mission_is_bounded() -> None:
    reading = MissionReading(1)
    packer, parser = FramePacker(1, 1), FrameParser()
    list(reading.due(0.0))
    for frame in parser.feed(packer.pack("MISSION_COUNT", count=65535)):
        reading.received(frame, 0.0)
    for number in range(MOST_ITEMS + 10):
        for frame in parser.feed(packer.pack("MISSION_ITEM_INT", seq=number, command=16)):
            reading.received(frame, 0.0)
    assert len(reading.items) == MOST_ITEMS
    assert "only the first" in reading.missing[MissionKind.MISSION]


def test_items_of_another_list_vehicle_or_place_are_left_out() -> None:
    reading = MissionReading(1)
    list(reading.due(0.0))
    parser = FrameParser()
    for system, fields in ((1, {"mission_type": 1}), (2, {}), (1, {"seq": 3})):
        packer = FramePacker(system, 1)
        frames = packer.pack("MISSION_COUNT", count=2) if fields == {"seq": 3} else b""
        frames += packer.pack("MISSION_ITEM_INT", command=16, **fields)
        for frame in parser.feed(frames):
            reading.received(frame, 0.0)
    assert reading.items == []
