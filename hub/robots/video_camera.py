"""A camera that is fixed on its robot: a device, a stream from the network, or a file."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from hub.gcm.vision import CameraCommand, CameraState
from hub.robots.cropping import cropped_fov, vertical_fov
from hub.robots.interfaces import Picture
from hub.robots.video_reader import VideoReader
from hub.robots.video_source import video_source
from hub.sim.spatial_pose import SpatialPose


class VideoCamera:
    """Pictures of a source in the robot file; implements `Camera`."""

    def __init__(
        self,
        source: str,
        *,
        horizontal_fov: float,
        forward: float,
        height: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Start to read, without waiting; an absent source may appear later.

        Args:
            source: Device, path, or address.
            horizontal_fov: Field of view from left to right [rad].
            forward: Ahead of the robot's centre [m].
            height: Above the ground [m].
            clock: Monotonic time [s].

        Raises:
            CameraError: The source is an address of an unknown kind.
        """
        self._horizontal_fov = horizontal_fov
        self._forward = forward
        self._height = height
        self._reader = VideoReader(video_source(source), clock=clock)

    def advance(self, seconds: float) -> None:
        """Do nothing."""

    def move(self, command: CameraCommand) -> None:
        """Do nothing: it has no head."""

    def set_headlight(self, brightness: float) -> None:
        """Do nothing: it has none."""

    def camera_state(self, stamp: float) -> CameraState:
        """Its direction: straight ahead."""
        return CameraState(
            stamp=stamp,
            pan=0.0,
            tilt=0.0,
            zoom=0.0,
            horizontal_fov=self._horizontal_fov,
            vertical_fov=vertical_fov(self._horizontal_fov),
            mount_forward=self._forward,
            mount_height=self._height,
            pan_limit=0.0,
            tilt_limit=0.0,
            slewing=0,
            headlight=math.nan,
        )

    def place(self, pose: SpatialPose, measured: float) -> None:
        """Do nothing."""

    def take(self, width_px: int, height_px: int, _now: float) -> Picture:
        """The newest picture.

        Raises:
            CameraError: There is none, or only an old one.
        """
        shot = self._reader.newest()
        pixels = shot.pixels(width_px, height_px)
        size = pixels.shape[1], pixels.shape[0]
        return Picture(
            pixels=pixels,
            measured=shot.measured,
            horizontal_fov=cropped_fov(self._horizontal_fov, size, shot.size),
        )

    def close(self) -> None:
        """Stop reading."""
        self._reader.close()
