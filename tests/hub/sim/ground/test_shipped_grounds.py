"""The arenas `orange` and `red`: what is in them, and which robots can drive there."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hub.pose import wrapped
from hub.sim.arena import SHIPPED, load_arena
from hub.sim.arena_file import read_arena_file
from hub.sim.ground.chassis import TRACKED, WHEELED, Chassis
from hub.sim.rough_base import RoughBase
from tests.hub.sim.ground.grounds import GROUSERS, RAISED
from tests.support.cases import for_each

Way = tuple[tuple[float, float], ...]


def follow(base: RoughBase, way: Way, seconds: float = 60.0) -> bool:
    """Whether a base reaches all points of a way; it knows its true pose."""
    for x, y in way:
        while math.dist((base.pose.x, base.pose.y), (x, y)) > 0.15:
            seconds -= 0.1
            if seconds < 0.0 or base.tipped:
                return False
            off = wrapped(math.atan2(y - base.pose.y, x - base.pose.x) - base.pose.yaw)
            base.command(0.5 if abs(off) < 0.5 else 0.0, 2.0 * off)
            base.advance(0.1)
    return True


@for_each(("name", "weight"), [("orange", 0.75), ("red", 1.0)])
def test_they_have_victims_signs_rings_and_a_weight(name: str, weight: float) -> None:
    spec, arena = read_arena_file(SHIPPED / f"{name}.toml"), load_arena(name)
    assert arena.weight == weight
    assert len(spec.victims) == 4
    assert len(spec.landmarks) >= 6
    assert len(spec.rings) >= 5
    assert len({item.colour for item in spec.landmarks}) == len(spec.landmarks)


def test_orange_has_half_cubic_fields_and_red_full_cubic_ones() -> None:
    orange, red = (read_arena_file(SHIPPED / f"{name}.toml").ground for name in ("orange", "red"))
    assert {field.unit for field in orange.stepfields} == {0.05}
    assert {field.pattern for field in orange.stepfields} == {"flat", "hill", "diagonal"}
    assert {ramps.crossing for ramps in orange.ramp_fields} == {True, False}
    assert orange.decks
    assert sum(field.unit == 0.1 for field in red.stepfields) > len(red.stepfields) / 2
    (steep,) = red.stairs
    assert math.degrees(math.atan2(steep.rise, steep.run)) == pytest.approx(40.0, abs=0.1)
    assert red.pipes
    assert red.pipes[0].turning


UP_THE_RAMP: Way = ((3.2, 0.95), (7.7, 0.95))
BELOW_THE_DECK: Way = ((2.0, 2.1), (7.8, 2.2))
OVER_THE_FIELDS: Way = ((1.8, 3.0), (5.2, 3.0))
TO_THE_RAMPS: Way = ((1.0, 4.0), (1.0, 5.2), (1.0, 6.5))


@for_each(
    ("chassis", "way", "height"),
    [
        (WHEELED, UP_THE_RAMP, 0.96),
        (TRACKED, BELOW_THE_DECK, 0.0),
        (TRACKED, OVER_THE_FIELDS, 0.0),
        (TRACKED, TO_THE_RAMPS, None),
    ],
)
def test_the_orange_arena_can_be_driven(chassis: Chassis, way: Way, height: float | None) -> None:
    base = RoughBase(load_arena("orange"), chassis, flippers=RAISED if chassis.flippers else None)
    assert follow(base, way), base.pose
    if height is not None:
        assert base.pose.z == pytest.approx(height, abs=0.03)


def test_wheels_do_not_cross_the_fields_of_the_orange_arena() -> None:
    base = RoughBase(load_arena("orange"), WHEELED)
    assert not follow(base, OVER_THE_FIELDS, 12.0)
    assert base.stuck


RED_RAMP: Way = ((7.2, 3.2), (7.2, 5.6))
RED_STAIRS: Way = ((5.85, 3.6), (5.85, 5.8))


@for_each(
    ("chassis", "at", "way", "height"),
    [
        (TRACKED, (7.2, 2.9), RED_RAMP, 1.0),
        (GROUSERS, (5.85, 3.0), RED_STAIRS, 1.0),
        (TRACKED, (5.7, 1.2), ((7.2, 1.2),), 0.0),
        (GROUSERS, (0.85, 2.2), ((0.85, 3.4),), None),
    ],
)
def test_the_red_arena_can_be_driven_by_tracks(
    chassis: Chassis, at: tuple[float, float], way: Way, height: float | None
) -> None:
    arena = load_arena("red")
    x, y = way[0]
    heading = math.atan2(y - at[1], x - at[0])
    start = dataclasses.replace(arena.start, x=at[0], y=at[1], theta=heading)
    base = RoughBase(dataclasses.replace(arena, start=start), chassis, flippers=RAISED)
    assert follow(base, way, 30.0), (base.pose, base.stuck)
    if height is not None:
        assert base.pose.z == pytest.approx(height, abs=0.03)


def test_flippers_take_the_pipe_steps_of_the_red_arena() -> None:
    """Up on the front flippers, lifted over the pipe by all four, and down on the other side."""
    base = RoughBase(load_arena("red"), TRACKED, flippers=(math.radians(20.0), 0.0))
    base.command(0.4, 0.0)
    base.advance(5.0)
    base.advance(2.0)
    assert base.stuck
    assert base.pose.x < 3.6
    for front, rear in ((-30.0, -30.0), (0.0, -30.0), (0.0, 0.0)):
        base.command_flippers(math.radians(front), math.radians(rear))
        base.advance(4.0)
    base.advance(3.0)
    assert base.pose.x > 5.0
    assert base.pose.z == pytest.approx(0.0, abs=0.001)


def test_wheels_do_not_cross_the_red_arena() -> None:
    arena = load_arena("red")
    assert not follow(RoughBase(arena, WHEELED), ((4.3, 1.2),), 8.0)


def test_the_height_maps_are_of_a_size_to_draw() -> None:
    for name in ("orange", "red"):
        ground = load_arena(name).ground
        assert ground is not None
        assert ground.cell == 0.025
        assert ground.heights.size < 250_000
        assert ground.heights.dtype == np.float32
        assert ground.appearance.max() < len(ground.surfaces)
