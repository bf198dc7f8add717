"""The tables of an arena file: a dataclass for each kind, and a key for each of its fields.

Lengths are in metres. The `key` of a field says how the file's value is read, which values it may
have, and what it means; the tables of `docs/writing-an-arena.md` say the same.
"""

from __future__ import annotations

from collections.abc import Mapping

from hub.sim.geometry import Colour, Side
from hub.sim.ground.specs import GroundSpec
from hub.sim.spec_values import (
    COLOURS,
    FACINGS,
    FARTHEST,
    SURFACE_TEXTURES,
    Point,
    read_colour,
)
from hub.toml_reader import (
    RefusedError,
    choice,
    degrees,
    key,
    number,
    numbers,
    shorten,
    text,
    truth,
)
from hub.values import dataclass

GAPS = ("right", "up-right", "up", "up-left", "left", "down-left", "down", "down-right")
POSES = ("sitting", "lying")
WATER_TYPES: Mapping[str, tuple[float, float, float]] = {
    "I": (0.235, 0.043, 0.019),
    "II": (0.26, 0.076, 0.068),
    "III": (0.295, 0.116, 0.135),
    "1C": (0.30, 0.13, 0.25),
    "3C": (0.33, 0.20, 0.39),
    "5C": (0.40, 0.31, 0.56),
    "7C": (0.48, 0.49, 0.89),
    "9C": (0.60, 0.78, 1.6),
}
"""Loss of daylight on its way down, at 600, 525 and 450 nm [1/m] (Jerlov 1976, table XXVII): I to
III are oceans, 1C to 9C coasts."""

Area = tuple[Point, Point]
"""South-west and north-east corner."""
MAX_DOORWAYS = 16


def _as_written(value: object) -> object:
    """Take a value that is checked later."""
    return value


_PLACE = numbers(2, -FARTHEST, FARTHEST)
_TEXTURE = choice(SURFACE_TEXTURES)
_FACING = choice(FACINGS)
_ON_WALL = key(
    _PLACE, meaning="x and y of the middle of its back: a point on the surface of a wall"
)
_BASE = key(number(0.0, 5.0), 0.0, "height of its bottom above the floor")
_MIDDLE = key(number(0.05, 5.0), 0.6, "of its middle above the floor")
_ON_DECK = key(truth, default=False, meaning="it is on the deck there, not on the ground below it")
_HEADING = key(degrees(-360.0, 360.0), 0.0, "direction of its front", at="heading_deg")


@dataclass(frozen=True, slots=True, kw_only=True)
class StartSpec:
    """Where the robot starts."""

    at: Point = key(_PLACE, meaning="x and y")
    heading: float = _HEADING


@dataclass(frozen=True, slots=True, kw_only=True)
class HallSpec:
    """The hall around the arena."""

    ceiling: float = key(number(1.0, 20.0), 3.0, "height of the ceiling")
    floor_colour: Colour = key(read_colour, COLOURS["grey"], "colour of the floor")
    floor_texture: str = key(_TEXTURE, "checker", "texture of the floor")
    light: float = key(
        number(0.0, 1.0),
        1.0,
        "how bright it is; in the dark, at 0, a camera sees nothing without a headlight",
    )


def _corners(value: object) -> Area:
    if not isinstance(value, list) or len(value) != 2:
        reason = f"{shorten(value)} is not a list of two corners"
        raise RefusedError(reason)
    (west, south), (east, north) = _PLACE(value[0]), _PLACE(value[1])
    if not (west < east and south < north):
        reason = f"{shorten(value)} is not the south-west corner and the north-east one"
        raise RefusedError(reason)
    return (west, south), (east, north)


@dataclass(frozen=True, slots=True, kw_only=True)
class WaterSpec:
    """Water that stands on the floor."""

    surface: float = key(number(0.1, 20.0), meaning="height of the surface above the floor")
    area: Area | None = key(
        _corners,
        None,
        "x and y of its south-west and of its north-east corner: `[[0, 0], [6, 8]]`",
        without="everywhere",
    )
    type: str = key(
        choice(tuple(WATER_TYPES)),
        "1C",
        "its colour, after Jerlov: oceans, `I` to `III`, and ever murkier coasts, `1C` to `9C`",
    )
    visibility: float = key(
        number(0.2, 50.0), 8.0, "distance at which 2 % of the contrast is left in daylight"
    )
    current: Point = key(
        numbers(2, -3.0, 3.0),
        (0.0, 0.0),
        "velocity of the water along x and y [m/s]",
        without="it stands",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class AirSpec:
    """How the air moves."""

    draft: float = key(
        number(0.0, 2.0),
        0.04,
        "standard deviation of drafts [m/s]: 0.04 in a still room, 0.15 in a drafty one",
    )
    wind: Point = key(
        numbers(2, -5.0, 5.0), (0.0, 0.0), "steady wind along x and y [m/s]", without="none"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BerthSpec:
    """Where a robot of another kind than the rover starts."""

    robot: str = key(text(64), meaning="kind of the robot, such as `blimp`; no other berth has it")
    at: Point = key(_PLACE, meaning="x and y")
    height: float = key(number(0.0, 20.0), 0.0, "of the robot's origin above the floor")
    heading: float = _HEADING


@dataclass(frozen=True, slots=True, kw_only=True)
class DoorwaySpec:
    """A gap in a wall."""

    at: float = key(
        number(0.0, 2 * FARTHEST),
        meaning="middle of the doorway, along the wall, counted from `from`",
    )
    width: float = key(number(0.1, 20.0), 0.9)
    height: float | None = key(
        number(0.1, 5.0), None, "the wall goes on above it", without="the wall's"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class WallSpec:
    """A wall along x or y."""

    begin: Point = key(_PLACE, meaning="x and y of one end, in the middle of the wall", at="from")
    end: Point = key(_PLACE, meaning="x and y of the other end", at="to")
    height: float = key(number(0.02, 5.0), 1.2)
    thickness: float = key(number(0.02, 2.0), 0.1)
    colour: Colour = key(read_colour, COLOURS["sand"])
    texture: str = key(_TEXTURE, "panel")
    doorways: tuple[DoorwaySpec, ...] = key(
        _as_written, (), f"a list of up to {MAX_DOORWAYS} tables, each with the keys below"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxSpec:
    """A box: furniture, crates, rubble."""

    at: Point = key(_PLACE, meaning="x and y of its middle")
    size: tuple[float, float, float] = key(numbers(3, 0.01, 20.0), meaning="along x, y and z")
    base: float = _BASE
    colour: Colour = key(read_colour, COLOURS["brown"])
    texture: str = key(_TEXTURE, "plain")


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderSpec:
    """An upright cylinder: drums, pipes, posts."""

    at: Point = key(_PLACE, meaning="x and y of its axis")
    radius: float = key(number(0.01, 5.0))
    height: float = key(number(0.02, 5.0))
    base: float = _BASE
    colour: Colour = key(read_colour, COLOURS["grey"])
    texture: str = key(_TEXTURE, "plain")


@dataclass(frozen=True, slots=True, kw_only=True)
class VictimSpec:
    """A person to be found."""

    name: str = key(text(64), meaning="its name; no other has it")
    at: Point = key(_PLACE, meaning="x and y of the middle")
    facing: Side = key(_FACING, meaning="where the face looks, or, lying, where the head points")
    pose: str = key(
        choice(POSES), "sitting", "`sitting` (0.9 m deep, 0.6 m wide) or `lying` (1.6 m long)"
    )
    colour: Colour = key(read_colour, COLOURS["blue"], "of the clothes")
    skin: float = key(
        number(0.0, 45.0),
        33.0,
        "temperature of the skin [degrees Celsius]; the air has 20",
        at="skin_c",
    )
    moves: bool = key(truth, default=False, meaning="it waves an arm")
    sound: float = key(
        number(0.0, 120.0), 0.0, "its voice, at 1 m [dB]; 60 speaks, 0 is silent", at="sound_db"
    )
    co2: float = key(
        number(0.0, 10_000.0),
        400.0,
        "carbon dioxide of its breath, at 1 m, above that of the air [ppm]; 0: it does not breathe",
        at="co2_ppm",
    )
    deck: bool = _ON_DECK


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkSpec:
    """A square coloured sign with a white diamond."""

    name: str = key(text(64), meaning="its name; no other has it")
    at: Point = _ON_WALL
    facing: Side = key(_FACING)
    height: float = _MIDDLE
    size: float = key(number(0.05, 3.0), 0.4, "its side")
    colour: Colour = key(read_colour)
    deck: bool = _ON_DECK


@dataclass(frozen=True, slots=True, kw_only=True)
class RingSpec:
    """A Landolt C, an open ring, on a white panel."""

    at: Point = _ON_WALL
    facing: Side = key(_FACING)
    height: float = _MIDDLE
    gap_mm: float = key(number(1.0, 200.0), meaning="width of the gap in millimetres")
    gap: str = key(choice(GAPS), meaning="where the gap is, seen from in front")
    deck: bool = _ON_DECK


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoringSpec:
    """The score of a victim that is found here."""

    weight: float = key(number(0.0, 10.0), 1.0, "score of a victim: yellow 0.5, orange 0.75, red 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class ArenaSpec:
    """The content of an arena file."""

    name: str = key(text(64), meaning="the arena's name")
    description: str = key(text(500), "", "what it is for")
    start: StartSpec
    hall: HallSpec
    walls: tuple[WallSpec, ...]
    boxes: tuple[BoxSpec, ...]
    cylinders: tuple[CylinderSpec, ...]
    victims: tuple[VictimSpec, ...]
    landmarks: tuple[LandmarkSpec, ...]
    rings: tuple[RingSpec, ...]
    berths: tuple[BerthSpec, ...]
    water: WaterSpec | None
    air: AirSpec | None
    ground: GroundSpec
    scoring: ScoringSpec
