"""Contact of a floating body with solids, the ground and the ceiling."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.afloat.attitude import Vector
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.contact import NO_IMPACT, Impact
from hub.values import dataclass

TOUCH = 1e-3
"""The body touches what is this near [m]."""
LEDGE = 0.05
"""The body slides over ground that rises by less in a step [m]."""
_GAP = 1e-6
"""Distance that is left when the body is pushed out of something [m]."""
_PUSHES = 6
_UP: Vector = (0.0, 0.0, 1.0)
_DOWN: Vector = (0.0, 0.0, -1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactShape:
    """An upright cylinder around the body; it does not tilt with it.

    Attributes:
        radius: [m]
        above: Top above the body's middle [m].
        below: Bottom below the body's middle [m].
    """

    radius: float
    above: float
    below: float


class BodyContact:
    """Keeps a body out of its surroundings.

    Attributes:
        touched: Numbers of the solids that it touches.
        contacts: Number of new contacts with a solid.
        supported: Whether something holds it from below.
        impact: The last new contact, in the plane; its bearing counts from the x axis.
        normals: Directions away from what pushed it in the last motion.
    """

    def __init__(self, surroundings: Surroundings, shape: ContactShape) -> None:
        self._surroundings = surroundings
        self._shape = shape
        self._free = 0.0
        self.touched: frozenset[int] = frozenset()
        self.contacts = 0
        self.impact = NO_IMPACT
        self.supported = False
        self.normals: list[Vector] = []

    def move(self, before: Vector, wanted: Vector) -> Vector:
        """The end of a short motion [m]: the body slides along what it meets, or stays."""
        self.normals = []
        place: Vector | None = wanted
        if len(self._surroundings.top):
            self._free -= math.dist(before, wanted)
            # A solid farther than the path since the last check cannot be reached yet.
            if self._free <= TOUCH:
                place = self._pushed_out(before, wanted)
        if place is None:
            place = self._refused(before, wanted)
        place = self._within_area(place)
        x, y, z = place
        shape, ground = self._shape, self._surroundings.ground
        lowest = ground.highest(x, y, shape.radius) + shape.below
        if z < lowest - LEDGE:
            # Ground that rises steeply is a wall.
            x, y, z = self._refused((*before[:2], z), place)
            lowest = ground.highest(x, y, shape.radius) + shape.below
        highest = self._surroundings.ceiling - shape.above
        if z <= lowest:
            self.normals.append(_UP)
        elif z >= highest:
            self.normals.append(_DOWN)
        self.supported = any(normal[2] > 0.0 for normal in self.normals)
        return x, y, max(lowest, min(highest, z))

    def _refused(self, before: Vector, wanted: Vector) -> Vector:
        """The place before a motion that is not possible; the motion ends."""
        way = math.dist(before, wanted)
        if way > 0.0:
            x, y, z = ((old - new) / way for old, new in zip(before, wanted, strict=True))
            self.normals.append((x, y, z))
        return before

    def _within_area(self, place: Vector) -> Vector:
        """The nearest place at which the body is within the area."""
        area = self._surroundings.area
        if area is None:
            return place
        (west, south), (east, north) = area
        x, y, z = place
        radius = self._shape.radius
        held_x = max(west + radius, min(east - radius, x))
        held_y = max(south + radius, min(north - radius, y))
        if held_x != x:
            self.normals.append((math.copysign(1.0, held_x - x), 0.0, 0.0))
        if held_y != y:
            self.normals.append((0.0, math.copysign(1.0, held_y - y), 0.0))
        return held_x, held_y, z

    def _pushed_out(self, before: Vector, wanted: Vector) -> Vector | None:
        """The wanted place moved out of solids by the shortest ways; None if that fails."""
        shape, solids = self._shape, self._surroundings
        x, y, z = wanted
        for _ in range(_PUSHES):
            across = solids.distances(x, y) - shape.radius
            along = np.maximum(solids.bottom - z - shape.above, z - shape.below - solids.top)
            gaps = np.maximum(across, along)
            nearest = int(gaps.argmin())
            self._free = gap = float(gaps[nearest])
            if gap >= 0.0:
                touched = frozenset(np.flatnonzero(gaps < TOUCH).tolist())
                for number in touched - self.touched:
                    self.contacts += 1
                    east, north = solids.direction_from(number, x, y)
                    way = wanted[0] - before[0], wanted[1] - before[1]
                    self.impact = Impact.of(math.atan2(-north, -east), 0.0, *way)
                self.touched = touched
                return x, y, z
            out = _GAP - gap
            east, north = solids.direction_from(nearest, x, y)
            if across[nearest] > along[nearest] and (east or north):
                x, y = x + out * east, y + out * north
                self.normals.append((east, north, 0.0))
            else:
                under = z < (solids.bottom[nearest] + solids.top[nearest]) / 2.0
                z += -out if under else out
                self.normals.append(_DOWN if under else _UP)
        return None
