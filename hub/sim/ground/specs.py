"""The tables of an arena file that shape its ground.

Lengths are in metres. `at` is the south-west corner of an element. Elements may stand in each
other: the ground is the highest of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from hub.sim.geometry import Colour, Side
from hub.sim.spec_values import (
    COLOURS,
    FACINGS,
    FARTHEST,
    SURFACE_TEXTURES,
    Point,
    read_colour,
)
from hub.toml_reader import Within, choice, degrees, key, number, numbers, truth, whole_number
from hub.values import dataclass

PATTERNS = ("flat", "hill", "diagonal")

_CORNER = key(numbers(2, -FARTHEST, FARTHEST), meaning="x and y of its south-west corner")
_SIZE = numbers(2, 0.05, 2 * FARTHEST)
_TEXTURE = choice(SURFACE_TEXTURES)
_RISES = choice(FACINGS)
_COUNT = whole_number(1, 20)


def _two_counts(value: object) -> tuple[int, int]:
    numbers(2, 1, 20)(value)
    first, second = map(_COUNT, value if isinstance(value, list) else ())
    return first, second


TILE = 1.2
"""Side of a tile of ramps [m]."""
_TILES = Within(_two_counts, f"each {_COUNT.allowed}")


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainSpec:
    """How fine the ground is."""

    cell: float = key(number(0.01, 0.1), 0.025, "side of the squares that the ground is made of")


@dataclass(frozen=True, slots=True, kw_only=True)
class RampSpec:
    """A ramp; a raised floor where `low` is `high`."""

    at: Point = _CORNER
    size: Point = key(_SIZE, meaning="along x and y")
    rises: Side = key(_RISES, Side.EAST, "the way up", without="`east`")
    low: float = key(number(0.0, 5.0), 0.0, "height of its lower end")
    high: float = key(number(0.0, 5.0), meaning="height of its upper end")
    colour: Colour = key(read_colour, COLOURS["sand"])
    texture: str = key(_TEXTURE, "wood")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        return self.size


@dataclass(frozen=True, slots=True, kw_only=True)
class RampFieldSpec:
    """Tiles of two or four half ramps after ASTM E2826 (continuous) and E2827 (crossing)."""

    at: Point = _CORNER
    tiles: tuple[int, int] = key(_TILES, meaning="number of tiles of 1.2 m along x and along y")
    angle: float = key(
        degrees(1.0, 45.0), math.radians(15.0), "steepness", at="angle_deg", without="15"
    )
    crossing: bool = key(
        truth,
        default=True,
        meaning="half ramps across each other, with steps between them, or one wave along x",
    )
    colour: Colour = key(read_colour, COLOURS["sand"])
    texture: str = key(_TEXTURE, "wood")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        return TILE * self.tiles[0], TILE * self.tiles[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class StepfieldSpec:
    """A field of square posts (Jacoff et al. 2008, ASTM E2828)."""

    at: Point = _CORNER
    pattern: str = key(
        choice(PATTERNS), "flat", "1 or 2 units high, or with a ridge along y or along the diagonal"
    )
    unit: float = key(
        number(0.01, 0.2), 0.05, "what heights are multiples of: 0.05 half cubic, 0.1 full cubic"
    )
    posts: int = key(whole_number(2, 60), 11, "posts along each side")
    post: float = key(number(0.05, 0.5), 0.1, "side of a post")
    seed: int = key(whole_number(0, 1_000_000), 0, "another number makes other heights")
    colour: Colour = key(read_colour, COLOURS["brown"])
    texture: str = key(_TEXTURE, "wood")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        return self.posts * self.post, self.posts * self.post


@dataclass(frozen=True, slots=True, kw_only=True)
class StairsSpec:
    """Straight stairs with a landing."""

    at: Point = _CORNER
    width: float = key(number(0.2, 10.0), 1.2)
    steps: int = key(whole_number(1, 40), 5, "number of steps, the landing with them")
    rise: float = key(number(0.01, 0.5), 0.2, "height of a step")
    run: float = key(number(0.05, 2.0), 0.24, "depth of a step")
    landing: float = key(number(0.0, 10.0), 1.2, "depth of the landing, from the last edge on")
    rises: Side = key(_RISES, Side.EAST, "the way up", without="`east`")
    colour: Colour = key(read_colour, COLOURS["orange"])
    texture: str = key(_TEXTURE, "wood")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        length = (self.steps - 1) * self.run + max(self.landing, self.run)
        return (length, self.width) if self.rises.axis == 0 else (self.width, length)


@dataclass(frozen=True, slots=True, kw_only=True)
class PipeSpec:
    """A pipe that lies; below its axis it is solid down to the floor."""

    at: Point = _CORNER
    length: float = key(number(0.1, 50.0))
    along: str = key(choice(("x", "y")), "y")
    radius: float = key(number(0.02, 0.5), 0.05)
    height: float = key(number(0.01, 2.0), meaning="height of its top above the floor")
    turning: bool = key(
        truth, default=True, meaning="it turns freely, so nothing can push itself off it"
    )
    colour: Colour = key(read_colour, COLOURS["white"])
    texture: str = key(_TEXTURE, "plain")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        across = 2 * self.radius
        return (self.length, across) if self.along == "x" else (across, self.length)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeckSpec:
    """A floor above the ground: to drive on, and to drive under."""

    at: Point = _CORNER
    size: Point = key(_SIZE, meaning="along x and y")
    height: float = key(number(0.05, 5.0), meaning="height of its upper side")
    thickness: float = key(number(0.01, 1.0), 0.05)
    colour: Colour = key(read_colour, COLOURS["brown"])
    texture: str = key(_TEXTURE, "wood")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        return self.size


@dataclass(frozen=True, slots=True, kw_only=True)
class GripSpec:
    """How well wheels grip in a rectangle, on all that is there."""

    at: Point = _CORNER
    size: Point = key(_SIZE, meaning="along x and y")
    grip: float = key(
        number(0.0, 2.0), meaning="share of the grip on a dry floor: sand 0.4, wet 0.6, carpet 1.2"
    )
    colour: Colour | None = key(read_colour, None, without="the ground's")
    texture: str | None = key(_TEXTURE, None, without="the ground's")

    @property
    def extent(self) -> Point:
        """Its size along x and y [m]."""
        return self.size


ElementSpec = RampSpec | RampFieldSpec | StepfieldSpec | StairsSpec | PipeSpec
"""Elements that are part of the one height map."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundSpec:
    """What an arena file says of its ground."""

    terrain: TerrainSpec = TerrainSpec()
    ramps: tuple[RampSpec, ...] = ()
    ramp_fields: tuple[RampFieldSpec, ...] = ()
    stepfields: tuple[StepfieldSpec, ...] = ()
    stairs: tuple[StairsSpec, ...] = ()
    pipes: tuple[PipeSpec, ...] = ()
    decks: tuple[DeckSpec, ...] = ()
    grips: tuple[GripSpec, ...] = ()

    @property
    def elements(self) -> tuple[ElementSpec, ...]:
        """All elements of the height map."""
        return (*self.ramps, *self.ramp_fields, *self.stepfields, *self.stairs, *self.pipes)


GROUND_TABLES: Mapping[str, tuple[type, str]] = {
    "ramp": (RampSpec, "ramps"),
    "ramps": (RampFieldSpec, "ramp_fields"),
    "stepfield": (StepfieldSpec, "stepfields"),
    "stairs": (StairsSpec, "stairs"),
    "pipe": (PipeSpec, "pipes"),
    "deck": (DeckSpec, "decks"),
    "surface": (GripSpec, "grips"),
}
"""Name of each repeated table, its class, and its field of `GroundSpec`."""
