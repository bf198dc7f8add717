"""Darkness in an arena, and the headlight."""

from __future__ import annotations

import numpy as np
import pytest

from hub.sim.arena import load_arena
from hub.sim.camera.image_noise import DEVIATION, SensorNoise
from hub.sim.camera.lighting import Lighting
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import View
from hub.sim.spatial_pose import SpatialPose
from tests.hub.sim.arenas import VOID, arena_of
from tests.support.magellan import magellan_camera

YELLOW = load_arena("yellow")
VIEW = View(x=5.2, y=0.9, z=0.37, yaw=1.6, pitch=0.0, horizontal_fov=0.85)


def taken(lighting: Lighting) -> np.ndarray:
    return RayCaster(YELLOW).picture(VIEW, 160, 120, lighting).astype(float)


def test_less_light_makes_the_whole_picture_darker_in_proportion() -> None:
    full, half = taken(Lighting()), taken(Lighting(ambient=0.5))
    # Values are cut to whole levels, twice.
    assert np.abs(half - full / 2)[full < 250].max() <= 2.0


def test_in_the_dark_nothing_is_seen() -> None:
    assert taken(Lighting(ambient=0.0)).max() == 0.0


def test_the_headlight_lights_what_is_near_more_than_what_is_far() -> None:
    full, lit = taken(Lighting()), taken(Lighting(ambient=0.0, headlight=1.0))
    depth = RayCaster(YELLOW).depth(VIEW, 160, 120)
    # Haze is not lit, so that only what is near can be compared with daylight.
    share = np.where(full.min(axis=2) > 30, lit.sum(axis=2) / full.sum(axis=2), np.nan)
    near, far = (np.nanmean(share[where]) for where in (depth < 1.5, depth > 4.5))
    assert 0.3 < near <= 1.0
    assert 0.0 < far < near / 3


def test_the_beam_is_brightest_in_its_middle() -> None:
    camera = RayCaster(load_arena("empty"))
    view = View(x=8.5, y=5.0, z=1.0, yaw=0.0, pitch=0.0, horizontal_fov=0.85)
    full = camera.picture(view, 160, 120).astype(float).sum(axis=2)
    lit = camera.picture(view, 160, 120, Lighting(ambient=0.0, headlight=1.0))
    share = lit.astype(float).sum(axis=2) / full
    assert share[55:65, 75:85].mean() > 1.2 * share[:10, :10].mean()
    assert share[:10, :10].mean() > 0.05


def test_half_a_headlight_gives_half_its_light() -> None:
    one = taken(Lighting(ambient=0.0, headlight=1.0))
    half = taken(Lighting(ambient=0.0, headlight=0.5))
    assert np.abs(half - one / 2).max() <= 2.0


def test_an_arena_says_how_bright_it_is_and_a_robot_may_know_better() -> None:
    dark = arena_of(VOID + "[hall]\nlight = 0.1\n")
    assert dark.light == 0.1
    assert arena_of(VOID).light == 1.0
    as_written = magellan_camera(dark).capture(160, 120).mean()
    assert as_written < 0.2 * magellan_camera(dark, light=1.0).capture(160, 120).mean()
    assert magellan_camera(arena_of(VOID), light=0.1).capture(160, 120).mean() == as_written


def test_the_headlight_is_as_bright_as_it_is_told_within_bounds() -> None:
    camera = magellan_camera(YELLOW, light=0.0)
    assert camera.camera_state(0.0).headlight == 0.0
    for told, lit in ((0.4, 0.4), (9.0, 1.0), (-1.0, 0.0), (float("nan"), 0.0)):
        camera.set_headlight(told)
        assert camera.camera_state(0.0).headlight == lit
    camera.set_headlight(1.0)
    assert camera.capture(160, 120).mean() > 10.0


def test_a_robot_without_a_headlight_says_so() -> None:
    camera = magellan_camera(YELLOW, light=0.0, headlight=False)
    camera.set_headlight(1.0)
    assert np.isnan(camera.camera_state(0.0).headlight)
    assert camera.capture(160, 120).mean() < 2.0


def test_pictures_in_the_dark_are_noisy_and_in_full_light_they_are_not() -> None:
    camera = magellan_camera(YELLOW)
    assert np.array_equal(camera.capture(160, 120), camera.capture(160, 120))
    camera = magellan_camera(YELLOW, light=0.5)
    difference = camera.capture(160, 120).astype(float) - camera.capture(160, 120)
    assert difference.std() == pytest.approx(DEVIATION * 2**0.5, rel=0.1)


def test_noise_is_the_same_for_the_same_seed_and_stays_within_bounds() -> None:
    black, white = np.zeros((120, 160, 3), np.uint8), np.full((120, 160, 3), 255, np.uint8)
    one, other = SensorNoise(black.size, 3), SensorNoise(black.size, 3)
    assert np.array_equal(one.added(black), other.added(black))
    assert one.added(black).max() < 20
    assert one.added(white).min() > 235
    assert not np.array_equal(one.added(black), one.added(black))


def test_a_picture_shows_the_time_at_which_the_robot_was_there() -> None:
    camera = magellan_camera(YELLOW)
    assert camera.take(16, 12, 50.0).measured == 50.0
    camera.place(SpatialPose(x=5.0, y=1.0), 49.98)
    assert camera.take(16, 12, 50.0).measured == 49.98
    # Nothing has been heard for long: the robot stands where it stood, also now.
    assert camera.take(16, 12, 60.0).measured == 60.0


def test_a_tall_picture_shows_the_middle_of_what_the_camera_sees() -> None:
    camera = magellan_camera(YELLOW)
    whole, tall = camera.take(320, 240, 0.0), camera.take(80, 240, 0.0)
    assert tall.horizontal_fov < whole.horizontal_fov / 3
    middle = whole.pixels[:, 120:200].astype(int)
    assert (np.abs(tall.pixels.astype(int) - middle) <= 8).mean() > 0.97
