"""Pictures of rough ground against rays that march in steps of 4 mm."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hub.sim.camera.ground_light import ground_light
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import View
from hub.sim.geometry import Surface
from hub.sim.ground.height_field import HeightField
from tests.hub.sim.arenas import VOID, arena_of
from tests.hub.sim.camera.rough_ground import CELL, height_field, on, rough_ground
from tests.hub.sim.camera.slow_rays import rays_of

GROUND = rough_ground()
FOV = math.radians(48.8)
FARTHEST = 7.0
WALLS = VOID + "[[wall]]\nfrom=[9,0]\nto=[9,9]\nheight=2\n"


def marched(
    ground: HeightField, eyes: np.ndarray, rays: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Depth [m] at which each ray enters the ground, and the height of it there; shape (rays,)."""
    depth, height = np.full(len(rays), np.nan), np.zeros(len(rays))
    level = np.hypot(rays[:, 0], rays[:, 1])
    rows, columns = ground.heights.shape
    left = np.arange(len(rays))
    for way in np.arange(0.03, FARTHEST, 0.004):
        at = eyes[left] + rays[left] * (way / level[left])[:, None]
        column = np.clip(np.floor((at[:, 0] - ground.origin[0]) / CELL), 0, columns - 1).astype(int)
        row = np.clip(np.floor((at[:, 1] - ground.origin[1]) / CELL), 0, rows - 1).astype(int)
        here = ground.heights[row, column]
        hit = at[:, 2] <= here
        depth[left[hit]] = way / level[left[hit]]
        height[left[hit]] = here[hit]
        left = left[~hit]
    return depth, height


@pytest.mark.parametrize(
    ("above", "pitch"), [(0.37, -0.1), (1.5, -0.8), (2.2, -1.4)], ids=["rover", "ahead", "below"]
)
def test_depth_of_the_ground_is_that_of_marching_rays(above: float, pitch: float) -> None:
    caster = RayCaster(on(GROUND, arena_of(VOID)))
    random = np.random.default_rng(2)
    drawn, eyes, rays = [], [], []
    for _ in range(8):
        x, y = random.uniform(1.5, 8.0, 2).tolist()
        view = View(
            x=x,
            y=y,
            z=float(GROUND.heights[int(y / CELL), int(x / CELL)]) + above,
            yaw=float(random.uniform(-3.0, 3.0)),
            pitch=pitch + float(random.uniform(-0.2, 0.15)),
            roll=float(random.uniform(-0.3, 0.3)),
            horizontal_fov=FOV,
        )
        picked = random.integers(0, 160 * 120, 60)
        drawn.append(caster.depth(view, 160, 120).ravel()[picked])
        eyes.append(np.tile(view.eye, (60, 1)))
        rays.append(rays_of(view, 160, 120).reshape(-1, 3)[picked])
    true, height = marched(GROUND, np.concatenate(eyes), np.concatenate(rays))
    met = np.isfinite(true)
    error = np.abs(np.concatenate(drawn) - true)[met]
    raised = error[height[met] > 0.0]
    assert len(raised) > 100
    assert np.median(raised) < 0.008
    assert np.percentile(raised, 90) < 0.06
    assert (error > 0.2).mean() < 0.06


def test_a_rolled_picture_of_the_ground_is_the_turned_picture() -> None:
    caster = RayCaster(on(GROUND, arena_of(VOID)))
    level = View(x=1.0, y=4.9, z=0.7, yaw=0.2, pitch=-0.2, horizontal_fov=FOV)
    turned = caster.depth(replace(level, roll=math.pi), 80, 60)[::-1, ::-1]
    assert (np.abs(turned - caster.depth(level, 80, 60)) > 0.05).mean() < 0.02


def test_a_wall_hides_the_ground_behind_it_and_posts_hide_the_wall() -> None:
    stairs = View(x=5.5, y=4.4, z=0.5, yaw=0.0, pitch=0.1, horizontal_fov=FOV)
    near_wall, far_wall = WALLS.replace("[9,", "[6.2,"), WALLS
    before_stairs = RayCaster(on(GROUND, arena_of(near_wall))).depth(stairs, 80, 60)
    behind = RayCaster(on(GROUND, arena_of(far_wall))).depth(stairs, 80, 60)
    bare = RayCaster(arena_of(far_wall)).depth(stairs, 80, 60)
    assert before_stairs[20:40].max() < 0.8
    # The second riser is 1.25 m ahead; the wall shows above the last step.
    assert behind[50, 40] == pytest.approx(1.25, abs=0.05)
    assert behind[2, 40] == bare[2, 40]


def test_the_floor_shows_where_the_map_has_no_height_and_beyond_the_map() -> None:
    flat = height_field(
        heights=np.zeros((40, 40), dtype=np.float32),
        appearance=np.zeros((40, 40), dtype=np.uint16),
    )
    edge = replace(flat, heights=np.pad(flat.heights[:, 20:], ((0, 0), (0, 20)), constant_values=1))
    arena = arena_of(VOID)
    away = View(x=0.5, y=0.5, z=1.5, yaw=math.pi, pitch=-0.5, horizontal_fov=FOV)
    for ground in (flat, edge):
        seen = RayCaster(on(ground, arena)).picture(away, 80, 60)
        assert np.array_equal(seen, RayCaster(arena).picture(away, 80, 60))


def test_a_map_may_lie_anywhere() -> None:
    view = View(x=1.0, y=4.9, z=0.7, yaw=0.2, pitch=-0.2, roll=0.1, horizontal_fov=FOV)
    arena = arena_of(VOID)
    here = RayCaster(on(GROUND, arena)).depth(view, 80, 60)
    moved = RayCaster(on(rough_ground((-20.0, 12.0)), arena))
    there = moved.depth(replace(view, x=view.x - 20.0, y=view.y + 12.0), 80, 60)
    assert (np.abs(here - there) > 0.05).mean() < 0.02


def test_each_cell_shows_its_surface_and_tops_are_brighter_than_sides() -> None:
    heights = np.zeros((80, 80), dtype=np.float32)
    heights[20:60, 40:60] = 0.3
    appearance = np.ones((80, 80), dtype=np.uint16)
    appearance[40:60] = 2
    colours = ((150, 150, 150), (200, 20, 20), (20, 20, 200))
    ground = height_field(
        heights=heights,
        appearance=appearance,
        surfaces=tuple(Surface(texture="plain", colour=colour) for colour in colours),
    )
    caster = RayCaster(on(ground, arena_of(VOID)))
    ahead = View(x=0.2, y=1.0, z=0.7, yaw=0.0, pitch=-0.45, horizontal_fov=FOV)
    picture = caster.picture(ahead, 160, 120).astype(int)
    # North, with the larger y, is at the left.
    left, right = picture[:, 60], picture[:, 100]
    assert (left[:, 2] - left[:, 0]).max() > 80
    assert (right[:, 0] - right[:, 2]).max() > 80
    red = right[right[:, 0] - right[:, 2] > 30][:, 0]
    assert red.max() > 1.3 * red.min()


def test_the_light_on_slopes_says_which_way_they_rise() -> None:
    slope = (np.arange(40, dtype=np.float32) * 0.25 * CELL)[None, :].repeat(40, axis=0)
    east, west = (ground_light(heights, CELL) for heights in (slope, slope[:, ::-1]))
    assert west[20, 20] > 1.0 > east[20, 20]
    assert np.isfinite(ground_light(slope[:1], CELL)).all()


def test_a_level_patch_shows_its_own_surface() -> None:
    appearance = np.zeros((80, 80), dtype=np.uint16)
    appearance[:, 40:60] = 1
    red = (GROUND.surfaces[0], Surface(texture="plain", colour=(220, 20, 20)))
    patch = height_field(
        heights=np.zeros((80, 80), np.float32), appearance=appearance, surfaces=red
    )
    view = View(x=0.2, y=1.0, z=0.7, yaw=0.0, pitch=-0.45, roll=0.1, horizontal_fov=FOV)
    arena = arena_of(VOID)
    picture = RayCaster(on(patch, arena)).picture(view, 80, 60).astype(int)
    reddish = picture[..., 0] - picture[..., 1] > 40
    assert 0.05 < reddish.mean() < 0.5
    assert np.array_equal(
        RayCaster(on(patch, arena)).depth(view, 80, 60) < 1.0,
        RayCaster(arena).depth(view, 80, 60) < 1.0,
    )


def test_a_slope_is_no_step_from_near_and_far() -> None:
    """Far off, two samples are apart so far that a slope rises more between them than a step."""
    heights = np.zeros((80, 480), dtype=np.float32)
    heights[:, 80:] = np.arange(400, dtype=np.float32) * (0.3 * CELL)
    plain = (GROUND.surfaces[0], Surface(texture="plain", colour=(220, 20, 20)))
    appearance = np.ones((80, 480), dtype=np.uint16)
    slope = height_field(heights, appearance, surfaces=plain)
    hall = arena_of(VOID + "[hall]\nceiling=8\n")
    view = View(x=0.5, y=1.0, z=0.6, yaw=0.0, pitch=0.1, roll=0.05, horizontal_fov=0.3)
    picture = RayCaster(on(slope, hall)).picture(view, 160, 120).astype(int)
    red = picture[..., 0] - picture[..., 1]
    rows = [row[row > 25] for row in red[:, 60:100] if (row > 25).all()]
    assert len(rows) > 60
    # Each row shows one height of the slope, in one brightness.
    assert max(np.ptp(row) for row in rows) < 0.15 * max(row.max() for row in rows)
