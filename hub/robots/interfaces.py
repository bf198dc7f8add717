"""What a robot's hardware must offer to the modules; each robot file implements it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import DriveState, GroundTruth
from hub.gcm.vision import CameraCommand, CameraState


class DriveBase(Protocol):
    """Wheels, range sensors, bumpers and battery; owned by the driver module."""

    def set_velocity(self, linear: float, angular: float) -> None:
        """Tell the wheels: forward [m/s], counter-clockwise [rad/s]; limits are applied."""

    def advance(self, seconds: float) -> None:
        """Let time pass; real hardware has nothing to do here."""

    def drive_state(self, stamp: float) -> DriveState:
        """What the sensors say now; `stamp` [s since the epoch] is copied into it."""

    def ground_truth(self) -> GroundTruth | None:
        """Where it really is; None where nobody knows."""


class Camera(Protocol):
    """A camera on a pan/tilt/zoom head; owned by the vision module."""

    def advance(self, seconds: float) -> None:
        """Let time pass; real hardware has nothing to do here."""

    def move(self, command: CameraCommand) -> None:
        """Start moving; limits are applied, the head takes its time."""

    def camera_state(self, stamp: float) -> CameraState:
        """Where it looks now; `stamp` [s since the epoch] is copied into it."""

    def place(self, x: float, y: float, theta: float) -> None:
        """Where the robot is [m, m, rad]; only a simulated camera needs to know."""

    def capture(self, width_px: int, height_px: int) -> npt.NDArray[np.uint8]:
        """A picture, shape (height, width, 3), at most as large as the sensor."""
