"""Pictures and depths of the ray caster against an independent, slow computation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.sim.arena import load_arena
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import View
from tests.hub.sim.arenas import VOID, arena_of, free_poses
from tests.hub.sim.camera.slow_rays import slow_depth
from tests.support.cases import for_each
from tests.support.repetitions import repetitions

WIDE = math.radians(48.8)
HEIGHT = 0.37


def view_of(x: float, y: float, yaw: float, pitch: float = 0.0, fov: float = WIDE) -> View:
    return View(x=x, y=y, z=HEIGHT, yaw=yaw, pitch=pitch, horizontal_fov=fov)


@pytest.mark.parametrize(("width", "height"), [(80, 60), (61, 33)])
def test_depth_equals_the_slow_computation_at_random_poses(width: int, height: int) -> None:
    arena = load_arena("yellow")
    caster = RayCaster(arena)
    random = np.random.default_rng(5)
    different = 0
    poses = free_poses(arena, repetitions(7, 50), 6, 0.3, 9.7)
    for pose in poses:
        fov = float(random.choice([WIDE, 0.5, math.radians(4.3)]))
        view = view_of(pose.x, pose.y, pose.theta, float(random.uniform(-0.43, 0.43)), fov)
        drawn = caster.depth(view, width, height)
        different += int((np.abs(drawn - slow_depth(arena, view, width, height)) > 0.005).sum())
    # Rays that graze an edge may fall to either side of it.
    assert different <= 0.0005 * len(poses) * width * height


def test_depth_of_cylinders_is_exact_near_and_far_above_and_below() -> None:
    arena = arena_of(
        VOID
        + "[[cylinder]]\nat=[0.6, 0.1]\nradius=0.3\nheight=0.3\n"
        + "[[cylinder]]\nat=[2.0, 0.9]\nradius=0.2\nheight=0.4\nbase=0.6\n"
        + "[[cylinder]]\nat=[4.0, -1.0]\nradius=0.1\nheight=2.0\n"
    )
    caster = RayCaster(arena)
    for yaw in np.linspace(-0.8, 0.8, 9):
        for pitch in (-0.43, -0.2, 0.0, 0.2, 0.43):
            view = view_of(0.0, 0.0, float(yaw), pitch)
            wrong = np.abs(caster.depth(view, 80, 60) - slow_depth(arena, view, 80, 60)) > 0.005
            assert wrong.mean() < 0.002


def test_a_drum_that_nearly_touches_the_camera_is_drawn_to_its_edges() -> None:
    arena = arena_of(VOID + "[[cylinder]]\nat=[1.0, 0.0]\nradius=0.8\nheight=1.5\n")
    caster = RayCaster(arena)
    for yaw in np.linspace(-2.0, 2.0, 9):
        for pitch in (-0.4, 0.0, 0.4):
            view = view_of(0.0, 0.0, float(yaw), pitch)
            wrong = np.abs(caster.depth(view, 80, 60) - slow_depth(arena, view, 80, 60)) > 0.005
            assert wrong.mean() < 0.002


def test_a_post_that_reaches_just_beside_the_camera_is_drawn() -> None:
    arena = arena_of(VOID + "[[cylinder]]\nat=[0.5, -0.75]\nradius=0.5\nheight=1.5\n")
    view = view_of(0.0, 0.0, 0.0, 0.2)
    drawn = RayCaster(arena).depth(view, 80, 60)
    wrong = np.abs(drawn - slow_depth(arena, view, 80, 60)) > 0.005
    assert (drawn < 2.0).any()
    assert wrong.mean() < 0.002


def test_a_void_shows_floor_and_ceiling_only() -> None:
    depth = RayCaster(arena_of(VOID)).depth(view_of(0.0, 0.0, 1.0), 40, 30)
    assert depth[-1, 20] == pytest.approx(HEIGHT / math.tan(WIDE / 2) / 0.75, rel=0.05)
    assert (np.diff(depth[16:], axis=0) < 0).all()
    assert (np.diff(depth[:14], axis=0) > 0).all()


def test_a_picture_has_the_size_asked_for_and_contiguous_bytes() -> None:
    caster = RayCaster(load_arena("yellow"))
    for width, height in ((320, 240), (160, 120), (7, 3), (1, 1)):
        picture = caster.picture(view_of(5.2, 0.9, 1.57), width, height)
        assert picture.shape == (height, width, 3)
        assert picture.dtype == np.uint8
        assert picture.flags.c_contiguous


def test_a_picture_does_not_change_when_the_next_is_drawn() -> None:
    caster = RayCaster(load_arena("yellow"))
    first = caster.picture(view_of(5.2, 0.9, 1.57), 80, 60)
    kept = first.copy()
    caster.picture(view_of(5.2, 0.9, 0.3), 80, 60)
    assert (first == kept).all()
    assert (caster.picture(view_of(5.2, 0.9, 1.57), 80, 60) == kept).all()


def test_a_wall_that_is_farther_is_hazier() -> None:
    arena = arena_of(VOID + '[[wall]]\nfrom=[9,-5]\nto=[9,5]\nheight=2\ncolour="red"\n')
    caster = RayCaster(arena)
    contrast = []
    for x in (7.0, 4.0, 0.0):
        picture = caster.picture(view_of(x, 0.0, 0.0), 40, 30).astype(int)
        contrast.append(picture[13, :, 0].mean() - picture[13, :, 2].mean())
    assert contrast[0] > contrast[1] > contrast[2] > 20


@pytest.mark.parametrize("facing", ["east", "north", "west", "south"])
def test_landmarks_show_their_colour_from_every_side(facing: str) -> None:
    text = f'[[landmark]]\nname="a"\nat=[0,0]\nfacing="{facing}"\nsize=0.8\ncolour="green"\n'
    caster = RayCaster(arena_of('name="a"\n[start]\nat=[5,5]\n' + text))
    away = {"east": 0.0, "north": 90.0, "west": 180.0, "south": -90.0}[facing]
    x, y = math.cos(math.radians(away)), math.sin(math.radians(away))
    picture = caster.picture(view_of(2 * x, 2 * y, math.radians(away + 180)), 160, 120)
    red, green, blue = picture[48, 65].astype(int)
    assert green > red + 40
    assert green > blue + 40


GAPS = {
    "right": (1, 0),
    "up-right": (1, -1),
    "up": (0, -1),
    "up-left": (-1, -1),
    "left": (-1, 0),
    "down-left": (-1, 1),
    "down": (0, 1),
    "down-right": (1, 1),
}


def ring_samples(facing: str, gap: str, fov: float, width: int = 160) -> dict[str, float]:
    """Brightness of the ring's stroke in the eight directions, seen from 3 m."""
    text = f'[[ring]]\nat=[0,0]\nfacing="{facing}"\nheight=0.37\ngap_mm=5\ngap="{gap}"\n'
    caster = RayCaster(arena_of('name="a"\n[start]\nat=[9,9]\n' + text))
    away = math.radians({"east": 0.0, "north": 90.0, "west": 180.0, "south": -90.0}[facing])
    view = view_of(3 * math.cos(away), 3 * math.sin(away), away + math.pi, fov=fov)
    grey = caster.picture(view, width, width * 3 // 4).mean(axis=2)
    # The stroke's middle is 2 gaps from the centre, and the panel is 2 cm nearer than 3 m.
    radius = 2 * 0.005 * (width / 2 / math.tan(fov / 2)) / 2.98
    samples = {}
    for name, (right, down) in GAPS.items():
        length = math.hypot(right, down)
        column = width / 2 - 0.5 + radius * right / length
        row = width * 3 / 8 - 0.5 + radius * down / length
        samples[name] = float(grey[round(row), round(column)])
    return samples


@for_each("gap", sorted(GAPS))
@for_each("facing", ["east", "north", "west", "south"])
def test_the_gap_of_a_ring_shows_on_its_side_when_zoomed(facing: str, gap: str) -> None:
    samples = ring_samples(facing, gap, math.radians(4.3))
    bright = samples.pop(gap)
    assert bright > max(samples.values()) + 60


def test_the_gap_of_a_ring_does_not_show_without_zoom() -> None:
    samples = ring_samples("east", "up", WIDE)
    assert samples["up"] < max(samples.values()) + 60


def test_a_lying_and_a_sitting_victim_show_skin() -> None:
    for pose in ("sitting", "lying"):
        text = f'[[victim]]\nname="v"\nat=[2,0]\nfacing="west"\npose="{pose}"\n'
        caster = RayCaster(arena_of(VOID + text))
        picture = caster.picture(view_of(0.0, 0.0, 0.0), 160, 120).astype(int)
        red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
        skin = (red > 140) & (red - green > 25) & (green - blue > 15)
        assert skin.sum() > 40, pose
