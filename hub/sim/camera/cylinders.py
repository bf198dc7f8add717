"""Draws upright cylinders into a camera's frame, each within the pixels that can show it."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.camera.faces import PLANES, Faces
from hub.sim.camera.view import CameraFrame, View

_NEAREST = 1e-6
"""Distance ahead of the camera from which on a corner has a place in the picture [m]."""


def draw_cylinders(view: View, frame: CameraFrame, faces: Faces) -> None:
    """Draw all cylinders that are in sight.

    Args:
        view: The camera.
        frame: Its frame, aimed; it shows what is drawn.
        faces: With at least one cylinder.
    """
    corners = (faces.cylinder_corners - view.eye) @ frame.basis.T
    first = PLANES + len(faces.axis)
    for number in np.flatnonzero(frame.in_sight(corners)).tolist():
        rows, columns, nearest = _bounds(frame, corners[number])
        known = frame.inverse_depth[rows, columns]
        if known.size and known.min() < nearest:
            x, y, radius, low, high = faces.cylinders[number].tolist()
            mantle = _Mantle(view, frame, rows, columns, x, y, radius)
            mantle.draw(low, high, first + number)


def _bounds(
    frame: CameraFrame, corners: npt.NDArray[np.float64]
) -> tuple[slice[int, int, None], slice[int, int, None], float]:
    """Rows and columns that may show a cylinder, and the greatest inverse depth [1/m] there.

    Args:
        frame: The aimed camera.
        corners: Of the box around the cylinder, in the camera's frame [m], shape (8, 3).
    """
    if corners[:, 2].min() <= _NEAREST:
        return slice(0, frame.height), slice(0, frame.width), math.inf
    inverse = 1.0 / corners[:, 2]
    across = corners[:, 0] * inverse * frame.focal + frame.width / 2
    down = frame.height / 2 - corners[:, 1] * inverse * frame.focal
    return _within(down, frame.height), _within(across, frame.width), float(inverse.max())


def _within(places: npt.NDArray[np.float64], count: int) -> slice[int, int, None]:
    first = min(max(math.floor(places.min()) - 1, 0), count)
    return slice(first, max(first, min(math.ceil(places.max()) + 1, count)))


class _Mantle:
    """The part of a frame that may show one cylinder."""

    def __init__(
        self,
        view: View,
        frame: CameraFrame,
        rows: slice[int, int, None],
        columns: slice[int, int, None],
        x: float,
        y: float,
        radius: float,
    ) -> None:
        self._eye_z = view.z
        self._to_axis = np.array((x - view.x, y - view.y))
        self._radius = radius
        self._known = frame.inverse_depth[rows, columns]
        self._things = frame.thing[rows, columns]
        self._ray_x, self._ray_y = frame.ray_x[rows, columns], frame.ray_y[rows, columns]
        level = frame.ray_z.shape[1] == 1
        self._ray_z = frame.ray_z[rows] if level else frame.ray_z[rows, columns]

    def draw(self, low: float, high: float, thing: int) -> None:
        """Draw the mantle, and the end that the camera can see."""
        self._draw_mantle(low, high, thing)
        if not low <= self._eye_z <= high:
            self._draw_end(high if self._eye_z > high else low, thing)

    def _draw_mantle(self, low: float, high: float, thing: int) -> None:
        """|depth * ray - to_axis| = radius, solved for the smaller depth."""
        ray_x, ray_y, to_axis = self._ray_x, self._ray_y, self._to_axis
        squared = ray_x * ray_x + ray_y * ray_y
        half = ray_x * to_axis[0] + ray_y * to_axis[1]
        apart = float(to_axis @ to_axis) - self._radius * self._radius
        inside = half * half - squared * apart
        crosses = (inside > 0.0) & (half > 0.0)
        # A ray straight down is parallel to the mantle, and its depth is not a number.
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (half - np.sqrt(np.maximum(inside, 0.0))) / squared
            at = self._eye_z + depth * self._ray_z
            inverse = 1.0 / depth
        self._put(crosses & (at >= low) & (at <= high), inverse, thing)

    def _draw_end(self, end: float, thing: int) -> None:
        """The disc at the top, seen from above, or at the bottom, seen from below."""
        inverse = np.broadcast_to(self._ray_z / (end - self._eye_z), self._ray_x.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.hypot(
                self._ray_x / inverse - self._to_axis[0], self._ray_y / inverse - self._to_axis[1]
            )
        self._put(away <= self._radius, inverse, thing)

    def _put(
        self, covered: npt.NDArray[np.bool_], inverse: npt.NDArray[np.floating], thing: int
    ) -> None:
        drawn = covered & (inverse > self._known)
        np.copyto(self._known, inverse, where=drawn, casting="same_kind")
        np.copyto(self._things, thing, where=drawn)
