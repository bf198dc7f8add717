"""A robot that drives 0.5 m/s along x, in the encoding of ROS 1."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tests.data.bags.moments import STAMPS

STORE = get_typestore(Stores.ROS1_NOETIC)
STORE.register(
    get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage")
)


def made(name: str, /, **given: Any) -> Any:
    """A message; what is not given is 0 or empty."""
    values = []
    for field, (kind, inner) in STORE.fielddefs[name][1]:
        if field in given:
            values.append(given.pop(field))
        elif kind == 2:
            values.append(made(inner))
        elif kind == 1:
            values.append("" if inner[0] == "string" else 0)
        else:
            element, count = (*inner,)
            values.append(np.zeros(count if kind == 3 else 0, element[1][0]))
    assert not given, given
    return STORE.types[name](*values)


class Tick:
    """The messages of one moment, by topic."""

    def __init__(self, number: int, stamp: int) -> None:
        self.x = 0.05 * number
        self.number = number
        self.time = made("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)
        self.level = made("geometry_msgs/msg/Quaternion", w=1.0)

    def messages(self) -> Iterator[tuple[str, Any]]:
        yield "/tf", made("tf2_msgs/msg/TFMessage", transforms=[self.frame()])
        yield "/odom", self.odometry()
        yield "/scan", self.scan()
        yield "/image_raw", self.picture()
        yield "/map", self.map()
        yield "/diagnostics", self.diagnostics()
        yield "/battery", self.battery()
        yield "/empty", made("std_msgs/msg/Empty")

    def header(self, frame: str) -> Any:
        return made("std_msgs/msg/Header", seq=self.number, stamp=self.time, frame_id=frame)

    def pose(self, x: float, y: float = 0) -> Any:
        position = made("geometry_msgs/msg/Point", x=x, y=y)
        return made("geometry_msgs/msg/Pose", position=position, orientation=self.level)

    def frame(self) -> Any:
        moved = made(
            "geometry_msgs/msg/Transform",
            translation=made("geometry_msgs/msg/Vector3", x=self.x),
            rotation=self.level,
        )
        return made(
            "geometry_msgs/msg/TransformStamped",
            header=self.header("odom"),
            child_frame_id="base_link",
            transform=moved,
        )

    def odometry(self) -> Any:
        covariance = np.zeros(36)
        pose = self.pose(self.x)
        twist = made("geometry_msgs/msg/Twist", linear=made("geometry_msgs/msg/Vector3", x=0.5))
        return made(
            "nav_msgs/msg/Odometry",
            header=self.header("odom"),
            child_frame_id="base_link",
            pose=made("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
            twist=made("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance),
        )

    def scan(self) -> Any:
        return made(
            "sensor_msgs/msg/LaserScan",
            header=self.header("base_link"),
            angle_min=-1.0,
            angle_max=1.0,
            angle_increment=0.1,
            range_min=0.1,
            range_max=8.0,
            ranges=np.linspace(1, 3, 21, dtype="f4"),
            intensities=np.zeros(0, "f4"),
        )

    def picture(self) -> Any:
        pixels = np.zeros((6, 8, 3), np.uint8)
        pixels[..., 1] = 255
        return made(
            "sensor_msgs/msg/Image",
            header=self.header("camera"),
            height=6,
            width=8,
            encoding="rgb8",
            step=24,
            data=pixels.reshape(-1),
        )

    def map(self) -> Any:
        cells = np.zeros((12, 20), np.int8)
        cells[0] = 100
        info = made(
            "nav_msgs/msg/MapMetaData",
            resolution=0.25,
            width=20,
            height=12,
            origin=self.pose(-1.0, -1.5),
        )
        return made(
            "nav_msgs/msg/OccupancyGrid",
            header=self.header("odom"),
            info=info,
            data=cells.reshape(-1),
        )

    def diagnostics(self) -> Any:
        status = made(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=2,
            name="motors",
            message="too hot",
            values=[made("diagnostic_msgs/msg/KeyValue", key="°C", value="91")],
        )
        return made("diagnostic_msgs/msg/DiagnosticArray", header=self.header(""), status=[status])

    def battery(self) -> Any:
        return made(
            "sensor_msgs/msg/BatteryState",
            header=self.header(""),
            voltage=12.5,
            percentage=0.5,
            present=True,
            cell_voltage=np.array([4.1, 4.2], "f4"),
            cell_temperature=np.zeros(0, "f4"),
        )


def write_ros1(path: Path) -> None:
    """By rosbags."""
    with path.open("wb") as out:
        writer = Writer(out, compression=CompressionType.LZ4)
        writer.start(profile="ros1")
        channels: dict[str, int] = {}
        for number, stamp in enumerate(STAMPS):
            for topic, message in Tick(number, stamp).messages():
                name = message.__msgtype__
                if topic not in channels:
                    text = STORE.generate_msgdef(name, ros_version=1)[0]
                    schema = writer.register_schema(
                        name.replace("/msg/", "/"), "ros1msg", text.encode()
                    )
                    channels[topic] = writer.register_channel(topic, "ros1", schema)
                raw = bytes(STORE.serialize_ros1(message, name))
                writer.add_message(channels[topic], stamp, raw, stamp)
        writer.finish()
