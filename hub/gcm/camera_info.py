"""The message of how cameras project, sensor_msgs/CameraInfo, field for field."""

from __future__ import annotations

import math
from typing import Annotated, Final

import numpy as np
import numpy.typing as npt

from hub.gcm.body import MOST_PARTS
from hub.gcm.fields import Name, Number
from hub.gcm.geometry import AnyNumber
from hub.gcm.standard import Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Fixed, Sequence
from hub.values import dataclass

PINHOLE: Final = "plumb_bob"
"""ROS's name of the usual lens model; its five numbers are 0 for a camera without distortion."""
_MOST_NUMBERS: Final = 100
_NO_DISTORTION: Final = np.zeros(5)
_STRAIGHT: Final = np.eye(3).reshape(-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class RegionOfInterest:
    """sensor_msgs/RegionOfInterest; all 0: the whole picture.

    Attributes:
        x_offset: Its left edge [px].
        y_offset: Its upper edge [px].
        height: [px].
        width: [px].
        do_rectify: Whether it counts in the rectified picture.
    """

    ros_type = "sensor_msgs/msg/RegionOfInterest"

    x_offset: Number = 0
    y_offset: Number = 0
    height: Number = 0
    width: Number = 0
    do_rectify: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraInfo:
    """sensor_msgs/CameraInfo: for pictures of the camera's largest size.

    Attributes:
        header: Its time, and the optical frame of the camera, as `GCM_StaticTransforms` has it.
        height: Height of a picture [px]; 0: not known.
        width: Width of a picture [px]; 0: not known.
        distortion_model: Name of the lens model.
        d: Numbers of that model, shape (n,).
        k: Camera matrix, row by row [px], shape (9,); all 0: not known.
        r: Rotation of rectification, row by row, shape (9,).
        p: Projection matrix, row by row [px], shape (12,); all 0: not known.
        binning_x: Pixels that are one, from left to right; 0 and 1: none.
        binning_y: The same from top to bottom.
        roi: The part of the picture that the camera gives.
    """

    ros_type = "sensor_msgs/msg/CameraInfo"

    header: Header
    height: Number
    width: Number
    distortion_model: Name = PINHOLE
    d: Annotated[AnyNumber, Sequence(), Most(_MOST_NUMBERS)]
    k: Annotated[AnyNumber, Fixed(9)]
    r: Annotated[AnyNumber, Fixed(9)]
    p: Annotated[AnyNumber, Fixed(12)]
    binning_x: Number = 0
    binning_y: Number = 0
    roi: RegionOfInterest = RegionOfInterest()

    @classmethod
    def of(
        cls, header: Header, *, width_px: int, height_px: int, horizontal_fov: float
    ) -> CameraInfo:
        """A camera with square pixels and without distortion.

        Args:
            header: Its time and frame.
            width_px: Width of a picture; 0: not known.
            height_px: Height of a picture; 0: not known.
            horizontal_fov: Field of view from left to right [rad].
        """
        camera: npt.NDArray[np.float64] = np.zeros((3, 3))
        if width_px and height_px:
            focal = width_px / 2.0 / math.tan(horizontal_fov / 2.0)
            # Pixel 0 has its middle at 0.
            across, down = (width_px - 1) / 2.0, (height_px - 1) / 2.0
            camera[:] = (focal, 0.0, across), (0.0, focal, down), (0.0, 0.0, 1.0)
        return cls(
            header=header,
            height=height_px,
            width=width_px,
            d=_NO_DISTORTION,
            k=camera.reshape(-1),
            r=_STRAIGHT,
            p=np.hstack((camera, np.zeros((3, 1)))).reshape(-1),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraInfos:
    """How each camera projects now.

    Attributes:
        cameras: The cameras, the main one first.
    """

    cameras: Annotated[tuple[CameraInfo, ...], Sequence(), Most(MOST_PARTS)] = ()


CAMERA_INFO = MessageDefinition(name="GCM_CameraInfo", type=CameraInfos, rate_hz=2.0)
"""Only while it has subscribers."""

MESSAGES = (CAMERA_INFO,)
