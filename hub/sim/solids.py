"""Rays in space among the boxes and upright cylinders of an arena."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.plane_rays import NO_COMPONENT, slab
from hub.values import dataclass

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solids:
    """All solids of an arena, or some of them.

    Attributes:
        low: Least corner of each box [m], shape (b, 3).
        high: Greatest corner of each box [m], shape (b, 3).
        centre: Axis of each cylinder [m], shape (c, 2).
        radius: Radius of each cylinder [m], shape (c,).
        span: Height of the lower and of the upper side of each cylinder [m], shape (c, 2).
        brightness: Share of infrared light that each reflects, boxes first, shape (b + c,).
    """

    low: Floats
    high: Floats
    centre: Floats
    radius: Floats
    span: Floats
    brightness: Floats

    def around(self, x: float, y: float, reach: float, low: float, high: float) -> Solids:
        """Those within reach of a point [m], seen from above, and between two heights [m]."""
        point = np.array((x, y))
        beyond = np.maximum(np.maximum(self.low[:, :2] - point, point - self.high[:, :2]), 0.0)
        boxes = np.hypot(*beyond.T) <= reach
        boxes &= (self.low[:, 2] <= high) & (self.high[:, 2] >= low)
        cylinders = np.hypot(*(self.centre - point).T) - self.radius <= reach
        cylinders &= (self.span[:, 0] <= high) & (self.span[:, 1] >= low)
        return Solids(
            low=self.low[boxes],
            high=self.high[boxes],
            centre=self.centre[cylinders],
            radius=self.radius[cylinders],
            span=self.span[cylinders],
            brightness=self.brightness[np.concatenate((boxes, cylinders))],
        )

    def hits(self, origins: Floats, rays: Floats) -> tuple[Floats, npt.NDArray[np.intp]]:
        """The first hits of rays.

        Args:
            origins: Where they begin, outside of all solids [m], shape (n, 3).
            rays: Unit vectors, shape (n, 3).

        Returns:
            Distance [m], inf for none, and number of the solid, boxes first, -1 for none; each of
            shape (n,).
        """
        ways = np.concatenate((self._to_boxes(origins, rays), self._to_cylinders(origins, rays)))
        if not len(ways):
            return np.full(len(rays), np.inf), np.full(len(rays), -1)
        number = ways.argmin(axis=0)
        distance = ways[number, np.arange(len(rays))]
        return distance, np.where(np.isfinite(distance), number, -1)

    def _to_boxes(self, origins: Floats, rays: Floats) -> Floats:
        """Distance to each box, inf for none, shape (b, n); slab method (Kay and Kajiya 1986)."""
        slabs = [
            slab(self.low[:, axis, None], self.high[:, axis, None], origins, rays, axis)
            for axis in range(3)
        ]
        return _entered(slabs)

    def _to_cylinders(self, origins: Floats, rays: Floats) -> Floats:
        """Distance to each cylinder, inf for none, shape (c, n)."""
        flat = np.maximum(np.hypot(rays[:, 0], rays[:, 1]), NO_COMPONENT)
        to_x = self.centre[:, :1] - origins[:, 0]
        to_y = self.centre[:, 1:] - origins[:, 1]
        along = (to_x * rays[:, 0] + to_y * rays[:, 1]) / flat
        beside = (to_x * rays[:, 1] - to_y * rays[:, 0]) / flat
        under = np.square(self.radius)[:, None] - beside * beside
        half = np.sqrt(np.maximum(under, 0.0))
        near = np.where(under >= 0.0, (along - half) / flat, np.inf)
        round_about = near, (along + half) / flat
        upright = slab(self.span[:, :1], self.span[:, 1:], origins, rays, 2)
        return _entered([round_about, upright])


def solids_of(arena: Arena) -> Solids:
    """The solids of an arena."""
    boxes, cylinders = arena.boxes, arena.cylinders
    surfaces = [box.surface for box in boxes] + [item.surface for item in cylinders]
    return Solids(
        low=np.array([box.low for box in boxes]).reshape(-1, 3),
        high=np.array([box.high for box in boxes]).reshape(-1, 3),
        centre=np.array([(item.x, item.y) for item in cylinders]).reshape(-1, 2),
        radius=np.array([item.radius for item in cylinders], dtype=np.float64),
        span=np.array([(item.low, item.high) for item in cylinders]).reshape(-1, 2),
        brightness=np.array([sum(each.colour) / 765.0 for each in surfaces], dtype=np.float64),
    )


def _entered(slabs: list[tuple[Floats, Floats]]) -> Floats:
    """Where rays enter what is common to all slabs, inf where they do not; shape (solids, n)."""
    enter = np.maximum.reduce([first for first, _ in slabs])
    leave = np.minimum.reduce([last for _, last in slabs])
    return np.where((enter <= leave) & (enter >= 0.0), enter, np.inf)
