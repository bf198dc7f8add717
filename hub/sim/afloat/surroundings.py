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
        # From above, a cylinder is a point with a round edge around it.
        edges = [(box.low, box.high, 0.0, box.surface) for box in boxes]
        for each in cylinders:
            axis = (each.x, each.y)
            edges.append(((*axis, each.low), (*axis, each.high), each.radius, each.surface))
        low: Floats = np.array([edge[0] for edge in edges], dtype=np.float64).reshape(-1, 3)
        high: Floats = np.array([edge[1] for edge in edges], dtype=np.float64).reshape(-1, 3)
        middle, half = (low + high) / 2.0, (high - low) / 2.0
        self._middle_x, self._middle_y = middle[:, 0].copy(), middle[:, 1].copy()
        self._half_x, self._half_y = half[:, 0].copy(), half[:, 1].copy()
        self._round = np.array([edge[2] for edge in edges], dtype=np.float64)
        self.bottom: Floats = low[:, 2].copy()
        self.top: Floats = high[:, 2].copy()
        self._soft = np.array([edge[3].texture in _SOFT for edge in edges], dtype=np.bool_)
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
        beyond_x = np.abs(x - self._middle_x) - self._half_x
        beyond_y = np.abs(y - self._middle_y) - self._half_y
        outside = np.hypot(np.maximum(beyond_x, 0.0), np.maximum(beyond_y, 0.0))
        inside = np.minimum(np.maximum(beyond_x, beyond_y), 0.0)
        distances: Floats = outside + inside - self._round
        return distances

    def direction_from(self, number: int, x: float, y: float) -> tuple[float, float]:
        """Unit vector from a solid's nearest point to a point outside of it; zero if inside."""
        east, north = x - float(self._middle_x[number]), y - float(self._middle_y[number])
        across, along = float(self._half_x[number]), float(self._half_y[number])
        east -= max(-across, min(across, east))
        north -= max(-along, min(along, north))
        length = math.hypot(east, north)
        return (east / length, north / length) if length > 0.0 else (0.0, 0.0)

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
