"""Draws the view of a camera in the arena, exactly to the pixel, with numpy alone.

Every ray is (across, up, 1) in the camera's frame, so depth is measured along the optical axis. On
a plane the inverse of the depth is linear in the pixel's column and row. A side of a box is the set
of pixels between linear edges; so a side costs a few operations on its bounding box only.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.camera.cylinders import draw_cylinders
from hub.sim.camera.faces import CEILING, FLOOR, PLANES, make_faces
from hub.sim.camera.lighting import FULL, Lighting
from hub.sim.camera.shading import Shader
from hub.sim.camera.terrain_view import TerrainView
from hub.sim.camera.view import BACKGROUND_DEPTH, CameraFrame, View
from hub.sim.camera.water_view import WaterView
from hub.values import dataclass

_MARGIN = 0.01
"""Least distance of the camera from floor and ceiling [m]."""
_MOST_SIZES = 4
"""Memory is kept for this number of picture sizes, the last ones: operators may ask for any."""
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
        self._terrain = None
        if arena.ground is not None:
            self._terrain = TerrainView(arena.ground, self._faces.first_ground)
        light = None if self._terrain is None else self._terrain.light
        self._shader = Shader(self._faces, light)
        self._water = None if arena.water is None else WaterView(arena.water)
        self._frames: dict[tuple[int, int], CameraFrame] = {}

    def picture(
        self, view: View, width_px: int, height_px: int, lighting: Lighting = FULL
    ) -> npt.NDArray[np.uint8]:
        """The camera's view, shape (height, width, 3), red, green, blue."""
        view = self._inside(view)
        frame = self._cast(view, width_px, height_px)
        if self._water is not None:
            return self._water.picture(view, frame, self._shader, lighting)
        return self._shader.shade(view, frame, lighting)

    def depth(self, view: View, width_px: int, height_px: int) -> npt.NDArray[np.float32]:
        """Distance along the optical axis [m], shape (height, width), at most BACKGROUND_DEPTH."""
        frame = self._cast(self._inside(view), width_px, height_px)
        return 1.0 / frame.inverse_depth

    def _cast(self, view: View, width_px: int, height_px: int) -> CameraFrame:
        """Find the object and its depth for every pixel."""
        size = (width_px, height_px)
        frame = self._frames.pop(size, None) or CameraFrame(width_px, height_px)
        self._frames[size] = frame
        if len(self._frames) > _MOST_SIZES:
            del self._frames[next(iter(self._frames))]
        frame.aim(view)
        self._draw_planes(view, frame)
        if self._terrain is not None:
            self._terrain.draw(view, frame)
        if len(self._faces.axis):
            self._draw_faces(frame, self._candidates(view, frame))
        if len(self._faces.cylinders):
            draw_cylinders(view, frame, self._faces)
        return frame

    def _inside(self, view: View) -> View:
        """The view, from just inside where it is below the floor or above the ceiling."""
        z = min(max(view.z, _MARGIN), self._ceiling - _MARGIN)
        return view if z == view.z else replace(view, z=z)

    def _draw_planes(self, view: View, frame: CameraFrame) -> None:
        """Floor and ceiling: a ray meets one of them, as it goes down or up."""
        down = -frame.ray_z
        to_floor = down / view.z
        to_ceiling = -down / (self._ceiling - view.z)
        inverse = np.maximum(np.maximum(to_floor, to_ceiling), 1.0 / BACKGROUND_DEPTH)
        frame.inverse_depth[:] = inverse
        frame.thing[:] = np.where(down > 0.0, FLOOR, CEILING)

    def _candidates(self, view: View, frame: CameraFrame) -> _Candidates:
        """The sides that face the camera and reach into the picture."""
        faces = self._faces
        distance = (view.eye[faces.axis] - faces.coordinate) * faces.sign
        facing = np.flatnonzero(distance > _NEAREST)
        corners = (faces.corners[facing] - view.eye) @ frame.basis.T
        kept = frame.in_sight(corners)
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
