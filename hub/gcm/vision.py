"""Messages of the camera: pictures on request, pan, tilt and zoom."""

from __future__ import annotations

import enum
import math
from typing import Annotated, TypeAlias

from hub.gcm.fields import (
    Flag,
    MetresIfKnown,
    Name,
    Octets,
    Radians,
    RadiansIfKnown,
    Share,
    ShareIfKnown,
    Stamp,
)
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import FLOAT32
from hub.values import dataclass

FieldOfView: TypeAlias = Annotated[float, Range(1e-6, 3.1, unit="rad")]
"""Field of view of a flat picture from one edge to the other [rad]."""
Mount: TypeAlias = Annotated[float, Range(-1000.0, 1000.0, unit="m")]
Limit: TypeAlias = Annotated[float, Range(0.0, math.tau, unit="rad")]


class ImageKind(enum.IntEnum):
    """Colours of a requested picture."""

    GREY = 0
    COLOUR = 1


NOT_CODED = "pictures cannot be coded"
"""Begin of the error of a vision that lacks the library for a coding."""


class ImageCoding(enum.IntEnum):
    """The coding of a picture.

    Attributes:
        RLE: Two-dimensional run-length coding, `hub.gcm.rle`.
        JPEG: A JPEG file.
        RAW: The values, row by row.
        WEBP: A WebP file; the fewest bytes for the same quality.
    """

    RLE = 0
    JPEG = 1
    RAW = 2
    WEBP = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageRequest:
    """Ask for one picture.

    Attributes:
        kind: Grey or colour.
        width_px: Width wanted; the answer is never larger than the camera's.
        height_px: Height wanted; the answer is never larger than the camera's.
        quality: 1 to 100, as in JPEG and WebP; RLE: 100 is exact, less keeps fewer shades.
        coding: Coding of the picture.
        camera: Name of the camera; empty: the main one.
    """

    kind: ImageKind = ImageKind.COLOUR
    width_px: Annotated[int, Range(1, 0x7FFF_FFFF)] = 160
    height_px: Annotated[int, Range(1, 0x7FFF_FFFF)] = 120
    quality: Annotated[int, Range(1, 100)] = 60
    coding: ImageCoding = ImageCoding.RLE
    camera: Name = ""


IMAGE_REQUEST = MessageDefinition(name="GCM_Image_Request", type=ImageRequest)


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraState:
    """The direction and field of view of the camera.

    Attributes:
        stamp: Time of measurement [s since the epoch]; for records only.
        pan: Angle from straight ahead [rad], positive left.
        tilt: Angle from the horizontal [rad], positive up.
        zoom: 0 (wide) to 1 (tele).
        horizontal_fov: Field of view from left to right [rad].
        vertical_fov: Field of view from top to bottom of a 4:3 picture [rad].
        mount_forward: Camera ahead of the robot's centre [m].
        mount_height: Camera above the ground [m].
        pan_limit: Largest pan to either side [rad].
        tilt_limit: Largest tilt up or down [rad].
        slewing: 1 while it moves to a commanded direction, else 0.
        robot_x: The robot's position then in `map` [m]; NaN: not known.
        robot_y: The robot's position then in `map` [m]; NaN: not known.
        robot_theta: Its heading then in `map` [rad]; NaN: not known.
        gain: Factor on the brightness of pictures; 1: unchanged.
        headlight: Brightness of the headlight, 0 to 1; NaN: none.
        name: Name of the camera, as in `GCM_RobotDescription`.
        mount_left: Camera to the left of the robot's centre [m].
        mount_yaw: Direction in which it looks at pan 0, from straight ahead [rad].
        mount_pitch: Pitch of its mount [rad], positive down.
        mount_roll: Roll of its mount [rad], positive right side down.
        robot_roll: The robot's roll then [rad], as in `GCM_Imu`; NaN: not measured.
        robot_pitch: Its pitch then [rad]; NaN: not measured.
        robot_above_ground: Its origin above the ground then [m]; 0: it stands; NaN: not known.
    """

    stamp: Stamp
    pan: Radians
    tilt: Radians
    zoom: Share
    horizontal_fov: FieldOfView
    vertical_fov: FieldOfView
    mount_forward: Mount
    mount_height: Mount
    pan_limit: Limit
    tilt_limit: Limit
    slewing: Flag
    robot_x: MetresIfKnown = math.nan
    robot_y: MetresIfKnown = math.nan
    robot_theta: RadiansIfKnown = math.nan
    gain: Annotated[float, Range(0.0, 1e6), FLOAT32] = 1.0
    headlight: Annotated[ShareIfKnown, FLOAT32] = math.nan
    name: Name = ""
    mount_left: Mount = 0.0
    mount_yaw: Radians = 0.0
    mount_pitch: Radians = 0.0
    mount_roll: Radians = 0.0
    robot_roll: RadiansIfKnown = math.nan
    robot_pitch: RadiansIfKnown = math.nan
    robot_above_ground: MetresIfKnown = 0.0

    @property
    def stands(self) -> bool:
        """Whether the robot stands on the ground."""
        return self.robot_above_ground == 0.0

    @property
    def robot_tilt(self) -> tuple[float, float]:
        """The robot's roll and pitch [rad]; level if it does not measure them."""
        if math.isnan(self.robot_roll) or math.isnan(self.robot_pitch):
            return 0.0, 0.0
        return self.robot_roll, self.robot_pitch


CAMERA_STATE = MessageDefinition(name="GCM_CameraState", type=CameraState, rate_hz=10.0)
"""The state of the main camera; those of the others come with their pictures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """One picture, the answer to an `ImageRequest`.

    Attributes:
        camera: The camera at the time of the picture.
        coding: Coding of `data`.
        width_px: Width of the picture.
        height_px: Height of the picture.
        channels: 1 for grey, 3 for red, green, blue.
        data: The coded picture, shape (n,).
    """

    camera: CameraState
    coding: ImageCoding
    width_px: Annotated[int, Range(1, 1 << 16)]
    height_px: Annotated[int, Range(1, 1 << 16)]
    channels: Annotated[int, Range(1, 3)]
    data: Octets


IMAGE = MessageDefinition(
    name="GCM_Common_Image",
    type=Image,
)


class CameraMotion(enum.IntEnum):
    """The kind of a `CameraCommand`.

    Attributes:
        ABSOLUTE: Go to pan, tilt and zoom.
        RELATIVE: Change pan, tilt and zoom by the given amounts.
        HOME: Point straight ahead, wide.
    """

    ABSOLUTE = 0
    RELATIVE = 1
    HOME = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraCommand:
    """Move the camera.

    Attributes:
        motion: Meaning of the three amounts.
        pan: [rad], positive left; NaN leaves it.
        tilt: [rad], positive up; NaN leaves it.
        zoom: 0 to 1 (or the change of it); NaN leaves it.
        camera: Name of the camera; empty: the main one.
    """

    motion: CameraMotion = CameraMotion.RELATIVE
    pan: RadiansIfKnown = 0.0
    tilt: RadiansIfKnown = 0.0
    zoom: Annotated[float, Range(-1.0, 1.0, nan=True)] = 0.0
    camera: Name = ""


CAMERA_COMMAND = MessageDefinition(
    name="GCM_Camera_Command",
    type=CameraCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class NightCommand:
    """Switch night mode.

    Attributes:
        on: 1: brighten dark pictures, and switch the headlight on; 0: neither.
        headlight: Brightness of the headlight while on, 0 to 1; NaN: unchanged.
        camera: Name of the camera; empty: all of them.
    """

    on: Flag = 0
    headlight: Annotated[ShareIfKnown, FLOAT32] = math.nan
    camera: Name = ""


NIGHT_COMMAND = MessageDefinition(
    name="GCM_Night_Command",
    type=NightCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)

MESSAGES = (IMAGE_REQUEST, IMAGE, CAMERA_STATE, CAMERA_COMMAND, NIGHT_COMMAND)
