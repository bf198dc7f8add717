"""Builds the boxes and cylinders of an arena from its file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

from hub.sim.arena_specs import (
    ArenaSpec,
    BoxSpec,
    CylinderSpec,
    DoorwaySpec,
    LandmarkSpec,
    RingSpec,
    VictimSpec,
    WallSpec,
)
from hub.sim.geometry import AIR_C, Box, Colour, Cylinder, Side, Surface
from hub.sim.ground.height_field import HeightField

PANEL_THICKNESS = 0.02
"""Distance of signs and rings from their wall [m]."""
RING_PANEL_IN_GAPS = 7.0
"""Side of a ring's panel in widths of its gap; the ring itself is 5 gaps wide."""

_IN_FRONT = 0.1
"""Distance from a sign at which the ground below it is measured [m]."""
_SLIVER = 1e-6
"""Pieces of a wall shorter than this [m] come from rounding only."""

SKIN = Surface(texture="plain", colour=(228, 176, 140))
HAIR = Surface(texture="fabric", colour=(62, 40, 28))
FACE = Surface(texture="face", colour=(228, 176, 140))
PANEL_WHITE: Colour = (240, 240, 236)


def build(
    spec: ArenaSpec, ground: HeightField | None = None, *, waving: bool = False
) -> tuple[tuple[Box, ...], tuple[Cylinder, ...], tuple[str, ...]]:
    """All solids of an arena, and a name for the origin of each box, then each cylinder.

    The names are the places in the file ("wall 3"), for messages to its author. Victims, signs and
    rings stand on the ground. Victims that move have an arm up where they are `waving`.
    """
    boxes: list[Box] = []
    origins: list[str] = []
    parts: tuple[tuple[str, list[Iterator[Box]]], ...] = (
        ("wall", [_wall(item) for item in spec.walls]),
        ("box", [_box(item) for item in spec.boxes]),
        (
            "victim",
            [
                _lifted(_victim(item, waving=waving and item.moves), item, ground)
                for item in spec.victims
            ],
        ),
        ("landmark", [_lifted(_landmark(item), item, ground) for item in spec.landmarks]),
        ("ring", [_lifted(_ring(item), item, ground) for item in spec.rings]),
        ("deck", [iter((box,)) for box in (() if ground is None else ground.deck_boxes)]),
    )
    for kind, pieces in parts:
        for index, making in enumerate(pieces, start=1):
            made = list(making)
            boxes.extend(made)
            origins.extend([f"{kind} {index}"] * len(made))
    cylinders = tuple(_cylinder(item) for item in spec.cylinders)
    origins.extend(f"cylinder {index}" for index in range(1, len(cylinders) + 1))
    return tuple(boxes), cylinders, tuple(origins)


def ground_point(item: VictimSpec | LandmarkSpec | RingSpec) -> tuple[float, float]:
    """Where the ground counts that an item stands on: below it, or in front of a sign [m]."""
    x, y = item.at
    if isinstance(item, VictimSpec):
        return x, y
    ahead = item.facing.sign * _IN_FRONT
    return (x + ahead, y) if item.facing.axis == 0 else (x, y + ahead)


def ground_under(item: VictimSpec | LandmarkSpec | RingSpec, ground: HeightField | None) -> float:
    """Height of what an item stands on: the ground, or the deck [m]."""
    if ground is None:
        return 0.0
    return ground.height(*ground_point(item), below=math.inf if item.deck else -math.inf)


def _lifted(
    boxes: Iterator[Box], item: VictimSpec | LandmarkSpec | RingSpec, ground: HeightField | None
) -> Iterator[Box]:
    """The boxes of an item on the ground, or on the deck."""
    if ground is None:
        yield from boxes
        return
    lift = ground_under(item, ground)
    for box in boxes:
        low, high = ((x, y, z + lift) for x, y, z in (box.low, box.high))
        yield dataclasses.replace(box, low=low, high=high)


def _wall(wall: WallSpec) -> Iterator[Box]:
    """The pieces of a wall between its doorways, and a lintel over each lower doorway."""
    length = math.dist(wall.begin, wall.end)
    reached = 0.0
    for door in sorted(wall.doorways, key=lambda item: item.at):
        left, right = door.at - door.width / 2, door.at + door.width / 2
        if left > reached + _SLIVER:
            yield _wall_piece(wall, reached, left, 0.0)
        yield from _lintel(wall, door, left, right)
        reached = right
    if reached < length - _SLIVER:
        yield _wall_piece(wall, reached, length, 0.0)


def _lintel(wall: WallSpec, door: DoorwaySpec, left: float, right: float) -> Iterator[Box]:
    if door.height is not None and door.height < wall.height:
        yield _wall_piece(wall, left, right, door.height)


def _wall_piece(wall: WallSpec, first: float, last: float, base: float) -> Box:
    """A piece from `first` to `last` [m] along the wall; its ends at corners fill the corner."""
    along = 0 if wall.begin[1] == wall.end[1] else 1
    direction = 1.0 if wall.end[along] > wall.begin[along] else -1.0
    ends = sorted(wall.begin[along] + direction * distance for distance in (first, last))
    middle = wall.begin[1 - along]
    across = (middle - wall.thickness / 2, middle + wall.thickness / 2)
    (x_low, x_high), (y_low, y_high) = (ends, across) if along == 0 else (across, ends)
    return Box(
        low=(x_low, y_low, base),
        high=(x_high, y_high, wall.height),
        surface=Surface(texture=wall.texture, colour=wall.colour),
    )


def _box(box: BoxSpec) -> Iterator[Box]:
    (x, y), (dx, dy, dz) = box.at, box.size
    yield Box(
        low=(x - dx / 2, y - dy / 2, box.base),
        high=(x + dx / 2, y + dy / 2, box.base + dz),
        surface=Surface(texture=box.texture, colour=box.colour),
    )


def _cylinder(cylinder: CylinderSpec) -> Cylinder:
    return Cylinder(
        x=cylinder.at[0],
        y=cylinder.at[1],
        radius=cylinder.radius,
        low=cylinder.base,
        high=cylinder.base + cylinder.height,
        surface=Surface(texture=cylinder.texture, colour=cylinder.colour),
    )


def _victim(victim: VictimSpec, *, waving: bool = False) -> Iterator[Box]:
    """A person of a head with a face, a trunk, legs and arms.

    Sitting, the face points in the victim's direction; lying, the head does, and the face points
    up. A victim that waves has an arm up.
    """
    skin, face = (dataclasses.replace(each, temperature=victim.skin) for each in (SKIN, FACE))
    warm = (AIR_C + victim.skin) / 2.0
    clothes = Surface(texture="fabric", colour=victim.colour, temperature=warm)
    dark = Surface(texture="fabric", colour=(52, 56, 70), temperature=warm)
    hair = dataclasses.replace(HAIR, temperature=warm)
    arms = [(-0.29, -0.20), (0.20, 0.29)]
    if victim.pose == "lying":
        yield _part(victim, (0.53, 0.75), (-0.10, 0.10), (0.0, 0.20), skin, (Side.UP, face))
        yield _part(victim, (0.75, 0.79), (-0.10, 0.10), (0.0, 0.20), hair)
        yield _part(victim, (-0.05, 0.53), (-0.20, 0.20), (0.0, 0.22), clothes)
        yield _part(victim, (-0.80, -0.05), (-0.15, 0.15), (0.0, 0.14), dark)
        if waving:
            yield _part(victim, (0.38, 0.48), arms.pop(), (0.0, 0.55), skin)
        for across in arms:
            yield _part(victim, (-0.05, 0.50), across, (0.0, 0.09), skin)
        return
    yield _part(victim, (-0.09, 0.11), (-0.10, 0.10), (0.56, 0.78), skin, (victim.facing, face))
    yield _part(victim, (-0.11, 0.115), (-0.105, 0.105), (0.78, 0.82), hair)
    yield _part(victim, (-0.12, 0.12), (-0.20, 0.20), (0.0, 0.56), clothes)
    yield _part(victim, (0.12, 0.62), (-0.17, 0.17), (0.0, 0.15), dark)
    if waving:
        yield _part(victim, (-0.05, 0.07), arms.pop(), (0.40, 0.90), skin)
    for across in arms:
        yield _part(victim, (-0.05, 0.30), across, (0.20, 0.30), skin)


def _part(
    victim: VictimSpec,
    ahead: tuple[float, float],
    across: tuple[float, float],
    up: tuple[float, float],
    surface: Surface,
    face: tuple[Side, Surface] | None = None,
) -> Box:
    """One box of a body, given ahead of the victim, across (bodies are symmetric) and up [m]."""
    axis, sign = victim.facing.axis, victim.facing.sign
    span_ahead = sorted(victim.at[axis] + sign * value for value in ahead)
    span_across = tuple(victim.at[1 - axis] + value for value in across)
    (x_low, x_high), (y_low, y_high) = (
        (span_ahead, span_across) if axis == 0 else (span_across, span_ahead)
    )
    return Box(
        low=(x_low, y_low, up[0]),
        high=(x_high, y_high, up[1]),
        surface=surface,
        picture_side=None if face is None else face[0],
        picture=None if face is None else face[1],
    )


def _landmark(landmark: LandmarkSpec) -> Iterator[Box]:
    yield _sign(
        landmark.at,
        landmark.facing,
        landmark.height,
        landmark.size,
        Surface(texture="plain", colour=landmark.colour),
        Surface(texture="sign", colour=landmark.colour),
    )


def _ring(ring: RingSpec) -> Iterator[Box]:
    yield _sign(
        ring.at,
        ring.facing,
        ring.height,
        RING_PANEL_IN_GAPS * ring.gap_mm / 1000.0,
        Surface(texture="plain", colour=PANEL_WHITE),
        Surface(texture=f"ring {ring.gap}", colour=PANEL_WHITE),
    )


def _sign(
    at: tuple[float, float],
    facing: Side,
    height: float,
    size: float,
    surface: Surface,
    picture: Surface,
) -> Box:
    """A square panel with its back at `at` and its picture on the side `facing`."""
    depth = sorted((at[facing.axis], at[facing.axis] + facing.sign * PANEL_THICKNESS))
    middle = at[1 - facing.axis]
    across = [middle - size / 2, middle + size / 2]
    (x_low, x_high), (y_low, y_high) = (depth, across) if facing.axis == 0 else (across, depth)
    return Box(
        low=(x_low, y_low, height - size / 2),
        high=(x_high, y_high, height + size / 2),
        surface=surface,
        picture_side=facing,
        picture=picture,
    )
