"""Pictures under water and of its surface, against the closed forms of how light is lost."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hub.sim.arena import Arena, load_arena
from hub.sim.arena_specs import WATER_TYPES, WaterSpec
from hub.sim.camera.lighting import Lighting
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import View
from tests.hub.sim.arenas import VOID, arena_of
from tests.support.cases import for_each

POOL = load_arena("pool")
SURFACE = 2.4
FOV = math.radians(20.0)
WALL = 'height=5\ntexture="plain"\n'
DARK = Lighting(ambient=0.0, headlight=1.0)


def basin(water: WaterSpec | None, colour: str = "grey") -> Arena:
    """A wall at x = 10."""
    text = VOID + f"[hall]\nceiling=6\n[[wall]]\nfrom=[10,-9]\nto=[10,9]\nthickness=0.02\n{WALL}"
    return replace(arena_of(text + f'colour="{colour}"\n'), water=water)


def ahead(distance: float, z: float = 1.2) -> View:
    """Straight at the wall."""
    return View(x=9.99 - distance, y=0.0, z=z, yaw=0.0, pitch=0.0, horizontal_fov=FOV)


def middle(arena: Arena, view: View, lighting: Lighting | None = None) -> np.ndarray:
    """Red, green and blue in the middle of a picture; its ray is straight."""
    return RayCaster(arena).picture(view, 41, 41, lighting or Lighting())[20, 20].astype(float)


def own_colour(colour: str = "grey") -> np.ndarray:
    """Of the wall, in clear air, so near that there is no haze."""
    return middle(basin(None, colour), ahead(0.8))


def losses(water: WaterSpec) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Loss of daylight with depth, of things' light and of the backscatter with range [1/m]."""
    daylight = np.array(WATER_TYPES[water.type])
    direct = daylight + max(0.0, 3.9 / water.visibility - daylight[1])
    return daylight, direct, direct * (1.10, 0.95, 0.90)


@for_each(
    ("kind", "visibility", "distance", "z"),
    [("1C", 8.0, 1.0, 1.2), ("1C", 8.0, 3.0, 1.2), ("1C", 8.0, 3.0, 0.4), ("I", 20.0, 6.0, 2.0),
     ("7C", 2.0, 1.0, 1.5), ("III", 12.0, 4.0, 0.3)],
)  # fmt: skip
def test_a_grey_wall_at_a_range_and_a_depth_has_the_colour_of_the_closed_form(
    kind: str, visibility: float, distance: float, z: float
) -> None:
    water = WaterSpec(surface=SURFACE, type=kind, visibility=visibility)
    daylight, direct, back = losses(water)
    lost = 3.9 / visibility
    shape = 0.55 * lost / (1.6 * daylight + 0.25 * lost)
    backscatter = shape * 158.0 / shape.max()
    day = np.exp(-daylight * (SURFACE - z))
    wanted = day * own_colour() * np.exp(-direct * distance)
    wanted += day * backscatter * (1.0 - np.exp(-back * distance))
    seen = middle(basin(water), ahead(distance, z))
    assert seen == pytest.approx(wanted, abs=2.5)


def test_the_light_of_the_lamp_falls_with_the_distance_both_ways() -> None:
    water = WaterSpec(surface=SURFACE, type="I", visibility=30.0)
    _, direct, back = losses(water)
    colour = own_colour()
    values = []
    for distance in (0.5, 1.0, 2.0, 3.0, 5.0):
        wanted = 3.0 * colour * np.exp(-2.0 * direct * distance) / (1.0 + (distance / 0.9) ** 2)
        wanted += np.array((23.0, 26.0, 26.0)) * (1.0 - np.exp(-2.0 * back * distance))
        seen = middle(basin(water), ahead(distance), DARK)
        assert seen == pytest.approx(np.minimum(wanted, 255.0), abs=4.0, rel=0.02)
        values.append(seen.sum())
    assert values == sorted(values, reverse=True)


def test_the_lamp_is_brightest_in_its_middle_and_makes_the_water_glow() -> None:
    water = WaterSpec(surface=SURFACE, visibility=4.0)
    view = replace(ahead(9.0), horizontal_fov=math.radians(64.0))
    glow = RayCaster(basin(water)).picture(view, 40, 40, DARK).astype(float).sum(axis=2)
    assert glow[20, 20] > 1.3 * glow[0, 0] > 10.0


@for_each("visibility", [1.5, 3.0, 6.0])
def test_at_the_visibility_two_percent_of_the_contrast_is_left(visibility: float) -> None:
    water = WaterSpec(surface=SURFACE, type="1C", visibility=visibility)
    view = ahead(visibility, SURFACE - 0.02)
    bright, dark = (middle(basin(water, colour), view)[1] for colour in ("white", "black"))
    full = own_colour("white")[1] - own_colour("black")[1]
    # Values are whole levels, of which 2 % are four.
    assert (bright - dark) / full == pytest.approx(0.02, abs=0.006)


def test_deeper_is_darker_and_red_is_lost_first() -> None:
    water = WaterSpec(surface=20.0, type="I", visibility=30.0)
    arena = replace(basin(water), ceiling=30.0)
    shallow, deep = (middle(arena, ahead(1.0, z)) for z in (4.5, 1.0))
    assert (deep < shallow).all()
    assert deep[0] / shallow[0] < 0.6 < deep[2] / shallow[2]


def test_in_the_dark_without_a_lamp_nothing_is_seen_under_water() -> None:
    arena = basin(WaterSpec(surface=SURFACE))
    assert middle(arena, ahead(1.0), Lighting(ambient=0.0)).max() == 0.0


def test_the_surface_from_below_is_a_window_overhead_and_a_mirror_around_it() -> None:
    arena = basin(WaterSpec(surface=SURFACE, type="I", visibility=30.0))
    up = View(x=0.0, y=0.0, z=1.0, yaw=0.0, pitch=1.5, horizontal_fov=FOV)
    flat = replace(up, pitch=0.45)
    overhead, aside = (RayCaster(arena).picture(view, 40, 40).mean() for view in (up, flat))
    assert overhead > 1.4 * aside


def test_what_is_above_the_surface_is_not_seen_from_below() -> None:
    water = WaterSpec(surface=SURFACE, type="I", visibility=30.0)
    view = View(x=9.0, y=0.0, z=1.0, yaw=0.0, pitch=0.0, horizontal_fov=math.radians(60.0))
    sign = '[[landmark]]\nname="a"\nat=[9.9,0]\nfacing="west"\nheight=3\nsize=0.5\ncolour="red"\n'
    with_sign = replace(arena_of(VOID + sign), water=water)
    tilted = replace(view, x=8.0, pitch=0.8)
    dry = RayCaster(replace(with_sign, water=None)).picture(tilted, 80, 60).astype(int)
    wet = RayCaster(with_sign).picture(tilted, 80, 60).astype(int)
    assert (dry[..., 0] - dry[..., 1] > 80).any()
    assert not (wet[..., 0] - wet[..., 1] > 40).any()


def test_from_above_deep_water_hides_the_floor_more_than_shallow_water() -> None:
    view = View(x=0.0, y=0.0, z=3.0, yaw=0.0, pitch=-1.2, horizontal_fov=math.radians(60.0))
    text = VOID + '[hall]\nceiling=6\nfloor_colour="white"\nfloor_texture="checker"\n'
    contrasts = []
    for surface in (None, 0.3, 2.4):
        water = None if surface is None else WaterSpec(surface=surface, type="1C", visibility=4.0)
        picture = RayCaster(replace(arena_of(text), water=water)).picture(view, 80, 60)
        contrasts.append(float(picture[..., 1].std()))
    assert contrasts[0] > 1.2 * contrasts[1] > 2.0 * contrasts[2]


def test_an_arena_is_the_same_to_the_last_bit_where_no_ray_meets_its_water() -> None:
    arena = load_arena("yellow")
    far_off = WaterSpec(surface=1.0, area=((40.0, 40.0), (45.0, 45.0)))
    wet, dry = RayCaster(replace(arena, water=far_off)), RayCaster(arena)
    for z, pitch, roll in ((0.37, 0.0, 0.0), (2.2, -0.7, 0.3)):
        view = View(x=5.2, y=1.2, z=z, yaw=1.6, pitch=pitch, roll=roll, horizontal_fov=0.85)
        assert np.array_equal(wet.picture(view, 80, 60), dry.picture(view, 80, 60))
        assert np.array_equal(wet.depth(view, 80, 60), dry.depth(view, 80, 60))


def test_water_stands_in_its_area_only() -> None:
    half = WaterSpec(surface=0.5, area=((0.0, 0.0), (50.0, 50.0)), visibility=1.0)
    text = VOID + '[hall]\nceiling=6\nfloor_colour="white"\nfloor_texture="plain"\n'
    view = View(x=0.0, y=0.0, z=3.0, yaw=math.pi / 4, pitch=-1.55, horizontal_fov=FOV)
    wet, dry = (
        RayCaster(replace(arena_of(text), water=water)).picture(view, 40, 40).astype(int)
        for water in (half, None)
    )
    changed = (np.abs(wet - dry) > 20).any(axis=2)
    # The north-east quarter of the floor is ahead, above the middle.
    assert changed[:15, 20].all()
    assert not changed[25:].any()


def test_pictures_of_the_pool_under_water_are_good_at_any_pose() -> None:
    caster = RayCaster(POOL)
    random = np.random.default_rng(6)
    for _ in range(20):
        view = View(
            x=float(random.uniform(0.3, 5.7)),
            y=float(random.uniform(0.3, 7.7)),
            z=float(random.uniform(0.05, 2.95)),
            yaw=float(random.uniform(-3.0, 3.0)),
            pitch=float(random.uniform(-1.5, 1.5)),
            roll=float(random.uniform(-3.0, 3.0)),
            horizontal_fov=1.1,
        )
        picture = caster.picture(view, 32, 24, Lighting(ambient=0.5, headlight=0.5))
        assert picture.max() > 10
        assert picture.flags.c_contiguous
