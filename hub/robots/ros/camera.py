"""A camera of a robot with ROS, by a line of its own: pictures never delay the odometry."""

from __future__ import annotations

import math

from hub.errors import CameraError, RosMessageError
from hub.robots.body_tables import CameraTable
from hub.robots.cropping import Size, cropped_fov
from hub.robots.fixed_camera import FixedCamera
from hub.robots.interfaces import Picture
from hub.robots.ros.line import RosLine
from hub.robots.ros.picture_feed import FedMessage, PictureFeed
from hub.robots.ros.pictures import decoded
from hub.robots.ros.topic_reader import UNFIT
from hub.ros.decoding import RosDecoder
from hub.ros.messages import field_of_view
from hub.ros.values import RosValue


class RosCamera(FixedCamera):
    """The newest picture of a topic; implements `Camera`."""

    def __init__(self, line: RosLine, table: CameraTable) -> None:
        """Start to connect, without waiting.

        Args:
            line: A line that nothing else uses.
            table: The camera's table in the robot file.

        Raises:
            CameraError: The table names no topic.
        """
        if not table.topic:
            text = "the robot file names no topic of pictures; give [camera], key 'topic'"
            raise CameraError(text)
        super().__init__(horizontal_fov=table.fov, forward=table.forward, height=table.height)
        self._table = table
        self._feed = PictureFeed(line, table.topic, table.info)
        self._taken: tuple[FedMessage, Size, Picture] | None = None
        self._info: FedMessage | None = None

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        """The newest picture.

        Raises:
            CameraError: There is none, or only an old one, or it cannot be decoded.
        """
        message, wanted = self._feed.newest(now), (width_px, height_px)
        if self._taken is not None and self._taken[0] is message and self._taken[1] == wanted:
            return self._taken[2]
        self._learn()
        try:
            pixels, whole = decoded(_value(message), wanted)
        except UNFIT as error:
            text = f"a picture of {self._table.topic} cannot be decoded: {error}"
            raise CameraError(text) from error
        size = pixels.shape[1], pixels.shape[0]
        picture = Picture(
            pixels=pixels,
            measured=message.measured,
            horizontal_fov=cropped_fov(self._horizontal_fov, size, whole),
        )
        self._taken = message, wanted, picture
        return picture

    def close(self) -> None:
        """Leave the line."""
        self._feed.close()

    def _learn(self) -> None:
        """Take the field of view from the camera's newest data."""
        info = self._feed.info
        if info is None or info is self._info:
            return
        self._info = info
        try:
            fov = field_of_view(_value(info))
        except (*UNFIT, RosMessageError):
            return
        self._horizontal_fov = fov if math.isfinite(fov) else self._table.fov


def _value(message: FedMessage) -> RosValue:
    return RosDecoder.of(message.topic).as_ros(message.payload)
