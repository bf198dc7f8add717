"""What a robot's hardware must offer to the modules; each robot file implements it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import DriveState, GroundTruth
from hub.gcm.vision import CameraCommand, CameraState
from hub.robots.left_alone import LeftAlone


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


@runtime_checkable
class BaseLeftAlone(Protocol):
    """A `DriveBase` that can do more than stand when it has no operator."""

    def left_alone(self, action: LeftAlone | None) -> None:
        """From now on, do this by itself; None: somebody operates it again.

        The driver calls this once, each time that it changes; it goes on setting velocities.
        """


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """One picture of a camera.

    Attributes:
        pixels: Red, green, blue, shape (height, width, 3).
        measured: When it was taken, on the monotonic clock [s].
        horizontal_fov: Field of view from left to right of this picture [rad].
    """

    pixels: npt.NDArray[np.uint8]
    measured: float
    horizontal_fov: float


class Camera(Protocol):
    """A camera, perhaps on a pan/tilt/zoom head; owned by the vision module."""

    def advance(self, seconds: float) -> None:
        """Let time pass; real hardware has nothing to do here."""

    def move(self, command: CameraCommand) -> None:
        """Start moving; limits are applied, the head takes its time; nothing without a head."""

    def set_headlight(self, brightness: float) -> None:
        """Light the headlight, 0 (off) to 1; nothing happens where there is none."""

    def camera_state(self, stamp: float) -> CameraState:
        """Where it looks now; `stamp` [s since the epoch] is copied into it."""

    def place(self, x: float, y: float, theta: float, measured: float) -> None:
        """Where the robot was [m, m, rad], and when [s]; only a simulated camera needs to know."""

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        """A picture of this size, at most as large as the camera's own.

        Pixels are square. Of another shape than the camera's, it shows the middle.

        Args:
            width_px: Width wanted.
            height_px: Height wanted.
            now: Monotonic time [s].

        Raises:
            CameraError: There is none; the text says why, and what to do.
        """

    def close(self) -> None:
        """Give the camera back."""
