"""The pose of a camera, and the working memory of one size of picture."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass

BACKGROUND_DEPTH = 60.0
"""Depth of the background [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """The pose of a camera, and how wide it sees.

    Attributes:
        x: Position in the arena's frame [m].
        y: Position in the arena's frame [m].
        z: Height above the floor [m], below the ceiling.
        yaw: Its direction [rad], counter-clockwise from x.
        pitch: Upward from the horizontal [rad], within a right angle.
        horizontal_fov: Field of view from left to right [rad].
        roll: About its direction [rad]; positive: its right side is down.
    """

    x: float
    y: float
    z: float
    yaw: float
    pitch: float
    horizontal_fov: float
    roll: float = 0.0

    @property
    def eye(self) -> npt.NDArray[np.float64]:
        """Position, shape (3,) [m]."""
        return np.array((self.x, self.y, self.z))

    def basis(self) -> npt.NDArray[np.float64]:
        """Unit vectors to the right, up and forward in the arena's frame, shape (3, 3)."""
        cos_yaw, sin_yaw = math.cos(self.yaw), math.sin(self.yaw)
        cos_pitch, sin_pitch = math.cos(self.pitch), math.sin(self.pitch)
        right = np.array((sin_yaw, -cos_yaw, 0.0))
        up = np.array((-cos_yaw * sin_pitch, -sin_yaw * sin_pitch, cos_pitch))
        forward = np.array((cos_yaw * cos_pitch, sin_yaw * cos_pitch, sin_pitch))
        if self.roll == 0.0:
            return np.array((right, up, forward))
        cos_roll, sin_roll = math.cos(self.roll), math.sin(self.roll)
        return np.array(
            (cos_roll * right - sin_roll * up, cos_roll * up + sin_roll * right, forward)
        )


class CameraFrame:
    """Rays and buffers of one picture size, filled for every picture.

    Attributes:
        width: Columns.
        height: Rows.
        focal: Focal length [px].
        half_width: Tangent of half the horizontal field of view.
        half_height: Tangent of half the vertical field of view.
        basis: Right, up and forward of the camera, shape (3, 3).
        columns: Numbers of the columns, shape (width,).
        across: Component of the rays to the right, shape (width,).
        up: Component of the rays upward in the camera's frame, shape (height,).
        ray_x: Component of the rays along the arena's x, shape (height, width).
        ray_y: Component of the rays along the arena's y, shape (height, width).
        ray_z: Component of the rays along the arena's z, shape (height, width); (height, 1) while
            the camera does not roll, as all pixels of a row have the same then.
        length: Length of each ray, shape (height, width); along the optical axis it is 1.
        inverse_depth: Inverse of the depth of each pixel [1/m], shape (height, width).
        thing: Object of each pixel, as numbered by `faces.Faces`, shape (height, width).
        cell: Cell of the height map that each pixel would show, shape (height, width); only set
            where there is a height map, and only of use for things that are ground.
        scratch: Memory for one plane of numbers, shape (height, width).
    """

    def __init__(self, width_px: int, height_px: int) -> None:
        shape = (height_px, width_px)
        self.width = width_px
        self.height = height_px
        self.focal = 0.0
        self.half_width = 1.0
        self.half_height = 1.0
        self.basis = np.eye(3)
        self.columns = np.arange(width_px, dtype=np.int16)
        self.across: npt.NDArray[np.floating] = np.zeros(width_px)
        self.up: npt.NDArray[np.floating] = np.zeros(height_px)
        self.ray_x = np.empty(shape, dtype=np.float32)
        self.ray_y = np.empty(shape, dtype=np.float32)
        self.ray_z: npt.NDArray[np.floating] = np.zeros((height_px, 1))
        self.length = np.ones(shape, dtype=np.float32)
        self.inverse_depth = np.empty(shape, dtype=np.float32)
        self.thing = np.empty(shape, dtype=np.intp)
        self.cell = np.empty(0, dtype=np.int32)
        self.scratch = np.empty(shape, dtype=np.float32)

    def aim(self, view: View) -> None:
        """Compute the rays of all pixels' centres; pixels are square."""
        self.half_width = math.tan(view.horizontal_fov / 2)
        self.half_height = self.half_width * self.height / self.width
        focal = self.width / 2 / self.half_width
        self.basis = view.basis()
        if focal != self.focal:
            self.focal = focal
            self.across = (np.arange(self.width) + 0.5 - self.width / 2) / focal
            self.up = (self.height / 2 - 0.5 - np.arange(self.height)) / focal
            squared = 1.0 + self.across**2 + (self.up**2)[:, None]
            self.length = np.sqrt(squared).astype(np.float32)
        right, upward, forward = self.basis
        for rays, axis in ((self.ray_x, 0), (self.ray_y, 1)):
            down = (self.up * upward[axis] + forward[axis]).astype(np.float32)
            np.add(down[:, None], (self.across * right[axis]).astype(np.float32), out=rays)
        self.ray_z = (self.up * upward[2] + forward[2])[:, None]
        if view.roll != 0.0:
            aside = (self.across * right[2]).astype(np.float32)
            self.ray_z = self.ray_z.astype(np.float32) + aside

    def in_sight(self, corners: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """False for solids with all corners beyond one edge of the picture.

        Args:
            corners: In the camera's frame: right, up, forward [m], shape (solids, corners, 3).

        Returns:
            Shape (solids,).
        """
        x, y, z = corners[..., 0], corners[..., 1], corners[..., 2]
        wide, high = self.half_width * z, self.half_height * z
        beyond = np.stack((z <= 0.0, x > wide, x < -wide, y > high, y < -high))
        return np.logical_not(beyond.all(axis=2).any(axis=0))
