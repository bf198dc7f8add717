"""Bags of a small ROS 2 robot, written by the library rosbags and by the MCAP writers of others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 1_700_000_000_000_000_000
"""Stamp of the first message [ns]."""
SECONDS = 4
Entry = tuple[str, str, int, bytes]
"""Topic, type, stamp [ns], payload."""


def make(name: str, /, **fields: Any) -> Any:
    """A message: fields that are not given are 0, empty or of length 0."""
    values = []
    for field, desc in STORE.fielddefs[name][1]:
        values.append(fields.pop(field) if field in fields else _nothing(desc))
    assert not fields, f"{name} has no {sorted(fields)}"
    return STORE.types[name](*values)


def _nothing(desc: Any) -> Any:
    kind, inner = desc
    if kind == 2:
        return make(inner)
    if kind == 1:
        return "" if inner[0] == "string" else False if inner[0] == "bool" else 0
    element, count = inner
    if element[0] == 1 and element[1][0] != "string":
        return np.zeros(
            count if kind == 3 else 0, {"byte": "uint8", "char": "uint8"}.get(*[element[1][0]] * 2)
        )
    return [_nothing(element) for _ in range(count if kind == 3 else 0)]


def header(stamp: int, frame: str = "base_link") -> Any:
    """A header of this stamp [ns]."""
    time = make("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)
    return make("std_msgs/msg/Header", stamp=time, frame_id=frame)


def turned(yaw: float) -> Any:
    """The orientation of a heading [rad]."""
    return make("geometry_msgs/msg/Quaternion", z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def pose(x: float, y: float, yaw: float) -> Any:
    """A pose in the plane [m, m, rad]."""
    place = make("geometry_msgs/msg/Point", x=x, y=y)
    return make("geometry_msgs/msg/Pose", position=place, orientation=turned(yaw))


def transform(stamp: int, parent: str, child: str, x: float, y: float, yaw: float) -> Any:
    """A frame in its parent [m, m, rad]."""
    moved = make("geometry_msgs/msg/Vector3", x=x, y=y)
    inner = make("geometry_msgs/msg/Transform", translation=moved, rotation=turned(yaw))
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(stamp, parent),
        child_frame_id=child,
        transform=inner,
    )


def picture(stamp: int, shade: int, width: int = 64, height: int = 48) -> Any:
    """A picture: left half red, right half green, of a shade that tells it apart."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, : width // 2, 0], pixels[:, width // 2 :, 1] = 255, 255
    pixels[:, :, 2] = shade
    return make(
        "sensor_msgs/msg/Image",
        header=header(stamp, "camera_optical"),
        height=height,
        width=width,
        encoding="rgb8",
        step=3 * width,
        data=pixels.reshape(-1),
    )


def entries(seconds: int = SECONDS) -> Iterator[Entry]:
    """What a robot of ROS 2 publishes, in the order of time."""
    made = sorted(_messages(seconds), key=lambda each: each[1])
    for topic, stamp, message in made:
        name = message.__msgtype__
        yield topic, name, stamp, bytes(STORE.serialize_cdr(message, name))


def _messages(seconds: int) -> Iterator[tuple[str, int, Any]]:
    """A robot that drives 0.5 m/s along x in `odom`, which lies 1 m left of the origin of `map`."""
    frames = [transform(START, "base_link", "laser", 0.2, 0.0, 0.0)]
    frames += [transform(START, "base_link", "camera_optical", 0.1, 0.0, -math.pi / 2)]
    yield "/tf_static", START, make("tf2_msgs/msg/TFMessage", transforms=frames)
    cells = np.full((20, 40), -1, np.int8)
    cells[2:18, 2:38], cells[2, :] = 0, 100
    info = make(
        "nav_msgs/msg/MapMetaData", resolution=0.25, width=40, height=20, origin=pose(-2, -2, 0)
    )
    yield (
        "/map",
        START,
        make(
            "nav_msgs/msg/OccupancyGrid",
            header=header(START, "map"),
            info=info,
            data=cells.reshape(-1),
        ),
    )
    for tick in range(seconds * 20):
        stamp = START + tick * 50_000_000
        x = 0.025 * tick
        moved = [
            transform(stamp, "map", "odom", 0, 1, 0),
            transform(stamp, "odom", "base_link", x, 0, 0),
        ]
        yield "/tf", stamp, make("tf2_msgs/msg/TFMessage", transforms=moved)
        yield "/odom", stamp, _odometry(stamp, x)
        turning = make("geometry_msgs/msg/Vector3", z=0.125)
        weight = make("geometry_msgs/msg/Vector3", z=9.81)
        yield (
            "/imu/data",
            stamp,
            make(
                "sensor_msgs/msg/Imu",
                header=header(stamp),
                orientation=turned(0.0),
                angular_velocity=turning,
                linear_acceleration=weight,
            ),
        )
        yield "/debug/load", stamp, make("std_msgs/msg/Float64", data=math.sin(tick / 10))
        if tick % 2 == 0:
            yield "/camera/image_raw", stamp, picture(stamp, tick % 256)
            yield "/scan", stamp, _scan(stamp)
        if tick % 20 == 0:
            yield (
                "/battery",
                stamp,
                make(
                    "sensor_msgs/msg/BatteryState",
                    header=header(stamp),
                    voltage=12.5,
                    percentage=0.75,
                ),
            )
            yield "/diagnostics", stamp, _diagnostics(stamp)
            yield "/note", stamp, make("std_msgs/msg/String", data=f"second {tick // 20}")


def _odometry(stamp: int, x: float) -> Any:
    twist = make("geometry_msgs/msg/Twist", linear=make("geometry_msgs/msg/Vector3", x=0.5))
    return make(
        "nav_msgs/msg/Odometry",
        header=header(stamp, "odom"),
        child_frame_id="base_link",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose(x, 0, 0)),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist),
    )


def _scan(stamp: int) -> Any:
    return make(
        "sensor_msgs/msg/LaserScan",
        header=header(stamp, "laser"),
        angle_min=-math.pi / 2,
        angle_max=math.pi / 2,
        angle_increment=math.pi / 180,
        range_min=0.1,
        range_max=8.0,
        ranges=np.linspace(1, 3, 181, dtype=np.float32),
    )


def _diagnostics(stamp: int) -> Any:
    status = [
        make("diagnostic_msgs/msg/DiagnosticStatus", level=0, name="motors", message="fine"),
        make(
            "diagnostic_msgs/msg/DiagnosticStatus", level=1, name="lidar", message="dust on glass"
        ),
    ]
    return make("diagnostic_msgs/msg/DiagnosticArray", header=header(stamp), status=status)


def write_bag(
    folder: Path,
    *,
    storage: StoragePlugin = StoragePlugin.MCAP,
    version: int = 9,
    compression: CompressionMode | None = None,
    content: list[Entry] | None = None,
) -> Path:
    """A folder of rosbag2."""
    writer = Writer(folder, version=version, storage_plugin=storage)
    if compression is not None:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, name, stamp, payload in content or entries():
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=STORE)
            writer.write(connections[topic], stamp, payload)
    return folder


def write_mcap(path: Path, content: list[Entry] | None = None, **options: Any) -> Path:
    """An MCAP file by the writer of its makers, with its options."""
    with path.open("wb") as file:
        writer = McapWriter(file, **{"compression": CompressionType.NONE, **options})
        writer.start(profile="ros2", library="another")
        channels: dict[str, int] = {}
        for topic, name, stamp, payload in content or entries():
            if topic not in channels:
                text = STORE.generate_msgdef(name, ros_version=2)[0].encode()
                schema = writer.register_schema(name, "ros2msg", text)
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channels[topic], stamp, payload, stamp)
        writer.finish()
    return path


def add_foreign(writer: McapWriter) -> None:
    """Topics of encodings besides that of ROS 2."""
    schema = writer.register_schema("Thing", "flatbuffer", b"BFBS")
    channel = writer.register_channel("/thing", "flatbuffer", schema)
    writer.add_message(channel, START, b"?", START)
    proto = writer.register_schema("foxglove.Log", "protobuf", b"\x0a\xff\x01")
    channel = writer.register_channel("/proto", "protobuf", proto)
    writer.add_message(channel, START, b"\x08\x01", START)
    channel = writer.register_channel("/bare", "", 0)
    writer.add_message(channel, START, b"?", START)
