"""The solids and the ground around a floating body: distances to them, and the view down."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.arena_specs import Area, WaterSpec
from hub.sim.geometry import Box, Cylinder
from hub.sim.ground.height_field import HeightField
from hub.values import dataclass

Floats = npt.NDArray[np.float64]

_SOFT = frozenset({"fabric"})
"""Textures that swallow ultrasound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Below:
    """The first thing below a sensor.

    Attributes:
        distance: To it [m]; negative if the sensor is inside of it.
        soft: Whether it swallows ultrasound.
    """

    distance: float
    soft: bool


class Ground:
    """Floor, rough ground and water, seen from above."""

    def __init__(
        self, height_map: HeightField | None = None, water: WaterSpec | None = None
    ) -> None:
        """Take what stands on the floor.

        Args:
            height_map: What stands out of the floor; None: it is level.
            water: Water that bears a body and echoes; None: none.
        """
        self._heights = None if height_map is None else height_map.heights
        self._cell = 1.0 if height_map is None else height_map.cell
        self._origin = (0.0, 0.0) if height_map is None else height_map.origin
        self._water = water

    def height(self, x: float, y: float) -> float:
        """Height of the ground or water at a place [m]."""
        return self.highest(x, y, 0.0)

    def highest(self, x: float, y: float, reach: float) -> float:
        """Height of the highest ground or water within a square around a place [m].

        Args:
            x: Of the place [m].
            y: Of the place [m].
            reach: Half of the square's side [m].
        """
        highest = 0.0 if self._heights is None else self._highest_cell(self._heights, x, y, reach)
        water = self._water
        if water is None:
            return highest
        if water.area is not None:
            (west, south), (east, north) = water.area
            if not (west - reach < x < east + reach and south - reach < y < north + reach):
                return highest
        return max(highest, water.surface)

    def _highest_cell(
        self, heights: npt.NDArray[np.float32], x: float, y: float, reach: float
    ) -> float:
        west, south = self._origin
        rows, columns = self._cells(y - south, reach), self._cells(x - west, reach)
        return float(heights[rows, columns].max(initial=0.0))

    def _cells(self, distance: float, reach: float) -> slice:
        """Rows or columns around a distance from the map's first edge [m]."""
        first = math.floor((distance - reach) / self._cell)
        last = math.floor((distance + reach) / self._cell)
        return slice(max(0, first), max(0, last + 1))


class Surroundings:
    """The solids of an arena, boxes first, and its ground.

    Attributes:
        bottom: Height of the bottom of each solid [m], shape (n,).
        top: Height of the top of each solid [m], shape (n,).
        ceiling: Height of the ceiling [m].
        ground: Its ground.
        area: South-west and north-east corner of where a body stays [m]; None: everywhere.
    """

    def __init__(
        self,
        boxes: tuple[Box, ...] = (),
        cylinders: tuple[Cylinder, ...] = (),
        *,
        ceiling: float = math.inf,
        ground: Ground | None = None,
        area: Area | None = None,
    ) -> None:
        self._low: Floats = np.array([box.low[:2] for box in boxes]).reshape(-1, 2)
        self._high: Floats = np.array([box.high[:2] for box in boxes]).reshape(-1, 2)
        self._axis: Floats = np.array([(each.x, each.y) for each in cylinders]).reshape(-1, 2)
        self._radius: Floats = np.array([each.radius for each in cylinders], dtype=np.float64)
        bottoms = [box.low[2] for box in boxes] + [each.low for each in cylinders]
        tops = [box.high[2] for box in boxes] + [each.high for each in cylinders]
        textures = [box.surface.texture for box in boxes]
        textures += [each.surface.texture for each in cylinders]
        self.bottom: Floats = np.array(bottoms, dtype=np.float64)
        self.top: Floats = np.array(tops, dtype=np.float64)
        self._soft = np.array([each in _SOFT for each in textures], dtype=np.bool_)
        self.ceiling = ceiling
        self.ground = ground or Ground()
        self.area = area

    @classmethod
    def in_air(cls, arena: Arena) -> Surroundings:
        """Those of a body that flies in an arena: water is ground."""
        ground = Ground(arena.ground, arena.water)
        return cls(arena.boxes, arena.cylinders, ceiling=arena.ceiling, ground=ground)

    @classmethod
    def under_water(cls, arena: Arena) -> Surroundings:
        """Those of a body that dives in an arena: it stays within the water."""
        area = None if arena.water is None else arena.water.area
        return cls(arena.boxes, arena.cylinders, ground=Ground(arena.ground), area=area)

    def distances(self, x: float, y: float) -> Floats:
        """From a point to each solid as seen from above [m]; negative inside, shape (n,)."""
        point = np.array((x, y))
        beyond = np.maximum(self._low - point, point - self._high)
        outside = np.maximum(beyond, 0.0)
        inside = np.minimum(beyond.max(axis=1, initial=-math.inf), 0.0)
        away = self._axis - point
        return np.concatenate(
            (
                np.hypot(outside[:, 0], outside[:, 1]) + inside,
                np.hypot(away[:, 0], away[:, 1]) - self._radius,
            )
        )

    def direction_from(self, number: int, x: float, y: float) -> tuple[float, float]:
        """Unit vector from a solid's nearest point to a point outside of it; zero if inside."""
        boxes = len(self._low)
        if number < boxes:
            near_x, near_y = np.clip((x, y), self._low[number], self._high[number]).tolist()
        else:
            near_x, near_y = self._axis[number - boxes].tolist()
        length = math.hypot(x - near_x, y - near_y)
        return ((x - near_x) / length, (y - near_y) / length) if length > 0.0 else (0.0, 0.0)

    def below(self, x: float, y: float, z: float, half_beam: float) -> Below:
        """The highest thing that a beam straight down meets.

        Args:
            x: Of the sensor [m].
            y: Of the sensor [m].
            z: Of the sensor [m].
            half_beam: Half of the beam's opening [rad].
        """
        floor = z - self.ground.height(x, y)
        if not len(self.top):
            return Below(distance=floor, soft=False)
        depth = z - self.top
        met = (self.distances(x, y) <= depth * math.tan(half_beam)) & (depth > 0.0)
        depth = np.where(met, depth, math.inf)
        nearest = int(depth.argmin())
        if depth[nearest] >= floor:
            return Below(distance=floor, soft=False)
        return Below(distance=float(depth[nearest]), soft=bool(self._soft[nearest]))
