"""The sides of an arena's solids as arrays, computed once for the ray caster."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.camera.textures import SIDE as TEXELS
from hub.sim.camera.textures import Atlas, make_atlas
from hub.sim.geometry import Box, Cylinder, Side, Surface
from hub.values import dataclass

FLOOR = 0
CEILING = 1
PLANES = 2
"""Index of the first side: floor and ceiling come first, then boxes' sides, then cylinders."""


_BRIGHTNESS = {0: 1.0, 1: 0.84, 2: 1.08}
"""Light from above and from the east, so that two walls that meet differ, by axis."""
_GROUND_LOOKS = ((True, True, 1.1), (False, False, 0.78), (False, True, 0.64))
"""`flat`, `across_x` and `brightness` of the ground's tops, sides facing x, and sides facing y."""
GROUND_SIDES = len(_GROUND_LOOKS)
"""A surface of the ground is drawn as this number of things."""
_POSITIVE = 128.0 * TEXELS
"""Added to texel coordinates [texels]: a whole number of tiles that makes all of them positive."""
_SHRINK = 0.998
"""Keeps the rim of a picture from wrapping around to its other side."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Faces:
    """Everything that is drawn: f sides of boxes, c cylinders, s surfaces of the ground.

    Arrays of "things" have one entry for floor, ceiling, each side and each cylinder, in this
    order. `GROUND_SIDES` for each surface of a height map follow, so they have 2 + f + c + 3 s.

    Attributes:
        corners: Corners of each side, counter-clockwise from outside [m], shape (f, 4, 3).
        axis: Which coordinate is constant on a side, shape (f,).
        coordinate: That coordinate [m], shape (f,).
        sign: Whether a side faces along its axis (1) or against it (-1), shape (f,).
        cylinders: x, y, radius, low, high of each cylinder [m], shape (c, 5).
        cylinder_corners: Corners of the upright box around each cylinder [m], shape (c, 8, 3).
        first_texel: Texel index of each thing's material at level 0, shape (things,).
        flat: Whether a thing's texture is horizontal, shape (things,).
        across_x: Whether the texture runs along x from left to right, shape (things,).
        column_scale: Texels per metre from left to right, shape (things,).
        column_offset: Texel column at coordinate 0, shape (things,).
        row_scale: Texels per metre of the downward coordinate, shape (things,).
        row_offset: Texel row at coordinate 0, shape (things,).
        brightness: Share of light each thing gets, shape (things,).
        first_ground: Number of the first thing that is ground.
        atlas: The textures.
    """

    corners: npt.NDArray[np.float64]
    axis: npt.NDArray[np.intp]
    coordinate: npt.NDArray[np.float64]
    sign: npt.NDArray[np.float64]
    cylinders: npt.NDArray[np.float64]
    cylinder_corners: npt.NDArray[np.float64]
    first_texel: npt.NDArray[np.int32]
    flat: npt.NDArray[np.bool_]
    across_x: npt.NDArray[np.bool_]
    column_scale: npt.NDArray[np.float32]
    column_offset: npt.NDArray[np.float32]
    row_scale: npt.NDArray[np.float32]
    row_offset: npt.NDArray[np.float32]
    brightness: npt.NDArray[np.float32]
    first_ground: int
    atlas: Atlas


@dataclass(frozen=True, slots=True)
class _Face:
    box: Box
    side: Side

    @property
    def pictured(self) -> bool:
        return self.box.picture_side is self.side and self.box.picture is not None

    @property
    def surface(self) -> Surface:
        picture = self.box.picture
        return picture if self.pictured and picture is not None else self.box.surface

    def corners(self) -> npt.NDArray[np.float64]:
        """Four corners, counter-clockwise as seen from outside, shape (4, 3)."""
        axis, sign = self.side.axis, self.side.sign
        first, second = (axis + 1) % 3, (axis + 2) % 3
        corners = np.empty((4, 3))
        corners[:, axis] = self.box.high[axis] if sign > 0 else self.box.low[axis]
        low, high = self.box.low, self.box.high
        corners[:, first] = [low[first], high[first], high[first], low[first]]
        corners[:, second] = [low[second], low[second], high[second], high[second]]
        return corners if sign > 0 else corners[::-1]


@dataclass(frozen=True, slots=True)
class _Look:
    """How a thing looks; see `Faces`."""

    surface: Surface
    flat: bool
    across_x: bool
    brightness: float


def _looks(arena: Arena, faces: list[_Face]) -> Iterator[_Look]:
    """The looks of all things but the rough ground, in their order."""
    yield _Look(arena.floor, flat=True, across_x=True, brightness=1.24)
    yield _Look(arena.overhead, flat=True, across_x=True, brightness=1.0)
    for face in faces:
        axis = face.side.axis
        yield _Look(face.surface, axis == 2, axis != 0, _BRIGHTNESS[axis])
    for item in arena.cylinders:
        yield _Look(item.surface, flat=False, across_x=True, brightness=1.0)


def make_faces(arena: Arena) -> Faces:
    """Prepare an arena for drawing."""
    # The undersides of objects on the floor are never seen.
    faces = [
        _Face(box, side)
        for box in arena.boxes
        for side in Side
        if side is not Side.DOWN or box.low[2] > 0.0
    ]
    looks = list(_looks(arena, faces))
    first_ground = len(looks)
    if arena.ground is not None:
        looks += [_Look(each, *look) for each in arena.ground.surfaces for look in _GROUND_LOOKS]
    atlas = make_atlas([look.surface for look in looks])
    material = np.array([atlas.index[look.surface] for look in looks])
    levels_stride = len(atlas.planes[0]) // len(atlas.index)
    mapping = _mapping(faces, atlas.tile[material])
    axis = np.array([face.side.axis for face in faces], dtype=np.intp)
    corners = np.array([face.corners() for face in faces]).reshape(-1, 4, 3)
    return Faces(
        corners=corners,
        axis=axis,
        coordinate=corners[np.arange(len(faces)), 0, axis],
        sign=np.array([face.side.sign for face in faces], dtype=np.float64),
        cylinders=np.array(
            [(item.x, item.y, item.radius, item.low, item.high) for item in arena.cylinders],
            dtype=np.float64,
        ).reshape(-1, 5),
        cylinder_corners=np.array(
            [_corners_around(item) for item in arena.cylinders], dtype=np.float64
        ).reshape(-1, 8, 3),
        first_texel=(material * levels_stride).astype(np.int32),
        flat=np.array([look.flat for look in looks]),
        across_x=np.array([look.across_x for look in looks]),
        column_scale=mapping[:, 0].astype(np.float32),
        column_offset=mapping[:, 1].astype(np.float32),
        row_scale=mapping[:, 2].astype(np.float32),
        row_offset=mapping[:, 3].astype(np.float32),
        brightness=np.array([look.brightness for look in looks], dtype=np.float32),
        first_ground=first_ground,
        atlas=atlas,
    )


def _corners_around(item: Cylinder) -> list[tuple[float, float, float]]:
    x, y, radius = item.x, item.y, item.radius
    sides = ((x - radius, x + radius), (y - radius, y + radius), (item.low, item.high))
    return list(itertools.product(*sides))


def _mapping(faces: list[_Face], tile: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Scale and offset of texel column and row of every thing, shape (things, 4)."""
    per_metre = TEXELS / tile
    mapping = np.empty((len(tile), 4))
    mapping[:, 0] = per_metre
    mapping[:, 1] = _POSITIVE
    mapping[:, 2] = -per_metre
    mapping[:, 3] = _POSITIVE
    for thing, face in enumerate(faces, start=PLANES):
        if face.pictured:
            mapping[thing] = _picture_mapping(face)
    return mapping


def _picture_mapping(face: _Face) -> tuple[float, float, float, float]:
    """Scale and offset such that a picture fills the side once, upright and not mirrored."""
    low, high = face.box.low, face.box.high
    across = 1 if face.side.axis == 0 else 0
    down = 1 if face.side.axis == 2 else 2
    # Seen from the east, an east side has north, larger y, at the right; north sides are mirrored.
    to_right = face.side.sign if face.side.axis != 1 else -face.side.sign
    columns = to_right * TEXELS * _SHRINK / (high[across] - low[across])
    rows = -TEXELS * _SHRINK / (high[down] - low[down])
    left = low[across] if to_right > 0 else high[across]
    margin = TEXELS * (1.0 - _SHRINK) / 2
    return columns, margin - columns * left, rows, margin - rows * high[down]
