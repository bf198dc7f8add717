"""Topics as ROS 2 names them, for its tools: `/tf`, `/odom`, `/scan/sonar`.

| message | topics |
| --- | --- |
| one that is a type of ROS 2 | its usual name there |
| one that holds types of ROS 2 | its own topic, and one for each of those |
| a picture that is a JPEG or WebP file | its own topic, and a sensor_msgs/CompressedImage |
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from hub.errors import CodecError
from hub.gcm import battery, diagnostics, edges, flight, imu, joints, navigation
from hub.gcm.camera_info import CAMERA_INFO, CameraInfo
from hub.gcm.fields import Name
from hub.gcm.odometry import Odometry
from hub.gcm.ranges import RANGES, LaserScan
from hub.gcm.standard import Header, Time
from hub.gcm.transforms import STATIC_TRANSFORMS, TRANSFORMS
from hub.gcm.vision import IMAGE, Image, ImageCoding
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.codegen import Buffer
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Sequence
from hub.recording.ros_quality import QOS
from hub.recording.topics import RecordedTopic, topic_of
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CompressedImage:
    """sensor_msgs/CompressedImage.

    Attributes:
        header: Its time, and the optical frame of the camera.
        format: "jpeg" or "webp".
        data: The file, shape (n,).
    """

    ros_type = "sensor_msgs/msg/CompressedImage"

    header: Header = Header()
    format: Name = ""
    data: Annotated[npt.NDArray[np.uint8], Sequence(), Most(1 << 26)]


_NAMES = {
    TRANSFORMS.name: "/tf",
    STATIC_TRANSFORMS.name: "/tf_static",
    navigation.VELOCITY_COMMAND.name: "/cmd_vel",
    battery.BATTERY.name: "/battery_state",
    imu.IMU.name: "/imu/data",
    joints.JOINT_STATES.name: "/joint_states",
    diagnostics.DIAGNOSTICS.name: "/diagnostics",
    flight.FLUID_PRESSURE.name: "/pressure",
    edges.EDGES.name: "/edges",
}
"""The usual names of messages that are types of ROS 2."""
_ODOMETRY = MessageDefinition(name="odom", type=Odometry)
_SCAN = MessageDefinition(name="scan", type=LaserScan)
_CAMERA_INFO = MessageDefinition(name="camera_info", type=CameraInfo)
_PICTURE = MessageDefinition(name="image", type=CompressedImage)
_FORMATS = {ImageCoding.JPEG: "jpeg", ImageCoding.WEBP: "webp"}
_LONGEST = "\n".join(f"    {part}: {number}" for part, number in (
    ("sec", 9223372036), ("nsec", 854775807)
))  # fmt: skip


class RosTopics:
    """The topics of one robot."""

    def __init__(self, robot: str) -> None:
        """Translate nothing yet."""
        self._robot = robot
        self._topics: dict[tuple[str, str], RecordedTopic] = {}

    def named(self, definition: MessageDefinition[Any], topic: RecordedTopic) -> RecordedTopic:
        """The topic of a message, under the name that ROS 2 has for it."""
        key = definition.name, ""
        if key not in self._topics:
            name = _NAMES.get(definition.name, topic.name)
            metadata = {**topic.metadata, QOS: quality(definition)}
            self._topics[key] = dataclasses.replace(topic, name=name, metadata=metadata)
        return self._topics[key]

    def translated(
        self, definition: MessageDefinition[Any], payload: Buffer
    ) -> Iterator[tuple[RecordedTopic, bytes]]:
        """The messages of ROS 2 that a message holds; none if it cannot be read."""
        if definition not in (navigation.DRIVE_STATE, RANGES, CAMERA_INFO, IMAGE):
            return
        try:
            value = definition.decode(payload)
        except CodecError:
            return
        for name, part, content in _parts(definition, value):
            yield self._topic(name, part), b"".join(part.encode(content))

    def _topic(self, name: str, definition: MessageDefinition[Any]) -> RecordedTopic:
        key = name, definition.name
        if key not in self._topics:
            topic = topic_of(self._robot, definition)
            self._topics[key] = dataclasses.replace(
                topic, name=name, metadata={**topic.metadata, QOS: quality(definition)}
            )
        return self._topics[key]


def quality(definition: MessageDefinition[Any]) -> str:
    """A message's quality of service, in the words of ROS 2."""
    latched = definition.rate_hz == 0.0 and definition.keep is Keep.NEWEST
    latched = latched and definition.plane is Plane.STATE and definition.name not in _ANSWERS
    return "\n".join(
        (
            "- history: keep_last",
            "  depth: 10",
            "  reliability: reliable",
            f"  durability: {'transient_local' if latched else 'volatile'}",
            f"  deadline:\n{_LONGEST}",
            f"  lifespan:\n{_LONGEST}",
            "  liveliness: automatic",
            f"  liveliness_lease_duration:\n{_LONGEST}",
            "  avoid_ros_namespace_conventions: false",
        )
    )


_ANSWERS = frozenset(each.name for each in (_ODOMETRY, _SCAN, _CAMERA_INFO, _PICTURE, IMAGE))


def _parts(
    definition: MessageDefinition[Any],
    value: Any,  # noqa: ANN401 - any message
) -> Iterator[tuple[str, MessageDefinition[Any], object]]:
    """Topic, definition and value of each message of ROS 2 in a message."""
    if definition is navigation.DRIVE_STATE:
        yield "/odom", _ODOMETRY, value.odometry
    elif definition is RANGES:
        for scan in value.scans:
            yield f"/scan/{_part(scan.header.frame_id)}", _SCAN, scan
    elif definition is CAMERA_INFO:
        for info in value.cameras:
            camera = info.header.frame_id.removesuffix("_optical")
            yield f"/camera/{_part(camera)}/camera_info", _CAMERA_INFO, info
    elif value.coding in _FORMATS:
        yield _picture(value)


def _picture(value: Image) -> tuple[str, MessageDefinition[Any], object]:
    camera = value.camera
    header = Header(stamp=Time.of(camera.stamp), frame_id=f"{camera.name}_optical"[:64])
    picture = CompressedImage(header=header, format=_FORMATS[value.coding], data=value.data)
    return f"/camera/{_part(camera.name or 'main')}/image/compressed", _PICTURE, picture


def _part(name: str) -> str:
    """A name as a part of a topic's."""
    safe = re.sub(r"[^A-Za-z0-9_]", "_", name) or "unnamed"
    return safe if not safe[0].isdigit() else f"_{safe}"
