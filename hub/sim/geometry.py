"""The shapes an arena is built of: axis-aligned boxes and upright cylinders with surfaces.

Arena frame: x east, y north, z up [m]; angles counter-clockwise from x [rad].
"""

from __future__ import annotations

import enum

from hub.values import dataclass

Colour = tuple[int, int, int]
"""Red, green, blue, 0 to 255."""

AIR_C = 20.0
"""Temperature of the air, and of what has none of its own [degrees Celsius]."""


class Side(enum.Enum):
    """The direction of one side of a box; the value is (axis, sign)."""

    EAST = (0, 1)
    WEST = (0, -1)
    NORTH = (1, 1)
    SOUTH = (1, -1)
    UP = (2, 1)
    DOWN = (2, -1)

    @property
    def axis(self) -> int:
        """0 for x, 1 for y, 2 for z."""
        return self.value[0]

    @property
    def sign(self) -> int:
        """1: along the axis; -1: against it."""
        return self.value[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """The appearance of a side.

    Attributes:
        texture: A name from `textures.TEXTURES`.
        colour: Tint of the texture.
        temperature: [degrees Celsius].
    """

    texture: str
    colour: Colour
    temperature: float = AIR_C


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A box along the axes.

    Attributes:
        low: Least x, y, z [m].
        high: Greatest x, y, z [m].
        surface: Its appearance.
        picture_side: The side that carries `picture` once over its whole area, or None.
        picture: Appearance of that side.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    surface: Surface
    picture_side: Side | None = None
    picture: Surface | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cylinder:
    """An upright cylinder.

    Attributes:
        x: Axis [m].
        y: Axis [m].
        radius: Radius [m].
        low: Height of its bottom [m].
        high: Height of its top [m].
        surface: Its appearance.
    """

    x: float
    y: float
    radius: float
    low: float
    high: float
    surface: Surface
