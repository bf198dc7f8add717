"""What an arena file says, checked: one value for each kind of table, and the names it may use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hub.sim.geometry import Colour, Side

COLOURS: Mapping[str, Colour] = {
    "white": (236, 236, 230),
    "grey": (150, 150, 150),
    "black": (32, 32, 34),
    "red": (214, 40, 40),
    "orange": (240, 130, 20),
    "yellow": (240, 208, 40),
    "green": (40, 160, 72),
    "cyan": (40, 180, 200),
    "blue": (40, 86, 208),
    "violet": (134, 62, 190),
    "pink": (232, 110, 170),
    "brown": (140, 94, 56),
    "sand": (208, 186, 144),
    "brick": (176, 92, 70),
    "slate": (104, 116, 130),
}
SURFACE_TEXTURES = ("plain", "brick", "panel", "wood", "concrete", "fabric", "checker")
FACINGS = {side.name.lower(): side for side in (Side.EAST, Side.NORTH, Side.WEST, Side.SOUTH)}
GAPS = ("right", "up-right", "up", "up-left", "left", "down-left", "down", "down-right")
POSES = ("sitting", "lying")

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class StartSpec:
    """Where the robot starts: `at` [m] and `heading_deg`."""

    at: Point
    heading_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class HallSpec:
    """The hall around the arena: height of its ceiling [m], its floor, its light (0 to 1)."""

    ceiling: float
    floor_colour: Colour
    floor_texture: str
    light: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DoorwaySpec:
    """A gap in a wall: its middle `at` [m] from the wall's begin, `width` and `height` [m]."""

    at: float
    width: float
    height: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class WallSpec:
    """A wall along x or y from `begin` to `end` [m]."""

    begin: Point
    end: Point
    height: float
    thickness: float
    colour: Colour
    texture: str
    doorways: tuple[DoorwaySpec, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxSpec:
    """A box: middle `at`, `size` along x, y, z, and `base`, the height of its bottom [m]."""

    at: Point
    size: tuple[float, float, float]
    base: float
    colour: Colour
    texture: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderSpec:
    """An upright cylinder: axis `at`, `radius`, `height`, and `base` [m]."""

    at: Point
    radius: float
    height: float
    base: float
    colour: Colour
    texture: str


@dataclass(frozen=True, slots=True, kw_only=True)
class VictimSpec:
    """A person to be found: middle `at` [m], which way it looks, `pose`, colour of the clothes."""

    name: str
    at: Point
    facing: Side
    pose: str
    colour: Colour


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkSpec:
    """A coloured sign: middle of its back `at`, `height` of its middle, `size` [m]."""

    name: str
    at: Point
    facing: Side
    height: float
    size: float
    colour: Colour


@dataclass(frozen=True, slots=True, kw_only=True)
class RingSpec:
    """A Landolt C on a white panel: its gap is `gap_mm` wide and on the side `gap`."""

    at: Point
    facing: Side
    height: float
    gap_mm: float
    gap: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ArenaSpec:
    """Everything an arena file says."""

    name: str
    description: str
    start: StartSpec
    hall: HallSpec
    walls: tuple[WallSpec, ...]
    boxes: tuple[BoxSpec, ...]
    cylinders: tuple[CylinderSpec, ...]
    victims: tuple[VictimSpec, ...]
    landmarks: tuple[LandmarkSpec, ...]
    rings: tuple[RingSpec, ...]
