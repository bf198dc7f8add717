"""What all cameras share that are fixed on their robot."""

from __future__ import annotations

import math

from hub.gcm.vision import CameraCommand, CameraState
from hub.robots.cropping import vertical_fov
from hub.sim.spatial_pose import SpatialPose


class FixedCamera:
    """A part of `Camera`: no head, no zoom, no headlight; subclasses bring `take` and `close`."""

    def __init__(self, *, horizontal_fov: float, forward: float, height: float) -> None:
        """Mount it.

        Args:
            horizontal_fov: Field of view from left to right [rad].
            forward: Ahead of the robot's centre [m].
            height: Above the ground [m].
        """
        self._horizontal_fov = horizontal_fov
        self._forward = forward
        self._height = height

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
