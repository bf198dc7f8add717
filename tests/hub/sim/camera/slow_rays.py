"""An independent, slow computation of depth: every ray against every solid."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.camera.view import BACKGROUND_DEPTH, View


def rays_of(view: View, width: int, height: int) -> npt.NDArray[np.float64]:
    """Rays through the pixels' centres, 1 long along the optical axis, shape (height, width, 3)."""
    focal = width / 2 / math.tan(view.horizontal_fov / 2)
    right, up, forward = view.basis()
    columns = (np.arange(width) + 0.5 - width / 2) / focal
    rows = (height / 2 - np.arange(height) - 0.5) / focal
    return forward + columns[None, :, None] * right + rows[:, None, None] * up


def slow_depth(arena: Arena, view: View, width: int, height: int) -> npt.NDArray[np.float64]:
    """Slabs for boxes, the quadratic equation for cylinders; shape (height, width) [m]."""
    rays = rays_of(view, width, height)
    eye = view.eye
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[..., 2] < 0, -eye[2], arena.ceiling - eye[2]) / rays[..., 2]
        depth = np.minimum(depth, BACKGROUND_DEPTH)
        for box in arena.boxes:
            first, second = (np.array(box.low) - eye) / rays, (np.array(box.high) - eye) / rays
            enter = np.minimum(first, second).max(axis=2)
            leave = np.maximum(first, second).min(axis=2)
            depth = np.where((enter <= leave) & (enter > 0) & (enter < depth), enter, depth)
        for item in arena.cylinders:
            from_x, from_y = eye[0] - item.x, eye[1] - item.y
            a = rays[..., 0] ** 2 + rays[..., 1] ** 2
            b = rays[..., 0] * from_x + rays[..., 1] * from_y
            root = np.sqrt(b * b - a * (from_x**2 + from_y**2 - item.radius**2))
            ends = [(item.low - eye[2]) / rays[..., 2], (item.high - eye[2]) / rays[..., 2]]
            enter = np.maximum((-b - root) / a, np.minimum(*ends))
            leave = np.minimum((-b + root) / a, np.maximum(*ends))
            depth = np.where((enter <= leave) & (enter > 0) & (enter < depth), enter, depth)
    return depth
