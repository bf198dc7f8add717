"""Pictures of recordings of ROS 2, decoded when they are drawn."""

from __future__ import annotations

import io
import math
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image as PillowImage

from hub.errors import RosMessageError
from hub.gcm.vision import CameraState
from hub.recording.ros.robot import RosPicture
from hub.recording.ros.topic_roles import RosRole
from hub.ros.clouds import from_above, points_of
from hub.ros.images import LONGEST_SIDE, MOST_PIXELS, Pixels, pixels_of, shaded
from hub.ros.values import RosValue
from rune_tui.link.pictures import PILLOW_FAULTS
from rune_tui.model.robot_state import Picture

_FORMATS: Final = ("JPEG", "PNG", "WEBP")
_DRAFT: Final = (1280, 1280)
"""JPEG files that are larger are decoded with fewer pixels, which takes less time."""
_DEPTH_HEAD: Final = 12
"""Bytes before the file in a compressedDepth message."""
_GREY: Final = np.full((3, 4, 3), 64, np.uint8)


class BagPicture(Picture):
    """A picture of a recording; grey, if it is damaged."""

    __slots__ = ("_faults", "_pixels", "_source")
    _faults: list[str]
    _pixels: npt.NDArray[np.uint8] | None
    _source: RosPicture

    def __init__(self, source: RosPicture, stamp: float, faults: list[str]) -> None:
        """Keep the message.

        Args:
            source: The message.
            stamp: Time of the picture [s since the epoch].
            faults: Gets the fault of a damaged picture.
        """
        camera = CameraState(
            stamp=stamp,
            pan=0.0,
            tilt=0.0,
            zoom=0.0,
            horizontal_fov=source.horizontal_fov,
            vertical_fov=source.horizontal_fov * 0.75,
            mount_forward=0.0,
            mount_height=0.0,
            pan_limit=0.0,
            tilt_limit=0.0,
            slewing=0,
            name=source.camera,
        )
        for name, value in (
            ("_source", source),
            ("_pixels", None),
            ("_faults", faults),
            ("camera", camera),
            ("interval_s", 0.0),
        ):
            object.__setattr__(self, name, value)

    @property
    def pixels(self) -> npt.NDArray[np.uint8]:
        """Red, green, blue."""
        if self._pixels is not None:
            return self._pixels
        try:
            found = decoded(self._source)
        except RosMessageError as error:
            found, fault = _GREY, f"{self._source.camera}: {error}"
            if fault not in self._faults:
                self._faults.append(fault)
        object.__setattr__(self, "_pixels", found)
        return found


def decoded(picture: RosPicture) -> Pixels:
    """The pixels of a picture, shape (height, width, 3).

    Raises:
        RosMessageError: It cannot be decoded, and why.
    """
    value = picture.decoder.as_ros(picture.message.payload)
    try:
        if picture.role is RosRole.CLOUD:
            return from_above(points_of(value))
        return pixels_of(value) if picture.role is RosRole.PICTURE else _packed(value)
    except RosMessageError:
        raise
    except (TypeError, ValueError, OverflowError) as error:  # fields of other types
        text = f"a picture cannot be decoded: {error}"
        raise RosMessageError(text) from error


def _packed(value: RosValue) -> Pixels:
    """The pixels of a sensor_msgs/CompressedImage."""
    data, kind = value.get("data"), str(value.get("format"))
    deep = "compressedDepth" in kind
    raw = data[_DEPTH_HEAD:] if deep else data
    try:
        with PillowImage.open(io.BytesIO(raw.tobytes()), formats=_FORMATS) as opened:
            across, down = opened.size
            if across * down > MOST_PIXELS or max(across, down) > LONGEST_SIDE:
                text = f"a picture of {across}x{down} pixels is not shown"
                raise RosMessageError(text)
            if opened.mode.startswith(("I", "F")):
                return shaded(np.asarray(opened))
            opened.draft("RGB", _DRAFT)
            every = max(1, math.ceil(max(opened.size) / _DRAFT[0]))
            return np.asarray(opened.convert("RGB"), np.uint8)[::every, ::every]
    except PILLOW_FAULTS as error:
        text = f"a picture in the format {kind[:40]!r} cannot be decoded: {error}"
        raise RosMessageError(text) from error
