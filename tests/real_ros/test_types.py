"""The types, hashes and payloads of Rune are those of ROS 2 Jazzy."""

from __future__ import annotations

from typing import Any

import numpy as np

from hub.gcm.battery import BATTERY, BatteryState
from hub.gcm.geometry import Quaternion, Twist
from hub.gcm.imu import IMU, Imu
from hub.recording.topics import RecordedTopic
from hub.robots.ros.commands import TYPES, velocity_payload
from hub.robots.ros_table import CommandType
from hub.robots.simulated_ros.flavour import ROS_2
from hub.robots.simulated_ros.robot import TOPICS, SimulatedRosRobot
from hub.ros.decoding import RosDecoder
from hub.ros.known_types import known_texts
from hub.ros.type_hashes import later_definition, type_hash
from hub.ros.values import RosValue
from tests.real_ros.conftest import Start
from tests.support.waiting import until

NOT_PACKED = ("tf2_msgs", "map_msgs", "lifecycle_msgs")
"""Packages that need not be there."""


def payloads() -> list[tuple[str, bytes]]:
    """Messages of Rune by their types: of the simulated robot, and those that go to robots."""
    robot = SimulatedRosRobot("yellow", timeout=0.5)
    for _ in range(20):
        robot.advance(0.01, 1_700_000_000.25)
    said = [
        (each.type, ROS_2.encoder(each.type).encode(robot.message(each.name))) for each in TOPICS
    ]
    battery = BatteryState(voltage=12.5, current=-1.0, percentage=0.5, location="rear")
    imu = Imu(orientation=Quaternion.of(0.1, 0.2, 0.3))
    said += [(BatteryState.ros_type, b"".join(BATTERY.encode(battery)))]
    said += [(Imu.ros_type, b"".join(IMU.encode(imu)))]
    twist = Twist.planar(0.3, -0.2)
    said += [
        (TYPES[kind], velocity_payload(twist, kind, "cdr")) for kind in CommandType if kind in TYPES
    ]
    return said


def test_types_and_payloads_are_those_of_jazzy(start: Start) -> None:
    jazzy = start("jazzy_types")
    known = [name for name in known_texts() if type_hash(name)]
    asked: list[dict[str, Any]] = [{"type": name} for name in known]
    sent = payloads()
    asked += [{"type": name, "payload": payload.hex()} for name, payload in sent]
    for line in asked:
        jazzy.tell(line)
    until(lambda: len(jazzy.lines) == len(asked), 40.0, lambda: jazzy.words)
    found = 0
    for line, answer in zip(asked, jazzy.lines, strict=True):
        name = line["type"]
        if answer.get("missing"):
            assert name.startswith(NOT_PACKED), name
            continue
        found += 1
        changed = later_definition(name, answer["hash"])
        assert changed or answer["hash"] == type_hash(name), name
        if "payload" in line:
            theirs, ours = (values(name, each["payload"]) for each in (answer, line))
            assert repr(theirs) == repr(ours), name  # NaN is equal to itself there
    assert found > 110


def values(name: str, payload: str) -> Any:
    """The values of a message, as lists; what fills gaps of a payload has no meaning."""
    read = RosDecoder.of(RecordedTopic("/a", name, "", b"")).decode(bytes.fromhex(payload))
    return plain(read)


def plain(value: Any) -> Any:
    if isinstance(value, RosValue):
        return [plain(each) for _, each in value.fields()]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [plain(each) for each in value] if isinstance(value, list | tuple) else value
