"""Messages and definitions that lie change nothing but what is said of them."""

import random
import re

from hub.errors import RosMessageError
from hub.gcm.battery import BATTERY
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import DRIVE_STATE
from hub.gcm.ranges import RANGES, RangeReadings
from hub.modules.driver import reports
from hub.robots.ros.body import RosBody
from hub.robots.ros.own_map import RosMap
from hub.ros.decoding import RosDecoder
from hub.ros.definition_texts import definition_text
from tests.hub.robots.ros.test_body import ROBOT
from tests.support.memory_ros_line import MemoryLine, ros_robot

TYPES = {
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/battery": "sensor_msgs/msg/BatteryState",
    "/imu": "sensor_msgs/msg/Imu",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/map": "nav_msgs/msg/OccupancyGrid",
}
FIELDS = ("float64", "string", "uint8[]", "string[]", "bool", "int64", "builtin_interfaces/Time")
REPORTS = (
    (DRIVE_STATE, reports.drive_state),
    (BATTERY, reports.battery),
    (IMU, reports.imu),
    (JOINT_STATES, reports.joints),
    (DIAGNOSTICS, reports.diagnostics),
    (RANGES, lambda found, _: RangeReadings(scans=found.scans)),
)
ROUNDS = 150


def lie(text, chance):
    """A definition in which a few fields have other types."""
    lines = text.splitlines()
    for _ in range(chance.randrange(1, 4)):
        at = chance.randrange(len(lines))
        if re.fullmatch(r"\S+ \w+", lines[at]) and not lines[at].startswith("MSG"):
            lines[at] = f"{chance.choice(FIELDS)} {lines[at].split()[1]}"
    return "\n".join(lines) + "\n"


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


def test_no_message_of_any_type_ends_the_body_or_the_map(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    chance = random.Random(7)
    robot = ros_robot(tmp_path, ROBOT.replace("[ros]", '[ros]\nmap = "/map"'))
    line, maps = MemoryLine(), MemoryLine()
    body, own = RosBody(robot, line, lambda: 100.0), RosMap(maps, robot.ros)
    faults = set()
    for count in range(ROUNDS):
        for name, kind in TYPES.items():
            text = definition_text(kind, "ros2msg")
            schema = lie(text, chance).encode() if count % 3 else text.encode()
            for each in (line, maps):
                topic = each.topic(name, kind, schema_encoding="ros2msg", schema=schema)
                each.give(name, payload(topic, chance), 100.0)
            found = body.sensors(1e9)
            faults |= {each.name for each in found.diagnostics}
            for definition, report in REPORTS:
                value = report(found, 1e9)
                if value is not None:  # receivers would refuse what is out of range
                    definition.decode(b"".join(definition.encode(value)))
        body.advance(0.02)
        own.take()
    assert {"/odom", "/imu", "/scan"} <= faults
    assert len(body.sensors(1e9).diagnostics) < 60
