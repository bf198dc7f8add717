"""With names of ROS 2, its own tools read what is recorded: `rosbags` is the oracle."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2.metadata import parse_qos
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hub.gcm.geometry import TwistStamped
from hub.gcm.mapping import INTEREST_POINTS, MAP, InterestPoint, InterestPoints, PointKind
from hub.gcm.navigation import DRIVE_STATE, VELOCITY_COMMAND, DriveState
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.odometry import Odometry
from hub.gcm.ranges import RANGES, LaserScan, RangeReadings
from hub.gcm.standard import Header
from hub.gcm.transforms import STATIC_TRANSFORMS, TRANSFORMS, Transforms
from hub.gcm.vision import IMAGE, CameraState, Image, ImageCoding
from hub.ipc.definition import MessageDefinition
from hub.ipc.ros_schema import ros2msg, ros_type
from hub.recording.anchor import TimeAnchor
from hub.recording.live.ros_names import RosTopics
from hub.recording.reader import Recording
from hub.recording.ros_quality import QOS, TYPE_HASH
from hub.recording.topics import topic_of
from hub.recording.writer import RecordingWriter, WriterLimits
from hub.ros.standard_topics import CAMERA as CAMERA_TYPE
from hub.ros.standard_topics import GRID as GRID_TYPE
from hub.ros.standard_topics import MARKS, ODOMETRY
from hub.ros.standard_topics import PICTURE as PICTURE_TYPE
from hub.ros.standard_topics import SCAN as SCAN_TYPE
from hub.ros.standard_types import LogEntry

CAMERA = CameraState(
    stamp=5.5, pan=0.0, tilt=0.0, zoom=0.0, horizontal_fov=1.0, vertical_fov=0.8, name="front",
    mount_forward=0.0, mount_height=0.3, pan_limit=0.0, tilt_limit=0.0, slewing=0,
)  # fmt: skip
SCAN = LaserScan(
    header=Header(frame_id="sonar 1"), range_max=5.0,
    ranges=np.array([1.0, 2.0], np.float32), intensities=np.empty(0, np.float32),
)  # fmt: skip
PICTURE = Image(
    camera=CAMERA, coding=ImageCoding.JPEG, width_px=4, height_px=3, channels=3,
    data=np.arange(9, dtype=np.uint8),
)  # fmt: skip
GRID = OccupancyMap(
    cells=np.array([[0, 100, -1], [1, 2, 3]], np.int8), resolution=0.05, origin_x=-1.0, origin_y=2.0
)
MARK = InterestPoint(
    number=7, kind=PointKind.VICTIM, x=1.0, y=2.0, height=0.5, note="under the desk",
    thumbnail=np.empty(0, np.uint8),
)  # fmt: skip
LOG = MessageDefinition(name="log", type=LogEntry)
MESSAGES: list[tuple[MessageDefinition[Any], Any]] = [
    (DRIVE_STATE, DriveState(odometry=Odometry())),
    (RANGES, RangeReadings(scans=(SCAN,))),
    (IMAGE, PICTURE),
    (MAP, GRID.message(5.5)),
    (INTEREST_POINTS, InterestPoints(points=(MARK,))),
    (TRANSFORMS, Transforms(transforms=())),
    (STATIC_TRANSFORMS, Transforms(transforms=())),
    (VELOCITY_COMMAND, TwistStamped.planar(0.5, 0.1)),
]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "a.mcap"
    names = RosTopics("rover")
    writer = RecordingWriter(path, TimeAnchor(10**18, 0.0), {}, WriterLimits(least_free=0))
    for definition, value in MESSAGES:
        payload = b"".join(definition.encode(value))
        writer.add(names.named(definition, topic_of("rover", definition)), payload, 1.0, 1.0)
        for topic, part in names.translated(definition, payload):
            writer.add(topic, part, 1.0, 1.0)
    writer.close()
    return path


def test_topics_have_the_names_and_types_of_ros(file: Path) -> None:
    with Recording.open(file) as recording:
        types = {topic.name: topic.schema_name for topic in recording.channels.values()}
    own = {name: kind for name, kind in types.items() if not name.startswith("/rover/")}
    assert own == {
        "/odom": "nav_msgs/msg/Odometry",
        "/scan/sonar_1": "sensor_msgs/msg/LaserScan",
        "/camera/front/image/compressed": "sensor_msgs/msg/CompressedImage",
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/rune/marks": "visualization_msgs/msg/MarkerArray",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
        "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    }
    assert {"/rover/GCM_DriveState", "/rover/GCM_Ranges", "/rover/GCM_Common_Image"} <= types.keys()


def test_tools_of_ros_read_the_messages(file: Path) -> None:
    types = get_typestore(Stores.ROS2_JAZZY)
    with Recording.open(file) as recording:
        read: dict[str, Any] = {
            recording.channels[each.channel].name: types.deserialize_cdr(
                each.payload, recording.channels[each.channel].schema_name
            )
            for each in recording.messages()
            if not recording.channels[each.channel].name.startswith("/rover/")
        }
    assert read["/scan/sonar_1"].ranges.tolist() == [1.0, 2.0]
    picture = read["/camera/front/image/compressed"]
    assert (picture.format, picture.header.frame_id) == ("jpeg", "front_optical")
    assert picture.header.stamp.nanosec == 500_000_000
    assert picture.data.tolist() == list(range(9))
    assert read["/cmd_vel"].twist.linear.x == 0.5
    grid = read["/map"]
    assert (grid.info.width, grid.info.height, grid.info.origin.position.y) == (3, 2, 2.0)
    assert grid.data.tolist() == [0, 100, -1, 1, 2, 3]
    _, place, words = read["/rune/marks"].markers
    assert (place.id, place.pose.position.x, place.header.frame_id) == (7, 1.0, "map")
    assert words.text == "7 victim: under the desk"


def test_only_latched_topics_are_latched_for_ros(file: Path) -> None:
    with Recording.open(file) as recording:
        found = {topic.name: topic.metadata[QOS] for topic in recording.channels.values()}
    latched = {
        name
        for name, quality in found.items()
        if parse_qos(quality)[0].durability.name != "VOLATILE"
    }
    assert latched == {"/tf_static", "/map", "/rover/GCM_Common_Map"}


def test_tools_of_ros_read_the_qualities(file: Path) -> None:
    with Recording.open(file) as recording:
        found = {topic.name: topic.metadata[QOS] for topic in recording.channels.values()}
    assert all(re.findall(r"(?:history|ability|liveliness): \d", each) for each in found.values())
    (quality,) = parse_qos(found["/tf_static"])
    assert quality.durability.name == "TRANSIENT_LOCAL"


def test_known_types_have_their_hashes(file: Path) -> None:
    types = get_typestore(Stores.ROS2_JAZZY)
    with Recording.open(file) as recording:
        topics = [*recording.channels.values()]
    for topic in topics:
        known = topic.schema_name in types.types
        expected = types.hash_rihs01(topic.schema_name) if known else None
        assert topic.metadata.get(TYPE_HASH) == expected, topic.name
    assert sum(TYPE_HASH in topic.metadata for topic in topics) == 8


def test_translated_types_are_those_of_ros() -> None:
    known = get_typestore(Stores.ROS2_JAZZY).fielddefs
    for definition in (ODOMETRY, SCAN_TYPE, CAMERA_TYPE, PICTURE_TYPE, GRID_TYPE, MARKS, LOG):
        for name, (_, fields) in get_types_from_msg(
            ros2msg(definition), ros_type(definition)
        ).items():
            assert fields == known[name][1], name
