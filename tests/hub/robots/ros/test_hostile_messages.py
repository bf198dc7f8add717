"""Messages and definitions that lie change nothing but what is said of them."""

from __future__ import annotations

import json
import random
import re
import struct
import time
from collections.abc import Iterator

import pytest

from hub.errors import RosMessageError
from hub.gcm.battery import BATTERY
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.environment import ENVIRONMENT
from hub.gcm.flight import ALTITUDE, FLUID_PRESSURE
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import DRIVE_STATE
from hub.gcm.ranges import RANGES, RangeReadings
from hub.gcm.vehicle import VEHICLE_STATE
from hub.modules.driver import reports
from hub.robots.ros.body import RosBody
from hub.robots.ros.own_map import RosMap
from hub.robots.ros.topic_reader import MOST_BYTES, TopicReader
from hub.ros.decoding import RosDecoder
from hub.ros.definition_texts import definition_text
from hub.ros.schema import ros_type
from tests.misbehaving.strange_ros import StrangeMessages, lie, strange_json
from tests.support.memory_ros_body import ROBOT
from tests.support.memory_ros_line import MemoryLine, ros_robot

TYPES = {
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/battery": "sensor_msgs/msg/BatteryState",
    "/imu": "sensor_msgs/msg/Imu",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/pressure": "sensor_msgs/msg/FluidPressure",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/map_updates": "map_msgs/msg/OccupancyGridUpdate",
}
REPORTS = (
    (DRIVE_STATE, lambda found, stamp: reports.drive_state(found, stamp, found.reckoning)),
    (BATTERY, reports.battery),
    (ENVIRONMENT, reports.environment),
    (IMU, reports.imu),
    (ALTITUDE, reports.altitude),
    (FLUID_PRESSURE, reports.fluid_pressure),
    (VEHICLE_STATE, reports.vehicle),
    (JOINT_STATES, reports.joints),
    (DIAGNOSTICS, reports.diagnostics),
    (RANGES, lambda found, _: RangeReadings(scans=found.scans)),
)
TABLE = '[ros]\nmap = "/map"\npressure = "/pressure"\nodom = "{odom}"'
ROUNDS = 110
FRAMES = [1000, pytest.param(100_000, marks=pytest.mark.soak)]


class Robot:
    """A body and a map on lines in memory; all that they say is checked as its receivers do."""

    def __init__(self, folder, monkeypatch, odom="/odom"):
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
        text = ROBOT.replace("[ros]", TABLE.format(odom=odom))
        robot = ros_robot(folder, text.replace("linear = 0.6", "linear = 0.6\nheave = 1.0"))
        self.now, self.faults, self.used = 100.0, set(), set()
        self.line, self.maps = MemoryLine(), MemoryLine()
        self.body = RosBody(robot, self.line, lambda: self.now)
        self.map = RosMap(self.maps, robot.ros)

    def give(self, name, kind, payload, schema=b"", encoding="cdr"):
        """Let a message arrive."""
        self.now += 0.02
        for each in (self.line, self.maps):
            each.encodings = encoding
            named = "ros2msg" if schema else ""
            topic = each.topic(name, kind, schema_encoding=named, schema=schema)
            each.give(topic.name, payload, self.now)
        found = self.body.sensors(1e9)
        problems = {each.name for each in found.diagnostics}
        self.faults |= problems
        self.used |= {name} - problems
        for definition, report in REPORTS:
            value = report(found, 1e9)
            if value is not None:  # receivers would refuse what is out of range
                definition.decode(b"".join(definition.encode(value)))
        self.body.advance(0.02)
        self.map.take()
        return found


@pytest.fixture
def robot(tmp_path, monkeypatch):
    return Robot(tmp_path, monkeypatch)


def payload(topic, chance):
    """Bytes that often are exactly a message: few lengths in it are large."""
    values = (0, 0, 0, 0, 1, 2) if chance.random() < 0.8 else range(256)
    made = b"\0\1\0\0" + bytes(chance.choice(values) for _ in range(1200))
    try:
        RosDecoder.of(topic).decode(made)
    except RosMessageError as error:
        over = re.search(r"(\d+) bytes are left over", str(error))
        return made[: -int(over[1])] if over else made
    return made


def test_no_message_of_any_type_ends_the_body_or_the_map(robot):
    chance = random.Random(7)
    for count in range(ROUNDS):
        for name, kind in TYPES.items():
            text = definition_text(kind, "ros2msg")
            schema = (lie(text, chance) if count % 3 else text).encode()
            topic = robot.line.topic(name, kind, schema_encoding="ros2msg", schema=schema)
            robot.give(name, kind, payload(topic, chance), schema)
    assert {"/odom", "/imu", "/scan"} <= robot.faults
    assert len(robot.body.sensors(1e9).diagnostics) < 60


@pytest.mark.parametrize("count", FRAMES)
@pytest.mark.parametrize("odom", ["/odom", ""])
def test_strange_values_end_neither(tmp_path, monkeypatch, count, odom):
    robot, chance = Robot(tmp_path, monkeypatch, odom), random.Random(5)
    makers = [StrangeMessages(chance, odd) for odd in (0.03, 0.3)]
    for _ in range(count):
        name, kind = chance.choice(list(TYPES.items()))
        text = definition_text(kind, "ros2msg")
        text = lie(text, chance) if chance.random() < 0.2 else text
        try:
            made = chance.choice(makers).payload(ros_type(kind, "ros2msg", text))
        except RosMessageError:
            continue
        cut = chance.randrange(len(made)) if chance.random() < 0.1 else None
        robot.give(name, kind, made[:cut], text.encode())
    assert robot.used >= TYPES.keys() - {"/odom", "/tf_static"}
    assert {"/imu", "/scan", "/tf", "/joint_states"} <= robot.faults


@pytest.mark.parametrize("count", FRAMES)
def test_strange_json_ends_neither(robot, count):
    chance = random.Random(3)
    for _ in range(count):
        name, kind = chance.choice(list(TYPES.items()))
        values = strange_json(ros_type(kind, "ros2msg", definition_text(kind, "ros2msg")), chance)
        robot.give(name, kind, json.dumps(values).encode(), encoding="json")
    assert {"/battery", "/diagnostics", "/map", "/pressure"} <= robot.used
    assert {"/odom", "/imu", "/scan", "/tf"} <= robot.faults


def frames(*origins: tuple[float, float, float], name="base_link", over="odom") -> bytes:
    """A tf2_msgs/TFMessage, as CDR."""
    made = bytearray(struct.pack("<I", len(origins)))
    for origin in origins:
        made += bytes(-len(made) % 4) + struct.pack("<II", 1, 0)
        for text in (over, name):
            made += bytes(-len(made) % 4) + struct.pack("<I", len(text) + 1) + text.encode() + b"\0"
        made += bytes(-len(made) % 8) + struct.pack("<7d", *origin, 0.0, 0.0, 0.0, 1.0)
    return b"\0\1\0\0" + bytes(made)


@pytest.mark.parametrize("far", [2e6, 1e308, float("inf"), float("nan")])
@pytest.mark.parametrize("axis", [0, 1])
def test_frames_beyond_all_places_are_no_place(tmp_path, monkeypatch, far, axis):
    robot = Robot(tmp_path, monkeypatch, odom="")
    robot.give("/tf", TYPES["/tf"], frames((0.0, 0.0, 0.0), name="odom", over="map"))
    assert robot.give("/tf", TYPES["/tf"], frames((1.0, 2.0, 0.0))).known
    moved = [far if each == axis else 1.0 for each in range(3)]
    robot.give("/tf", TYPES["/tf"], frames(tuple(moved)))
    robot.now += 1.0
    assert not robot.give("/tf", TYPES["/tf"], frames(tuple(moved))).known


def test_places_that_only_the_map_moves_too_far_are_none(tmp_path, monkeypatch):
    robot = Robot(tmp_path, monkeypatch, odom="")
    robot.give("/tf", TYPES["/tf"], frames((9e5, 0.0, 0.0), name="odom", over="map"))
    assert not robot.give("/tf", TYPES["/tf"], frames((9e5, 0.0, 0.0))).known
    assert robot.give("/tf", TYPES["/tf"], frames((9e4, 0.0, 0.0))).known


def test_a_long_message_keeps_nobody_waiting(robot):
    long = frames(*[(1.0, 2.0, 0.0)] * 100_000)
    begun = time.process_time()
    robot.give("/tf", TYPES["/tf"], long)
    assert time.process_time() - begun < 1.0  # reading it takes four seconds
    text = f"messages of /tf cannot be used: messages of more than {MOST_BYTES} bytes are not read"
    assert text in [each.message for each in robot.body.sensors(1e9).diagnostics]


def definitions() -> Iterator[bytes]:
    """Definitions that are all different, and take long to read."""
    for number in range(50):
        yield "".join(f"string s{number}_{each}\n" for each in range(1900)).encode()


def test_definitions_that_change_all_the_time_are_not_all_read():
    line = MemoryLine()
    reader = TopicReader(line)
    reader.read("/odom", lambda *_: None, each=True)
    begun = time.process_time()
    for schema in definitions():
        line.topic("/odom", "a/msg/Odom", schema_encoding="ros2msg", schema=schema)
        line.give("/odom", b"\0\1\0\0", 100.0)
    assert "changes too often" in reader.faults["/odom"]
    assert time.process_time() - begun < 5.0  # reading all takes 15 seconds
    line.topic("/odom", "std_msgs/msg/Bool")
    line.give("/odom", b"\0\1\0\0\1", 160.0)
    assert not reader.faults
