"""What is wrong with the ground of an arena: an impossible start, a full doorway, no deck."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from hub.pose import Pose
from hub.sim.arena_specs import ArenaSpec, LandmarkSpec, RingSpec, VictimSpec, WallSpec
from hub.sim.building import ground_point
from hub.sim.ground.chassis import WHEELED
from hub.sim.ground.footing import Footing
from hub.sim.ground.height_field import HeightField

_LEAST_HEADROOM = WHEELED.height
"""Height that has to be free in a doorway [m]."""
_STEEPEST_START = 0.27
"""Largest slope of the underside of a robot at the start [m/m], 15 degrees."""


def ground_problems(spec: ArenaSpec, ground: HeightField, start: Pose) -> list[str]:
    """All mistakes, each with the place in the arena file."""
    return [*_at_start(ground, start), *_in_doorways(spec, ground), *_on_decks(spec, ground)]


def _at_start(ground: HeightField, start: Pose) -> Iterable[str]:
    footing = Footing(ground, WHEELED, ())
    pose = footing.settled(start.x, start.y, start.theta)
    stand = None if pose is None else footing.stance(pose)
    if stand is None:
        yield "start: a robot would tip over there"
    elif stand.steepness > _STEEPEST_START:
        lean = math.degrees(math.atan(stand.steepness))
        yield f"start: a robot would lean by {lean:.0f} degrees there"
    elif stand.driven_load == 0.0:
        yield "start: the wheels of a robot would hang in the air there"


def _in_doorways(spec: ArenaSpec, ground: HeightField) -> Iterable[str]:
    for number, wall in enumerate(spec.walls, start=1):
        for index, door in enumerate(wall.doorways, start=1):
            free = (door.height or wall.height) - _highest(wall, door.at, door.width, ground)
            if free < min(_LEAST_HEADROOM, door.height or wall.height):
                left = max(free, 0.0)
                yield f"wall {number}: doorway {index}: the ground leaves only {left:.2f} m"


def _highest(wall: WallSpec, at: float, width: float, ground: HeightField) -> float:
    """The highest ground in a doorway [m]."""
    length = math.dist(wall.begin, wall.end)
    along = np.linspace(at - width / 2, at + width / 2, max(2, math.ceil(width / ground.cell)))
    (x, y), (to_x, to_y) = wall.begin, wall.end
    places = x + (to_x - x) * along / length, y + (to_y - y) * along / length
    return float(ground.heights_at(*places).max())


def _on_decks(spec: ArenaSpec, ground: HeightField) -> Iterable[str]:
    groups: tuple[tuple[str, Sequence[VictimSpec | LandmarkSpec | RingSpec]], ...] = (
        ("victim", spec.victims),
        ("landmark", spec.landmarks),
        ("ring", spec.rings),
    )
    for kind, items in groups:
        for number, item in enumerate(items, start=1):
            place = ground_point(item)
            if item.deck and ground.height(*place, below=math.inf) == ground.height(*place):
                yield f"{kind} {number}, key 'deck': there is no deck"
