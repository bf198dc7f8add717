"""Converts pixels of the camera's picture to angles and places on the ground, and back.

The chain is the report's (Appendix B.11.50 to 53): pixel - angles in the image - angles at the
camera's mount - point on the ground in the robot's frame - point in `map` (`pose.Pose`).

The ground is a plane. That of a robot that stands is the one under its wheels, also on a ramp. That
of a robot that flies or dives is level, as far below as it measures. The conventions:

| frame | axes |
| --- | --- |
| picture | x right, y down [px] from the upper left corner; pixel (0, 0) spans 0 to 1 |
| image angles | from the picture's centre [rad], positive left and up |
| mount angles | left of straight ahead, and up from the ground's plane [rad] |
| robot | x ahead, y left of its centre, on the ground [m] |

The camera is a pinhole with square pixels, as in the simulator. The tangent of an image
angle is proportional to the distance from the centre; pan and tilt turn rays in space, and so do
the mount and the tilt of a robot that flies or dives.

The report adds pan and tilt to the image angles instead, which is exact only in the middle column.
At 20 degrees down and the edges of the wide picture (48.8 degrees), its error is a tenth of the
distance: 1.4 degrees sideways, 1.9 degrees up. The report gives no formulas: an angle proportional
to the pixel would have an error of at most 0.6 degrees. It counts tilt from the downward vertical,
and its camera frame has x right and y ahead.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final, Self

import numpy as np
import numpy.typing as npt

from hub.gcm.orientation import rotation
from hub.gcm.vision import CameraState
from hub.values import dataclass
from rune_tui.model.sightings import Floats, GroundPoints, SeenPoints, Spread

_LEAST_DEPRESSION: Final = 1e-9
"""Least sine of the angle below the horizon at which a ray meets the ground."""
_NARROWEST: Final = 1e-6
"""Least field of view of a camera [rad]."""
_SAME_PLACE: Final = 1e-9
"""Two ends of a horizon that are nearer are one point."""
_LEAST_DEPTH: Final = 1e-9
"""Least distance ahead of the camera; nearer points count as behind it [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureGeometry:
    """A picture and the camera that took it.

    Attributes:
        left: Left edge of the picture [px], 0 unless it is shown elsewhere.
        top: Upper edge of the picture [px].
        width: Width of the picture [px].
        height: Height of the picture [px].
        half_width: Tangent of half the field of view from left to right.
        half_height: Tangent of half the field of view from top to bottom.
        axes: Axes of the camera in the robot's frame, one after the other: along the optical axis,
            to the left, up.
        mount_forward: Camera ahead of the robot's centre [m].
        mount_height: Camera above the ground [m].
        mount_left: Camera to the left of the robot's centre [m].
    """

    left: float
    top: float
    width: float
    height: float
    half_width: float
    half_height: float
    axes: tuple[float, ...]
    mount_forward: float
    mount_height: float
    mount_left: float = 0.0

    @classmethod
    def of(
        cls, camera: CameraState, width_px: int, height_px: int, *, level: bool = False
    ) -> Self | None:
        """The geometry of a picture of this size; None: the camera's state has none.

        It has none while the height of a robot that flies or dives is not known.

        Args:
            camera: The state with the picture. Its vertical field of view is that of a
                4:3 picture. Pixels are square, so the horizontal one is enough.
            width_px: Width of the picture.
            height_px: Height of the picture.
            level: Whether the ground is level also under a robot that stands tilted.
        """
        usable = _NARROWEST < camera.horizontal_fov < math.pi and width_px > 0 < height_px
        mounted = camera.mount_forward, camera.mount_left, camera.mount_height
        turns = camera.pan, camera.tilt, camera.mount_yaw, camera.mount_pitch, camera.mount_roll
        numbers = (*turns, *mounted, *camera.robot_tilt, camera.robot_above_ground)
        if not usable or not all(map(math.isfinite, numbers)):
            return None
        tilted = level or not camera.stands
        body = rotation(*(camera.robot_tilt if tilted else (0.0, 0.0)), 0.0)
        head = rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw)
        axes = body @ head @ rotation(0.0, -camera.tilt, camera.pan)
        forward, left, height = (body @ mounted + (0.0, 0.0, camera.robot_above_ground)).tolist()
        if height <= 0.0:
            return None
        half_width = math.tan(camera.horizontal_fov / 2.0)
        return cls(
            left=0.0,
            top=0.0,
            width=width_px,
            height=height_px,
            half_width=half_width,
            half_height=half_width * height_px / width_px,
            axes=tuple(axes.T.ravel().tolist()),
            mount_forward=forward,
            mount_height=height,
            mount_left=left,
        )

    def shown(self, left: float, top: float, width: float, height: float) -> Self:
        """The same picture drawn into another rectangle [px], for instance of a canvas."""
        return dataclasses.replace(self, left=left, top=top, width=width, height=height)

    @property
    def mount(self) -> tuple[float, float]:
        """The camera's place ahead and to the left of the robot's centre [m]."""
        return self.mount_forward, self.mount_left

    @property
    def pan(self) -> float:
        """Direction from straight ahead [rad] of the picture's middle; of its top, looking down."""
        ahead, up = self.axes[:3], self.axes[6:]
        x, y = (ahead[each] - ahead[2] * up[each] for each in (0, 1))
        return math.atan2(y, x)

    @property
    def horizon(self) -> float:
        """Row of the horizon in the middle column [px]; may be outside the picture, and inf."""
        ahead, up = self.axes[2], self.axes[8]
        if up <= _LEAST_DEPRESSION:
            return math.copysign(math.inf, ahead)
        return self.top + self.height / 2.0 * (1.0 + ahead / up / self.half_height)

    @property
    def horizon_line(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """The ends of the horizon in the picture [px]; None: it is not in the picture."""
        # It is where rays have no component down: a + b left + c up = 0, with the tangents.
        a, b, c = self.axes[2], self.axes[5], self.axes[8]
        wide, high = self.half_width, self.half_height
        found = [(side, -(a + b * side) / c) for side in (wide, -wide) if c]
        found += [(-(a + c * side) / b, side) for side in (high, -high) if b]
        inside = [(x, y) for x, y in found if abs(x) <= wide and abs(y) <= high]
        if not inside:
            return None
        first = inside[0]
        last = max(inside, key=lambda each: math.dist(first, each))
        if math.dist(first, last) < _SAME_PLACE:
            return None
        (x0, y0), (x1, y1) = self._pixels(np.array((first, last))).tolist()
        return (x0, y0), (x1, y1)

    def image_angles(self, pixels: npt.ArrayLike) -> Floats:
        """Angles from the picture's centre [rad], left and up, of pixels; shape (..., 2) both."""
        return np.arctan(self._tangents(pixels))

    def mount_angles(self, image_angles: npt.ArrayLike) -> Floats:
        """Angles left of straight ahead and up from the ground [rad], shape (..., 2) both."""
        ahead, left, up = self._level(np.tan(np.asarray(image_angles, np.float64)))
        return np.stack((np.arctan2(left, ahead), np.arctan2(up, np.hypot(ahead, left))), axis=-1)

    def ground(self, pixels: npt.ArrayLike) -> GroundPoints:
        """Points of the ground at pixels of shape (..., 2)."""
        ahead, left, up = self._level(self._tangents(pixels))
        on_ground = up < -_LEAST_DEPRESSION * np.sqrt(ahead**2 + left**2 + up**2)
        reach = self.mount_height / np.where(on_ground, -up, np.nan)
        points = np.stack((ahead, left), axis=-1) * reach[..., None]
        points += self.mount
        return GroundPoints(points=points, on_ground=on_ground)

    def ground_point(self, x: float, y: float) -> tuple[float, float] | None:
        """Point of the ground at a pixel, in the robot's frame [m]; None: not on the ground."""
        found = self.ground((x, y))
        if not found.on_ground:
            return None
        ahead, left = found.points.tolist()
        return ahead, left

    def pixels(self, points: npt.ArrayLike, heights: npt.ArrayLike = 0.0) -> SeenPoints:
        """Pixels of points in the robot's frame [m], shape (..., 2), at some heights [m]."""
        rays = self.rays(points, heights)
        in_front = rays[..., 0] > _LEAST_DEPTH
        pixels = self.pixels_of_rays(np.where(in_front[..., None], rays, np.nan))
        corner = np.array((self.left, self.top))
        size = np.array((self.width, self.height))
        inside = ((pixels >= corner) & (pixels < corner + size)).all(axis=-1)
        return SeenPoints(pixels=pixels, in_front=in_front, inside=inside)

    def spreads(self, pixels: npt.ArrayLike) -> Floats:
        """Ground that pixels cover along and across the line of sight [m], shape (..., 2) both.

        To first order; NaN for pixels that are not on the ground.
        """
        ahead, left, up = self._level(self._tangents(pixels))
        on_ground = up < -_LEAST_DEPRESSION * np.sqrt(ahead**2 + left**2 + up**2)
        down = np.where(on_ground, -up, np.nan)
        aside = 2.0 * self.half_width / self.width
        below = 2.0 * self.half_height / self.height
        away = np.arctan2(left, ahead)
        cos, sin = np.cos(away), np.sin(away)
        covered = np.zeros((*np.shape(down), 2))
        # A step of one pixel turns the ray along an axis of the picture.
        for (dx, dy, dz), size in ((self.axes[3:6], aside), (self.axes[6:], below)):
            step_x = size * (dx * down + ahead * dz) / down**2
            step_y = size * (dy * down + left * dz) / down**2
            covered[..., 0] += np.abs(step_x * cos + step_y * sin)
            covered[..., 1] += np.abs(step_y * cos - step_x * sin)
        return covered * self.mount_height

    def spread(self, x: float, y: float) -> Spread | None:
        """Ground that one pixel covers; None: not on the ground."""
        along, across = self.spreads((x, y)).tolist()
        return None if math.isnan(along) else Spread(along=along, across=across)

    def rays(self, points: npt.ArrayLike, heights: npt.ArrayLike = 0.0) -> Floats:
        """Rays from the camera to points in the robot's frame.

        Args:
            points: Ahead and to the left [m], shape (..., 2).
            heights: Above the ground [m], shape (...,).

        Returns:
            Along the optical axis, to the left and up in the picture [m], shape (..., 3).
        """
        x, y = np.moveaxis(np.asarray(points, np.float64), -1, 0)
        x, y = x - self.mount_forward, y - self.mount_left
        down = np.broadcast_to(np.asarray(heights, np.float64) - self.mount_height, np.shape(x))
        rays: Floats = np.stack((x, y, down), axis=-1) @ self._turn.T
        return rays

    def pixels_of_rays(self, rays: Floats) -> Floats:
        """Pixels, shape (..., 2), of rays as from `rays`, all of them ahead of the camera."""
        return self._pixels(rays[..., 1:] / rays[..., :1])

    def _tangents(self, pixels: npt.ArrayLike) -> Floats:
        """Tangents of the image angles, left and up."""
        x, y = np.moveaxis(np.asarray(pixels, np.float64), -1, 0)
        return np.stack(
            (
                (1.0 - 2.0 * (x - self.left) / self.width) * self.half_width,
                (1.0 - 2.0 * (y - self.top) / self.height) * self.half_height,
            ),
            axis=-1,
        )

    def _pixels(self, tangents: Floats) -> Floats:
        left, up = np.moveaxis(tangents, -1, 0)
        return np.stack(
            (
                self.left + self.width / 2.0 * (1.0 - left / self.half_width),
                self.top + self.height / 2.0 * (1.0 - up / self.half_height),
            ),
            axis=-1,
        )

    @property
    def _turn(self) -> Floats:
        """Turns the robot's frame into the camera's, shape (3, 3)."""
        return np.array(self.axes).reshape(3, 3)

    def _level(self, tangents: Floats) -> tuple[Floats, Floats, Floats]:
        """Rays in the robot's frame: ahead, left, and up from the ground."""
        rays = np.concatenate((np.ones_like(tangents[..., :1]), tangents), axis=-1) @ self._turn
        return rays[..., 0], rays[..., 1], rays[..., 2]
