"""Topics as ROS 2 names them: `/tf`, `/odom`, `/scan/sonar`; recordings and doors share them.

| message | topics |
| --- | --- |
| one that is a type of ROS 2 | its usual name there |
| one that holds types of ROS 2 | one for each of those |
| a picture that is a JPEG or WebP file | a sensor_msgs/CompressedImage |
| the map | a nav_msgs/OccupancyGrid |
| interest points | a visualization_msgs/MarkerArray |
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from hub.gcm import battery, diagnostics, edges, flight, imu, joints, navigation
from hub.gcm.body import RobotBody
from hub.gcm.camera_info import CAMERA_INFO, CameraInfo
from hub.gcm.geometry import Point3D, Pose3D
from hub.gcm.mapping import INTEREST_POINTS, MAP, InterestPoint, InterestPoints, Map, PointKind
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.odometry import Odometry
from hub.gcm.ranges import RANGES, LaserScan
from hub.gcm.standard import MAP as MAP_FRAME
from hub.gcm.standard import Header, Time
from hub.gcm.transforms import STATIC_TRANSFORMS, TRANSFORMS, Translation, optical_frame
from hub.gcm.vision import IMAGE, Image, ImageCoding
from hub.ipc.definition import MessageDefinition
from hub.ros.standard_types import (
    ColourRgba,
    CompressedImage,
    GridOfMap,
    MapMetaData,
    Marker,
    MarkerAction,
    MarkerArray,
    MarkerKind,
)
from hub.values import dataclass

USUAL_NAMES: Final[Mapping[str, str]] = {
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
ODOMETRY: Final = MessageDefinition(name="odom", type=Odometry)
SCAN: Final = MessageDefinition(name="scan", type=LaserScan)
CAMERA: Final = MessageDefinition(name="camera_info", type=CameraInfo)
PICTURE: Final = MessageDefinition(name="image", type=CompressedImage)
GRID: Final = MessageDefinition(name="map", type=GridOfMap)
MARKS: Final = MessageDefinition(name="marks", type=MarkerArray)
TRANSLATED: Final = (navigation.DRIVE_STATE, RANGES, CAMERA_INFO, IMAGE, MAP, INTEREST_POINTS)
"""The messages that hold others."""
MARKS_TOPIC: Final = "/rune/marks"
_FORMATS = {ImageCoding.JPEG: "jpeg", ImageCoding.WEBP: "webp"}
_MARK_M = 0.2
"""Size of a mark, and of its text [m]."""
_MARK_COLOURS = {
    PointKind.VICTIM: ColourRgba(r=0.9, g=0.1, b=0.1),
    PointKind.LANDMARK: ColourRgba(r=0.1, g=0.5, b=0.9),
}


@dataclass(frozen=True, slots=True)
class StandardTopic:
    """A topic that a message is translated into.

    Attributes:
        name: As in ROS 2: "/odom".
        source: The message.
        definition: The type that it has there.
        part: Name of the camera or the group of range sensors; empty: the message has one part.
    """

    name: str
    source: MessageDefinition[Any]
    definition: MessageDefinition[Any]
    part: str = ""


def standard_topics(body: RobotBody) -> tuple[StandardTopic, ...]:
    """The topics that the messages of a robot with this body are translated into."""
    cameras = [camera.name for camera in body.cameras]
    return (
        StandardTopic("/odom", navigation.DRIVE_STATE, ODOMETRY),
        StandardTopic("/map", MAP, GRID),
        StandardTopic(MARKS_TOPIC, INTEREST_POINTS, MARKS),
        *(StandardTopic(_scan_name(each.name), RANGES, SCAN, each.name) for each in body.ranges),
        *(StandardTopic(_info_name(each), CAMERA_INFO, CAMERA, each) for each in cameras),
        *(StandardTopic(_picture_name(each), IMAGE, PICTURE, each) for each in cameras),
    )


def translated(
    definition: MessageDefinition[Any],
    value: Any,  # noqa: ANN401 - any message
) -> Iterator[tuple[str, MessageDefinition[Any], object]]:
    """Topic, definition and value of each message of ROS 2 in one of `TRANSLATED`.

    Raises:
        CodecError: It is a map that does not match its own size.
    """
    if definition is navigation.DRIVE_STATE:
        yield "/odom", ODOMETRY, value.odometry
    elif definition is RANGES:
        for scan in value.scans:
            yield _scan_name(scan.header.frame_id), SCAN, scan
    elif definition is CAMERA_INFO:
        for info in value.cameras:
            yield _info_name(info.header.frame_id.removesuffix("_optical")), CAMERA, info
    elif definition is MAP:
        yield "/map", GRID, _grid(value)
    elif definition is INTEREST_POINTS:
        yield MARKS_TOPIC, MARKS, _marks(value)
    elif definition is IMAGE and value.coding in _FORMATS:
        yield _picture_name(value.camera.name or "main"), PICTURE, _picture(value)


def _picture(value: Image) -> CompressedImage:
    camera = value.camera
    header = Header(stamp=Time.of(camera.stamp), frame_id=optical_frame(camera.name)[:64])
    return CompressedImage(header=header, format=_FORMATS[value.coding], data=value.data)


def _grid(value: Map) -> GridOfMap:
    grid = OccupancyMap.of(value)
    height, width = grid.cells.shape
    corner = Point3D(x=grid.origin_x, y=grid.origin_y)
    return GridOfMap(
        header=Header(stamp=Time.of(value.stamp), frame_id=MAP_FRAME),
        info=MapMetaData(
            resolution=grid.resolution, width=width, height=height, origin=Pose3D(position=corner)
        ),
        data=np.ascontiguousarray(grid.cells).reshape(-1),
    )


def _marks(value: InterestPoints) -> MarkerArray:
    """All marks; those before are deleted, because removed ones are missing."""
    markers = [Marker(action=MarkerAction.DELETE_ALL)]
    for point in value.points:
        markers += _mark(point)
    return MarkerArray(markers=tuple(markers))


def _mark(point: InterestPoint) -> tuple[Marker, Marker]:
    header = Header(stamp=Time.of(point.stamp), frame_id=MAP_FRAME)
    number, colour = min(point.number, 0x7FFF_FFFF), _MARK_COLOURS[point.kind]
    name = f"{point.number} {point.kind.name.lower()}"
    return (
        Marker(
            header=header, ns="marks", id=number, type=MarkerKind.SPHERE, color=colour,
            pose=Pose3D(position=Point3D(x=point.x, y=point.y, z=point.height)),
            scale=Translation(x=_MARK_M, y=_MARK_M, z=_MARK_M),
        ),
        Marker(
            header=header, ns="words", id=number, type=MarkerKind.TEXT, color=colour,
            pose=Pose3D(position=Point3D(x=point.x, y=point.y, z=point.height + _MARK_M)),
            scale=Translation(z=_MARK_M),
            text=f"{name}: {point.note}"[:1000] if point.note else name,
        ),
    )  # fmt: skip


def _scan_name(group: str) -> str:
    return f"/scan/{_part(group)}"


def _info_name(camera: str) -> str:
    return f"/camera/{_part(camera)}/camera_info"


def _picture_name(camera: str) -> str:
    return f"/camera/{_part(camera)}/image/compressed"


def _part(name: str) -> str:
    """A name as a part of a topic's."""
    safe = re.sub(r"[^A-Za-z0-9_]", "_", name) or "unnamed"
    return safe if not safe[0].isdigit() else f"_{safe}"
