"""An arena: its solids, and the start of the robot."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hub.errors import ArenaError
from hub.gcm.body import USUAL_HEIGHT, USUAL_RADIUS
from hub.nearest import did_you_mean
from hub.pose import Pose
from hub.sim.arena_file import read_arena_file
from hub.sim.arena_specs import AirSpec, ArenaSpec, BerthSpec, VictimSpec, WaterSpec
from hub.sim.building import build, ground_under
from hub.sim.geometry import Box, Cylinder, Surface
from hub.sim.ground.height_field import HeightField
from hub.sim.ground.map_builder import build_ground
from hub.sim.ground_checks import ground_problems
from hub.sim.spatial_pose import SpatialPose
from hub.values import dataclass

SHIPPED = Path(__file__).parent / "arenas"
"""Folder of the arenas that come with the hub."""
LOWEST_OBSTACLE = 0.01
"""Wheels drive over solids below this height [m]."""
_SITTING_AHEAD, _SITTING_UP = 0.15, 0.62
"""Mouth of a victim that sits, from its place [m]."""
_LYING_AHEAD, _LYING_UP = 0.6, 0.25
"""Mouth of a victim that lies [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Footprints:
    """The obstacles for the robot, seen from above.

    Attributes:
        low: Least x, y of each box [m], shape (b, 2).
        high: Greatest x, y of each box [m], shape (b, 2).
        centre: Axis of each cylinder [m], shape (c, 2).
        radius: Radius of each cylinder [m], shape (c,).
        brightness: Share of infrared light that each reflects, 0 to 1, boxes first, shape (b + c,).
        origin: Place of each in the arena file, boxes first, b + c names.
    """

    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    centre: npt.NDArray[np.float64]
    radius: npt.NDArray[np.float64]
    brightness: npt.NDArray[np.float64]
    origin: tuple[str, ...]

    def distances(self, x: float, y: float) -> npt.NDArray[np.float64]:
        """From a point to each obstacle [m], boxes first, shape (b + c,); 0 or less: inside."""
        point = np.array((x, y))
        beyond = np.maximum(np.maximum(self.low - point, point - self.high), 0.0)
        away = self.centre - point
        return np.concatenate(
            (np.hypot(beyond[:, 0], beyond[:, 1]), np.hypot(away[:, 0], away[:, 1]) - self.radius)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class VictimSigns:
    """What robots can sense of a victim without a camera.

    Attributes:
        x: Its mouth [m].
        y: The same.
        z: The same.
        sound: Its voice at 1 m [dB]; 0: it is silent.
        co2: What its breath adds to the air at 1 m [ppm].
    """

    x: float
    y: float
    z: float
    sound: float
    co2: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arena:
    """An arena; nothing in it moves but arms of victims.

    Attributes:
        name: Its name.
        start: The robot's start, in the arena's frame.
        boxes: All boxes.
        cylinders: All cylinders.
        footprints: The obstacles that the robot can touch and its range sensors can see.
        ceiling: Height of the ceiling [m].
        floor: The surface of the floor.
        light: Brightness, 0 (dark) to 1.
        ground: The height map of rough ground; None: the floor is level.
        berths: Where robots of other kinds than the rover start.
        water: The water that stands on the floor; None: it is dry.
        air: How the air moves; None: it stands.
        weight: What a victim that is found here counts.
        victims: Sound and breath of each victim.
        overhead: The surface of the ceiling.
        waving: All boxes while victims that move have an arm up; none: no victim moves.
    """

    name: str
    start: Pose
    boxes: tuple[Box, ...]
    cylinders: tuple[Cylinder, ...]
    footprints: Footprints
    ceiling: float
    floor: Surface
    light: float
    ground: HeightField | None = None
    berths: tuple[BerthSpec, ...] = ()
    water: WaterSpec | None = None
    air: AirSpec | None = None
    weight: float = 1.0
    victims: tuple[VictimSigns, ...] = ()
    overhead: Surface = Surface(texture="ceiling", colour=(122, 126, 134))
    waving: tuple[Box, ...] = ()

    def berth(self, robot: str) -> BerthSpec | None:
        """Where a kind of robot starts; None: the arena does not say."""
        return next((berth for berth in self.berths if berth.robot == robot), None)

    def place_number(self, start: Pose | SpatialPose) -> int:
        """Number of a place: the world restarts with a robot, so equal numbers are one place."""
        return zlib.crc32(repr((self.name, start)).encode()) | 1


def shipped_arenas() -> tuple[str, ...]:
    """Names of the arenas that come with the hub."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def arena_path(name_or_path: str) -> Path:
    """The file of an arena that comes with the hub, by name, or the path itself.

    Raises:
        ArenaError: There is no arena of this name.
    """
    if name_or_path in shipped_arenas():
        return SHIPPED / f"{name_or_path}.toml"
    path = Path(name_or_path)
    if path.suffix != ".toml" and path.name == name_or_path:
        known = shipped_arenas()
        hint = did_you_mean(name_or_path, known)
        text = f"no arena of this name; give a .toml file or one of {', '.join(known)}{hint}"
        raise ArenaError(name_or_path, [text])
    return path


def load_arena(name_or_path: str) -> Arena:
    """An arena that comes with the hub, by name, or any arena file, by path.

    Raises:
        ArenaError: There is no such arena, or its file has mistakes, which are all listed.
    """
    path = arena_path(name_or_path)
    spec = read_arena_file(path)
    arena = arena_from_spec(spec)
    problems = [f"start: the robot would touch {name}" for name in _touched_at_start(arena)]
    if arena.ground is not None:
        problems += ground_problems(spec, arena.ground, arena.start)
    problems += _berth_problems(arena)
    if problems:
        raise ArenaError(str(path), problems)
    return arena


def arena_from_spec(spec: ArenaSpec) -> Arena:
    """Build the arena of a checked file."""
    floor = Surface(texture=spec.hall.floor_texture, colour=spec.hall.floor_colour)
    ground = build_ground(spec.ground, floor)
    boxes, cylinders, origins = build(spec, ground)
    start_height = 0.0 if ground is None else ground.height(*spec.start.at)
    return Arena(
        name=spec.name,
        start=Pose(x=spec.start.at[0], y=spec.start.at[1], theta=spec.start.heading),
        boxes=boxes,
        cylinders=cylinders,
        footprints=footprints_of(boxes, cylinders, origins, ground=start_height),
        ceiling=spec.hall.ceiling,
        floor=floor,
        light=spec.hall.light,
        ground=ground,
        berths=spec.berths,
        water=spec.water,
        air=spec.air,
        weight=spec.scoring.weight,
        victims=tuple(_signs(victim, ground) for victim in spec.victims),
        waving=build(spec, ground, waving=True)[0] if any(v.moves for v in spec.victims) else (),
    )


def _signs(victim: VictimSpec, ground: HeightField | None) -> VictimSigns:
    sits = victim.pose == "sitting"
    place = list(victim.at)
    place[victim.facing.axis] += victim.facing.sign * (_SITTING_AHEAD if sits else _LYING_AHEAD)
    return VictimSigns(
        x=place[0],
        y=place[1],
        z=ground_under(victim, ground) + (_SITTING_UP if sits else _LYING_UP),
        sound=victim.sound,
        co2=victim.co2,
    )


def footprints_of(
    boxes: tuple[Box, ...],
    cylinders: tuple[Cylinder, ...],
    origins: tuple[str, ...],
    *,
    ground: float = 0.0,
    height: float = USUAL_HEIGHT,
) -> Footprints:
    """The solids at the height of a robot's body.

    Args:
        boxes: All boxes.
        cylinders: All cylinders.
        origins: Place of each in the arena file, boxes first.
        ground: Height of the ground that the robot stands on [m].
        height: Height of the robot, which drives under solids above it [m].
    """

    def in_the_way(low: float, high: float) -> bool:
        return low < ground + height and high > ground + LOWEST_OBSTACLE

    near_boxes = [
        (box, origin)
        for box, origin in zip(boxes, origins, strict=False)
        if in_the_way(box.low[2], box.high[2])
    ]
    near_cylinders = [
        (item, origin)
        for item, origin in zip(cylinders, origins[len(boxes) :], strict=True)
        if in_the_way(item.low, item.high)
    ]
    surfaces = [box.surface for box, _ in near_boxes]
    surfaces += [item.surface for item, _ in near_cylinders]
    return Footprints(
        low=np.array([box.low[:2] for box, _ in near_boxes]).reshape(-1, 2),
        high=np.array([box.high[:2] for box, _ in near_boxes]).reshape(-1, 2),
        centre=np.array([(item.x, item.y) for item, _ in near_cylinders]).reshape(-1, 2),
        radius=np.array([item.radius for item, _ in near_cylinders], dtype=np.float64),
        brightness=np.array([sum(item.colour) / 765.0 for item in surfaces], dtype=np.float64),
        origin=(*(origin for _, origin in near_boxes), *(origin for _, origin in near_cylinders)),
    )


def _touched_at_start(arena: Arena) -> list[str]:
    """The obstacles that overlap a robot at the start pose, each place of the file once."""
    distances = arena.footprints.distances(arena.start.x, arena.start.y)
    touched = (arena.footprints.origin[index] for index in np.flatnonzero(distances < USUAL_RADIUS))
    return list(dict.fromkeys(touched))


def _berth_problems(arena: Arena) -> Iterator[str]:
    """A berth has to be below the ceiling, and in no solid."""
    for number, berth in enumerate(arena.berths, start=1):
        place = (*berth.at, berth.height)
        if berth.height >= arena.ceiling:
            yield f"berth {number}: it is not below the ceiling, at {arena.ceiling:g} m"
        within = any(
            all(low <= at <= high for low, at, high in zip(box.low, place, box.high, strict=True))
            for box in arena.boxes
        ) or any(
            math.dist(berth.at, (item.x, item.y)) <= item.radius
            and item.low <= berth.height <= item.high
            for item in arena.cylinders
        )
        if within:
            yield f"berth {number}: it is inside a solid"
