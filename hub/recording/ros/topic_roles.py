"""Which topics of a recording are what of a robot, by a table of types."""

from __future__ import annotations

import enum
import re
from collections.abc import Iterator, Mapping
from typing import Final

from hub.plain_text import plain
from hub.recording.topics import RecordedTopic
from hub.ros.decoding import READABLE
from hub.ros.foxglove import ros_name
from hub.ros.schema import full_name
from hub.values import dataclass


class RosRole(enum.Enum):
    """What a topic says of a robot.

    Attributes:
        PICTURE: A camera.
        PACKED_PICTURE: A camera whose pictures are files.
        CLOUD: Points, seen from above.
        CAMERA_INFO: The field of view of a camera.
        SCAN: Beams around the robot.
        RANGE: A single beam.
        MAP: The map.
        MAP_CHANGE: A part of the map.
        PATH: Where the robot wants to go.
        ODOMETRY: Dead reckoning, and the velocity.
        POSE: Where the robot is.
        POSE_WITH_ERROR: The same, with its error.
        COMMAND: The commanded velocity.
        COMMAND_STAMPED: The same, with a time.
        FRAMES: Frames, each in its parent.
        FIXED_FRAMES: Frames that never move.
        IMU: Tilt and turn rates.
        BATTERY: The battery.
        PRESSURE: The pressure around the robot.
        JOINTS: The joints.
        PROBLEMS: What is wrong.
        LOG: Sentences of programs.
        BUMPER: What the robot touches.
    """

    PICTURE = enum.auto()
    PACKED_PICTURE = enum.auto()
    CLOUD = enum.auto()
    CAMERA_INFO = enum.auto()
    SCAN = enum.auto()
    RANGE = enum.auto()
    MAP = enum.auto()
    MAP_CHANGE = enum.auto()
    PATH = enum.auto()
    ODOMETRY = enum.auto()
    POSE = enum.auto()
    POSE_WITH_ERROR = enum.auto()
    COMMAND = enum.auto()
    COMMAND_STAMPED = enum.auto()
    FRAMES = enum.auto()
    FIXED_FRAMES = enum.auto()
    IMU = enum.auto()
    BATTERY = enum.auto()
    PRESSURE = enum.auto()
    JOINTS = enum.auto()
    PROBLEMS = enum.auto()
    LOG = enum.auto()
    BUMPER = enum.auto()


ROLES: Final[Mapping[str, RosRole]] = {
    "sensor_msgs/msg/Image": RosRole.PICTURE,
    "sensor_msgs/msg/CompressedImage": RosRole.PACKED_PICTURE,
    "sensor_msgs/msg/PointCloud2": RosRole.CLOUD,
    "sensor_msgs/msg/CameraInfo": RosRole.CAMERA_INFO,
    "sensor_msgs/msg/LaserScan": RosRole.SCAN,
    "sensor_msgs/msg/Range": RosRole.RANGE,
    "nav_msgs/msg/OccupancyGrid": RosRole.MAP,
    "map_msgs/msg/OccupancyGridUpdate": RosRole.MAP_CHANGE,
    "nav_msgs/msg/Path": RosRole.PATH,
    "nav_msgs/msg/Odometry": RosRole.ODOMETRY,
    "geometry_msgs/msg/PoseStamped": RosRole.POSE,
    "geometry_msgs/msg/PoseWithCovarianceStamped": RosRole.POSE_WITH_ERROR,
    "geometry_msgs/msg/Twist": RosRole.COMMAND,
    "geometry_msgs/msg/TwistStamped": RosRole.COMMAND_STAMPED,
    "tf2_msgs/msg/TFMessage": RosRole.FRAMES,
    "tf/msg/tfMessage": RosRole.FRAMES,
    "sensor_msgs/msg/Imu": RosRole.IMU,
    "sensor_msgs/msg/BatteryState": RosRole.BATTERY,
    "sensor_msgs/msg/FluidPressure": RosRole.PRESSURE,
    "sensor_msgs/msg/JointState": RosRole.JOINTS,
    "diagnostic_msgs/msg/DiagnosticArray": RosRole.PROBLEMS,
    "rcl_interfaces/msg/Log": RosRole.LOG,
    "rosgraph_msgs/msg/Log": RosRole.LOG,
    "irobot_create_msgs/msg/HazardDetectionVector": RosRole.BUMPER,
    "kobuki_ros_interfaces/msg/BumperEvent": RosRole.BUMPER,
    "kobuki_msgs/msg/BumperEvent": RosRole.BUMPER,
    "gazebo_msgs/msg/ContactsState": RosRole.BUMPER,
}
"""The role of each type of ROS 2; topics of other types are shown as trees, tables and plots."""

SHOWN_BY: Final[Mapping[RosRole, str]] = {
    RosRole.PICTURE: "visualizeCameraImage",
    RosRole.PACKED_PICTURE: "visualizeCameraImage",
    RosRole.CLOUD: "visualizeCameraImage, from above",
    RosRole.CAMERA_INFO: "the field of view of pictures and on maps",
    RosRole.SCAN: "visualizeRangeData",
    RosRole.RANGE: "visualizeRangeData",
    RosRole.MAP: "visualizeMapData",
    RosRole.MAP_CHANGE: "visualizeMapData",
    RosRole.PATH: "visualizeMapData, as the way ahead",
    RosRole.ODOMETRY: "visualizeMapData, visualizeSpeed, visualizeHeading",
    RosRole.POSE: "visualizeMapData, visualizeHeading",
    RosRole.POSE_WITH_ERROR: "visualizeMapData, visualizeHeading",
    RosRole.COMMAND: "visualizeSpeed",
    RosRole.COMMAND_STAMPED: "visualizeSpeed",
    RosRole.FRAMES: "the place of the robot on the map",
    RosRole.FIXED_FRAMES: "the places of sensors on the robot",
    RosRole.IMU: "visualizeAttitude",
    RosRole.BATTERY: "visualizeBattery",
    RosRole.PRESSURE: "visualizePlot of GCM_FluidPressure",
    RosRole.JOINTS: "visualizeVehicle",
    RosRole.PROBLEMS: "visualizeAlarms",
    RosRole.LOG: "errors as `!` on the timeline",
    RosRole.BUMPER: "`B` on the timeline",
}
"""The visualizer of each role, or what else it is used for."""

_PREFERRED: Final[Mapping[RosRole, tuple[str, ...]]] = {
    RosRole.ODOMETRY: (r"/odom$", r"filtered", r"/odometry"),
    RosRole.MAP: (r"/map$", r"global_costmap", r"map"),
    RosRole.PATH: (r"/plan$", r"/path$", r"global"),
    RosRole.IMU: (r"/imu/data$", r"/imu$", r"imu(?!.*raw)"),
    RosRole.POSE: (r"amcl|/pose$",),
    RosRole.POSE_WITH_ERROR: (r"amcl|/pose$",),
    RosRole.COMMAND: (r"/cmd_vel$", r"cmd_vel"),
    RosRole.COMMAND_STAMPED: (r"/cmd_vel$", r"cmd_vel"),
    RosRole.PICTURE: (r"^(?!.*depth).*(color|rgb|image_raw|left)", r"^(?!.*depth).*image"),
    RosRole.PACKED_PICTURE: (r"^(?!.*depth).*(color|rgb|image_raw|left)", r"^(?!.*depth).*image"),
}
"""Words in the names of topics that are preferred, the best first."""
_IMAGE_ENDINGS = re.compile(r"/(image(_raw|_color|_rect|_rect_color|_mono)?|compressed(Depth)?)$")
_MOST_LETTERS: Final = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicRole:
    """A topic with its role.

    Attributes:
        channel: Number of the topic.
        role: Its role.
        name: Name of its camera or sensor; unique.
    """

    channel: int
    role: RosRole
    name: str


def roles_of(
    channels: Mapping[int, RecordedTopic], counts: Mapping[int, int]
) -> tuple[TopicRole, ...]:
    """The topics with a role, those of each role with the preferred first.

    Args:
        channels: The topics.
        counts: Number of messages by channel.
    """
    found = []
    for channel, topic in channels.items():
        role = ROLES.get(full_name(ros_name(topic.schema_name)))
        if role is RosRole.FRAMES and topic.name.endswith("tf_static"):
            role = RosRole.FIXED_FRAMES
        if role is not None and topic.encoding in READABLE:
            found.append((role, channel, topic.name))
    found.sort(key=lambda each: (_rank(each[0], each[2]), -counts.get(each[1], 0), each[2]))
    names = dict(_names({channel: name for _, channel, name in found}))
    return tuple(
        TopicRole(channel=channel, role=role, name=names[channel]) for role, channel, _ in found
    )


def _rank(role: RosRole, name: str) -> int:
    words = _PREFERRED.get(role, ())
    return next((at for at, each in enumerate(words) if re.search(each, name)), len(words))


def _names(topics: Mapping[int, str]) -> Iterator[tuple[int, str]]:
    """Short names of topics, as cameras and sensors have them."""
    used: set[str] = set()
    for channel, topic in topics.items():
        short = topic
        while (cut := _IMAGE_ENDINGS.sub("", short)) != short and cut:
            short = cut
        short = plain(short.strip("/") or "topic").replace("${", "$ {").strip()
        if short in used:
            short = plain(topic.strip("/"))
        short, number = short[-_MOST_LETTERS:].strip("/ "), 2
        name = short
        while name in used or not name:
            name, number = f"{short} {number}", number + 1
        used.add(name)
        yield channel, name
