"""The tree of frames as ROS's tf has it: tf2_msgs/TFMessage, field for field."""

from __future__ import annotations

import math
from typing import Annotated, Final

from hub.gcm.body import BodyFrame, RobotBody
from hub.gcm.fields import Metres, Name
from hub.gcm.geometry import Quaternion
from hub.gcm.standard import Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Sequence
from hub.values import dataclass

MOST_TRANSFORMS: Final = 1000
"""Most transforms of one message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Translation:
    """geometry_msgs/Vector3.

    Attributes:
        x: Along x of the parent [m].
        y: Along y [m].
        z: Along z [m].
    """

    ros_type = "geometry_msgs/msg/Vector3"

    x: Metres = 0.0
    y: Metres = 0.0
    z: Metres = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Transform:
    """geometry_msgs/Transform.

    Attributes:
        translation: Place of the child's origin in the parent.
        rotation: Orientation of the child's axes in the parent.
    """

    ros_type = "geometry_msgs/msg/Transform"

    translation: Translation = Translation()
    rotation: Quaternion = Quaternion()


@dataclass(frozen=True, slots=True, kw_only=True)
class TransformStamped:
    """geometry_msgs/TransformStamped: the pose of a frame in its parent.

    Attributes:
        header: Its time, and the name of the parent.
        child_frame_id: Name of the frame.
        transform: The pose.
    """

    ros_type = "geometry_msgs/msg/TransformStamped"

    header: Header
    child_frame_id: Name
    transform: Transform


@dataclass(frozen=True, slots=True, kw_only=True)
class Transforms:
    """tf2_msgs/TFMessage.

    Attributes:
        transforms: Poses of frames, each in its parent.
    """

    ros_type = "tf2_msgs/msg/TFMessage"

    transforms: Annotated[tuple[TransformStamped, ...], Sequence(), Most(MOST_TRANSFORMS)] = ()


TRANSFORMS = MessageDefinition(name="GCM_Transforms", type=Transforms, rate_hz=10.0)
"""`map` to `odom` and `odom` to `base_link`, only while the message has subscribers."""

STATIC_TRANSFORMS = MessageDefinition(name="GCM_StaticTransforms", type=Transforms)
"""The frames of the body; published once, and central keeps it for later subscribers."""

MESSAGES = (TRANSFORMS, STATIC_TRANSFORMS)


def optical_frame(camera: str) -> str:
    """Name of the frame of a camera's pictures, as in ROS: z ahead, x to the right, y down."""
    return f"{camera}_optical"


def static_transforms(body: RobotBody) -> Transforms:
    """The constant poses of the frames of a body, and of its cameras' optical frames."""
    optical = (
        BodyFrame(
            name=optical_frame(camera.name),
            parent=camera.name,
            roll=-math.pi / 2.0,
            yaw=-math.pi / 2.0,
        )
        for camera in body.cameras
    )
    return Transforms(transforms=tuple(map(_stamped, (*body.frames, *optical))))


def _stamped(frame: BodyFrame) -> TransformStamped:
    return TransformStamped(
        header=Header(frame_id=frame.parent),
        child_frame_id=frame.name,
        transform=Transform(
            translation=Translation(x=frame.x, y=frame.y, z=frame.z),
            rotation=Quaternion.of(frame.roll, frame.pitch, frame.yaw),
        ),
    )
