"""Draws the view of a camera in the arena, exactly to the pixel, with numpy alone.

Every ray is (across, up, 1) in the camera's frame, so depth is measured along the optical axis. On
a plane the inverse of the depth is linear in the pixel's column and row. A side of a box is the set
of pixels between linear edges; so a side costs a few operations on its bounding box only.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.camera.faces import CEILING, FLOOR, PLANES, make_faces
from hub.sim.camera.lighting import FULL, Lighting
from hub.sim.camera.shading import Shader
from hub.sim.camera.view import BACKGROUND_DEPTH, CameraFrame, View
from hub.values import dataclass

_NEAREST = 1e-6
_STEEP = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Candidates:
    """Sides that may be seen, nearest first, with the pixels they cover.

    Attributes:
        face: Numbers of the sides, shape (n,).
        first: First covered column of each row, shape (n, height).
        end: Column after the last covered one of each row, shape (n, height).
        bounds: First row, end row, first column, end column, n entries.
        inverse_across: Part of the inverse depth that depends on the column [1/m], (n, width).
        inverse_down: Part of the inverse depth that depends on the row [1/m], (n, height).
        nearest: Upper bound of the inverse depth within the bounds [1/m], n entries.
    """

    face: list[int]
    first: npt.NDArray[np.int16]
    end: npt.NDArray[np.int16]
    bounds: list[list[int]]
    inverse_across: npt.NDArray[np.float32]
    inverse_down: npt.NDArray[np.float32]
    nearest: list[float]


class RayCaster:
    """Draws one arena; keeps its working memory between pictures, so it belongs to one thread."""

    def __init__(self, arena: Arena) -> None:
        self._faces = make_faces(arena)
        self._ceiling = arena.ceiling
        self._shader = Shader(self._faces)
        self._frames: dict[tuple[int, int], CameraFrame] = {}

    def picture(
        self, view: View, width_px: int, height_px: int, lighting: Lighting = FULL
    ) -> npt.NDArray[np.uint8]:
        """The camera's view, shape (height, width, 3), red, green, blue."""
        frame = self._cast(view, width_px, height_px)
        return self._shader.shade(view, frame, lighting)

    def depth(self, view: View, width_px: int, height_px: int) -> npt.NDArray[np.float32]:
        """Distance along the optical axis [m], shape (height, width), at most BACKGROUND_DEPTH."""
        frame = self._cast(view, width_px, height_px)
        return 1.0 / frame.inverse_depth

    def _cast(self, view: View, width_px: int, height_px: int) -> CameraFrame:
        """Find the object and its depth for every pixel."""
        size = (width_px, height_px)
        frame = self._frames.get(size)
        if frame is None:
            frame = self._frames[size] = CameraFrame(width_px, height_px)
        frame.aim(view)
        self._draw_planes(view, frame)
        if len(self._faces.axis):
            self._draw_faces(frame, self._candidates(view, frame))
        for number, cylinder in enumerate(self._faces.cylinders.tolist()):
            thing = PLANES + len(self._faces.axis) + number
            _draw_cylinder(view, frame, cylinder, thing)
        return frame

    def _draw_planes(self, view: View, frame: CameraFrame) -> None:
        """Floor and ceiling: the camera does not roll, so each row shows one of them."""
        down = -frame.ray_z
        to_floor = down / view.z
        to_ceiling = -down / (self._ceiling - view.z)
        inverse = np.maximum(np.maximum(to_floor, to_ceiling), 1.0 / BACKGROUND_DEPTH)
        frame.inverse_depth[:] = inverse[:, None]
        frame.thing[:] = np.where(down > 0.0, FLOOR, CEILING)[:, None]

    def _candidates(self, view: View, frame: CameraFrame) -> _Candidates:
        """The sides that face the camera and reach into the picture."""
        faces = self._faces
        distance = (view.eye[faces.axis] - faces.coordinate) * faces.sign
        facing = np.flatnonzero(distance > _NEAREST)
        corners = (faces.corners[facing] - view.eye) @ frame.basis.T
        kept = _in_sight(corners, frame)
        facing, corners = facing[kept], corners[kept]
        first, end = _row_spans(corners, frame)
        covered = end > first
        seen = covered.any(axis=1)
        # Squared distance to the nearest corner orders well enough: order is for speed only.
        order = np.flatnonzero(seen)
        order = order[np.argsort((corners[order] ** 2).sum(axis=2).min(axis=1))]
        facing, first, end, covered = facing[order], first[order], end[order], covered[order]
        bounds = np.stack(
            (
                covered.argmax(axis=1),
                frame.height - covered[:, ::-1].argmax(axis=1),
                np.where(covered, first, frame.width).min(axis=1, initial=frame.width),
                np.where(covered, end, 0).max(axis=1, initial=0),
            ),
            axis=1,
        )
        # Inverse depth: component of the ray along the side's axis over the distance of its plane.
        axis = faces.axis[facing]
        per_metre = 1.0 / (faces.coordinate[facing] - view.eye[axis])
        along = frame.basis[:, axis] * per_metre
        across = along[0][:, None] * frame.across
        down = along[1][:, None] * frame.up + along[2][:, None]
        rows = np.arange(len(facing))
        nearest = np.maximum(across[rows, bounds[:, 2]], across[rows, bounds[:, 3] - 1])
        nearest += np.maximum(down[rows, bounds[:, 0]], down[rows, bounds[:, 1] - 1])
        return _Candidates(
            face=facing.tolist(),
            first=first,
            end=end,
            bounds=bounds.tolist(),
            inverse_across=across.astype(np.float32),
            inverse_down=down.astype(np.float32),
            nearest=nearest.tolist(),
        )

    def _draw_faces(self, frame: CameraFrame, candidates: _Candidates) -> None:
        for number, face in enumerate(candidates.face):
            top, bottom, left, right = candidates.bounds[number]
            known = frame.inverse_depth[top:bottom, left:right]
            if known.min() >= candidates.nearest[number]:
                continue
            across = candidates.inverse_across[number, left:right]
            down = candidates.inverse_down[number, top:bottom, None]
            inverse = np.add(across, down, out=frame.scratch[top:bottom, left:right])
            columns = frame.columns[left:right]
            drawn = inverse > known
            drawn &= columns >= candidates.first[number, top:bottom, None]
            drawn &= columns < candidates.end[number, top:bottom, None]
            np.copyto(known, inverse, where=drawn)
            np.copyto(frame.thing[top:bottom, left:right], PLANES + face, where=drawn)


def _in_sight(corners: npt.NDArray[np.float64], frame: CameraFrame) -> npt.NDArray[np.bool_]:
    """False for sides with all corners beyond one edge of the picture, shape (n,)."""
    x, y, z = corners[..., 0], corners[..., 1], corners[..., 2]
    wide, high = frame.half_width * z, frame.half_height * z
    beyond = np.stack((z <= 0.0, x > wide, x < -wide, y > high, y < -high))
    return np.logical_not(beyond.all(axis=2).any(axis=0))


def _row_spans(
    corners: npt.NDArray[np.float64], frame: CameraFrame
) -> tuple[npt.NDArray[np.int16], npt.NDArray[np.int16]]:
    """First column and end column of each side in every row, each of shape (n, height).

    The eye and two neighbouring corners span a plane; a ray hits the side when it is on the inner
    side of all four. This holds for sides that reach behind the camera, too.
    """
    normals = np.cross(corners, np.roll(corners, -1, axis=1))
    slope = normals[..., 0]
    slope = np.where(np.abs(slope) < _STEEP, _STEEP, slope)[..., None]
    value = normals[..., 1, None] * frame.up + normals[..., 2, None]
    bound = -value / slope
    least = np.where(slope > 0.0, bound, -np.inf).max(axis=1)
    greatest = np.where(slope < 0.0, bound, np.inf).min(axis=1)
    middle = frame.width / 2 - 0.5
    first = np.ceil(np.clip(least * frame.focal + middle, 0, frame.width))
    end = np.floor(np.clip(greatest * frame.focal + middle, -1, frame.width - 1)) + 1
    return first.astype(np.int16), end.astype(np.int16)


def _draw_cylinder(view: View, frame: CameraFrame, cylinder: list[float], thing: int) -> None:
    """Mantle and top of an upright cylinder, within the columns it can cover."""
    x, y, radius, low, high = cylinder
    to_axis = np.array((x - view.x, y - view.y))
    columns = _cylinder_columns(frame, to_axis, radius)
    if columns.start >= columns.stop:
        return
    ray_x, ray_y = frame.ray_x[:, columns], frame.ray_y[:, columns]
    ray_z = frame.ray_z[:, None]
    # |depth * ray - to_axis| = radius, solved for the smaller depth.
    squared = ray_x * ray_x + ray_y * ray_y
    half = ray_x * to_axis[0] + ray_y * to_axis[1]
    apart = float(to_axis @ to_axis) - radius * radius
    inside = half * half - squared * apart
    crosses = (inside > 0.0) & (half > 0.0)
    depth = (half - np.sqrt(np.maximum(inside, 0.0))) / squared
    at = view.z + depth * ray_z
    known, things = frame.inverse_depth[:, columns], frame.thing[:, columns]
    with np.errstate(divide="ignore"):
        inverse = 1.0 / depth
    drawn = crosses & (at >= low) & (at <= high) & (inverse > known)
    np.copyto(known, inverse, where=drawn, casting="same_kind")
    np.copyto(things, thing, where=drawn)
    end = high if view.z > high else low
    if not low <= view.z <= high:
        inverse = np.broadcast_to(ray_z / (end - view.z), squared.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.hypot(ray_x / inverse - to_axis[0], ray_y / inverse - to_axis[1])
        drawn = (inverse > known) & (away <= radius)
        np.copyto(known, inverse, where=drawn, casting="same_kind")
        np.copyto(things, thing, where=drawn)


def _cylinder_columns(
    frame: CameraFrame, to_axis: npt.NDArray[np.float64], radius: float
) -> slice[int, int, None]:
    """Columns that may show a cylinder; all of them when it reaches beside the camera."""
    right, _, forward = frame.basis
    level = math.hypot(forward[0], forward[1])
    across = float(right[:2] @ to_axis)
    ahead = float(forward[:2] @ to_axis) / level
    if ahead <= -radius:
        return slice(0, 0)
    # Tilting brings the top or bottom of a picture nearer: ahead counts for the steepest row.
    steep = frame.half_height * math.sqrt(max(0.0, 1.0 - level * level))
    if ahead <= radius:
        return slice(0, frame.width)
    least, most = level - steep, level + steep
    edges = [
        edge * scale / distance
        for edge in (across - radius, across + radius)
        for distance in (ahead - radius, ahead + radius)
        for scale in (least, most)
    ]
    middle = frame.width / 2
    first = min(max(math.floor(min(edges) * frame.focal + middle) - 1, 0), frame.width)
    end = min(max(math.ceil(max(edges) * frame.focal + middle) + 1, 0), frame.width)
    return slice(first, end)
