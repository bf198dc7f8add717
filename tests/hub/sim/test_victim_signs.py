"""Heat, motion, sound and breath of victims, as robots sense them."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest

from hub.gcm.body import BodyFrame, CameraBody
from hub.modules.driver.reports import environment
from hub.robots.registry import kind_of
from hub.robots.robot_file import find_robot_file, read_description
from hub.robots.simulated_camera import WAVE_S, SimulatedCamera
from hub.sim.arena import Arena, arena_from_spec
from hub.sim.arena_file import check_arena
from hub.sim.camera.heat import COLDEST_C, WARMEST_C, heat_colour
from hub.sim.senses import FRESH_PPM, QUIET_DB, WALL_DB, VictimSenses
from hub.sim.spatial_pose import SpatialPose

VICTIM = """
[[victim]]
name = "one"
at = [4.0, 2.0]
facing = "west"
co2_ppm = 500
sound_db = 70
"""
MOUTH = (3.85, 2.0, 0.62)
WALL = "[[wall]]\nfrom = [2.5, 0.0]\nto = [2.5, 4.0]\nheight = 2.0\n"


def arena_of(text: str) -> Arena:
    head = 'name = "a"\n[start]\nat = [1.0, 2.0]\n'
    spec, problems = check_arena(tomllib.loads(head + text))
    assert spec is not None, problems
    return arena_from_spec(spec)


def camera(arena: Arena, *, heat: bool = False) -> SimulatedCamera:
    made = SimulatedCamera(
        arena,
        body=CameraBody(name="camera", horizontal_fov=1.0),
        mount=BodyFrame(name="camera", z=0.4),
        heat=heat,
        headlight=False,
    )
    made.place(SpatialPose(x=2.6, y=2.0))
    return made


@pytest.mark.parametrize("away", [0.5, 1.0, 2.0])
def test_sound_and_breath_fall_with_the_square_of_the_distance(away: float) -> None:
    sound, co2 = VictimSenses(arena_of(VICTIM)).at(MOUTH[0] - away, *MOUTH[1:])
    quiet = 10.0 ** (QUIET_DB / 10.0)
    assert 10.0 ** (sound / 10.0) - quiet == pytest.approx(1e7 / away**2)
    assert co2 == pytest.approx(FRESH_PPM + 500.0 / away**2)


def test_a_wall_damps_the_sound_and_keeps_the_breath_back() -> None:
    here = (1.0, 2.0, 0.62)
    open_sound, _ = VictimSenses(arena_of(VICTIM)).at(*here)
    sound, co2 = VictimSenses(arena_of(VICTIM + WALL)).at(*here)
    assert open_sound - sound == pytest.approx(WALL_DB, abs=1.5)
    assert co2 == FRESH_PPM


def test_a_silent_victim_that_does_not_breathe_is_not_sensed() -> None:
    text = VICTIM.replace("500", "0").replace("70", "0")
    assert VictimSenses(arena_of(text)).at(3.0, 2.0, 0.6) == (QUIET_DB, FRESH_PPM)


def test_a_camera_of_heat_sees_skin_bright_also_in_the_dark() -> None:
    dark = "[hall]\nlight = 0.0\n"
    picture = camera(arena_of(dark + VICTIM), heat=True).capture(80, 60)
    skin, air = np.array(heat_colour(33.0)), np.array(heat_colour(20.0))
    near_skin = np.abs(picture.astype(int) - skin).sum(axis=2) < 60
    assert 20 < near_skin.sum() < 1500
    assert np.abs(picture.astype(int) - air).sum(axis=2).min() < 30
    cold = camera(arena_of(dark + VICTIM + "skin_c = 20\n"), heat=True).capture(80, 60)
    assert not (np.abs(cold.astype(int) - skin).sum(axis=2) < 60).any()


def test_colours_of_heat_grow_brighter() -> None:
    levels = [sum(heat_colour(each)) for each in np.linspace(COLDEST_C - 5, WARMEST_C + 5, 40)]
    assert (np.diff(levels) >= 0).all()
    assert (levels[0], levels[-1]) == (0, 765)


@pytest.mark.parametrize("pose", ["sitting", "lying"])
def test_a_victim_that_moves_changes_the_picture_with_time(pose: str) -> None:
    text = f'{VICTIM}pose = "{pose}"\n'
    for moves in (True, False):
        it = camera(arena_of(text + f"moves = {str(moves).lower()}\n"))
        first = it.capture(80, 60)
        it.advance(WAVE_S)
        second = it.capture(80, 60)
        it.advance(WAVE_S)
        assert (first != second).any() is np.bool_(moves)
        assert np.array_equal(first, it.capture(80, 60))


def test_the_tracked_robot_measures_the_air() -> None:
    robot, _ = read_description(find_robot_file("tracked"), ("simulation.arena=yellow",))
    report = environment(kind_of(robot).open_body(robot).sensors(0.0), 5.0)
    assert report is not None
    assert report.sound >= QUIET_DB
    assert report.co2 >= FRESH_PPM
    other, _ = read_description(find_robot_file("magellan"))
    assert environment(kind_of(other).open_body(other).sensors(0.0), 5.0) is None
    assert math.isfinite(report.stamp)
