"""Contact of a floating body with solids, the ground and the ceiling."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.afloat.attitude import Vector
from hub.sim.afloat.surroundings import Surroundings
from hub.values import dataclass

TOUCH = 1e-3
"""The body touches what is this near [m]."""
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
        normals: Directions away from what pushed it in the last motion.
    """

    def __init__(self, surroundings: Surroundings, shape: ContactShape) -> None:
        self._surroundings = surroundings
        self._shape = shape
        self._free = 0.0
        self.touched: frozenset[int] = frozenset()
        self.contacts = 0
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
                place = self._pushed_out(wanted)
        if place is None:
            self.normals.append(_away(before, wanted))
            place = before
        x, y, z = place
        lowest = self._surroundings.ground(x, y) + self._shape.below
        highest = self._surroundings.ceiling - self._shape.above
        if z <= lowest:
            self.normals.append(_UP)
        elif z >= highest:
            self.normals.append(_DOWN)
        self.supported = any(normal[2] > 0.0 for normal in self.normals)
        return x, y, max(lowest, min(highest, z))

    def _pushed_out(self, wanted: Vector) -> Vector | None:
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
                self.contacts += len(touched - self.touched)
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


def _away(before: Vector, wanted: Vector) -> Vector:
    """Unit vector back from a motion that is not possible."""
    length = math.dist(before, wanted) or 1.0
    x, y, z = ((old - new) / length for old, new in zip(before, wanted, strict=True))
    return x, y, z
