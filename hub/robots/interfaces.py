"""The interfaces of a robot's hardware for the modules; each robot implements them."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import DriveState, GroundTruth, Twist
from hub.gcm.ranges import LaserScan
from hub.gcm.vision import CameraCommand, CameraState
from hub.robots.left_alone import LeftAlone
from hub.values import dataclass


class DriveBase(Protocol):
    """Wheels, range sensors, bumpers and battery; owned by the driver module."""

    def command(self, twist: Twist) -> None:
        """Set the velocity in `base_link` [m/s, rad/s]; limits apply.

        A body leaves out the degrees of freedom that it does not have.
        """

    def advance(self, seconds: float) -> None:
        """Advance a simulation; real hardware does nothing here."""

    def drive_state(self, stamp: float) -> DriveState:
        """The present measurements; `stamp` [s since the epoch] is copied into them."""

    def ground_truth(self) -> GroundTruth | None:
        """Its true pose; None: unknown."""


@runtime_checkable
class RangeSource(Protocol):
    """A `DriveBase` with range sensors, as its robot file describes them."""

    def ranges(self, stamp: float) -> tuple[LaserScan, ...] | None:
        """The newest scan of each group, in the order of the description.

        None: nothing is new since the last call. `stamp` is the time now [s since the epoch].
        """


@runtime_checkable
class BaseLeftAlone(Protocol):
    """A `DriveBase` with more actions than standing when it has no operator."""

    def left_alone(self, action: LeftAlone | None) -> None:
        """Do this from now on; None: it has an operator again.

        The driver calls this at each change; it goes on setting velocities.
        """


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """One picture of a camera.

    Attributes:
        pixels: Red, green, blue, shape (height, width, 3).
        measured: Time of the picture, on the monotonic clock [s].
        horizontal_fov: Field of view from left to right of this picture [rad].
    """

    pixels: npt.NDArray[np.uint8]
    measured: float
    horizontal_fov: float


class Camera(Protocol):
    """A camera, perhaps on a pan/tilt/zoom head; owned by the vision module."""

    def advance(self, seconds: float) -> None:
        """Advance a simulation; real hardware does nothing here."""

    def move(self, command: CameraCommand) -> None:
        """Start to move within the limits; a camera without a head does nothing."""

    def set_headlight(self, brightness: float) -> None:
        """Set the headlight, 0 (off) to 1; without one, do nothing."""

    def camera_state(self, stamp: float) -> CameraState:
        """Its present direction; `stamp` [s since the epoch] is copied into it."""

    def place(
        self,
        x: float,
        y: float,
        theta: float,
        measured: float,
        *,
        z: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
    ) -> None:
        """Set the robot's pose and its time; only a simulated camera uses it.

        Args:
            x: Position in the arena's frame [m].
            y: Position in the arena's frame [m].
            theta: Heading [rad].
            measured: Monotonic time of the pose [s].
            z: Height of the robot's origin above the floor [m].
            roll: About its x [rad]; positive: its right side is down.
            pitch: About its y [rad]; positive: its nose is down.
        """

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        """A picture of this size, at most as large as the camera's own.

        Pixels are square. A picture of another shape than the camera's shows the middle.

        Args:
            width_px: Requested width.
            height_px: Requested height.
            now: Monotonic time [s].

        Raises:
            CameraError: There is none; the text gives the reason and the remedy.
        """

    def close(self) -> None:
        """Release the camera."""
