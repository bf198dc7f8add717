"""Cameras that roll and look steeply down, and cameras on robots that pitch and roll."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import BodyFrame
from hub.sim.arena import load_arena
from hub.sim.camera.mount import mounted_view
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.camera.view import CameraFrame, View
from hub.sim.spatial_pose import SpatialPose
from tests.hub.sim.arenas import VOID, arena_of, free_poses
from tests.hub.sim.camera.slow_rays import rays_of, slow_depth
from tests.support.magellan import magellan_camera, magellan_mount
from tests.support.repetitions import repetitions

YELLOW = load_arena("yellow")
FOV = math.radians(60.0)
ANGLES = st.floats(-math.pi, math.pi)
PITCHES = st.floats(-1.5, 1.5)
RED_HALL = arena_of(VOID + '[hall]\nfloor_colour="red"\nfloor_texture="plain"\n')
RED_FLOOR = RayCaster(RED_HALL)


def reddish(picture: np.ndarray) -> np.ndarray:
    return picture[..., 0].astype(int) - picture[..., 1] > 30


def test_depth_at_any_roll_and_pitch_equals_the_slow_computation() -> None:
    caster = RayCaster(YELLOW)
    random = np.random.default_rng(8)
    poses = free_poses(YELLOW, repetitions(10, 60), 9, 0.3, 9.7)
    different = 0
    for pose in poses:
        view = View(
            x=pose.x,
            y=pose.y,
            z=float(random.uniform(0.3, 2.8)),
            yaw=pose.theta,
            pitch=float(random.uniform(-1.57, 0.8)),
            roll=float(random.uniform(-math.pi, math.pi)),
            horizontal_fov=float(random.uniform(0.3, 1.4)),
        )
        drawn = caster.depth(view, 80, 60)
        different += int((np.abs(drawn - slow_depth(YELLOW, view, 80, 60)) > 0.005).sum())
    assert different <= 0.0005 * len(poses) * 80 * 60


def test_a_picture_rolled_by_180_degrees_is_the_turned_picture() -> None:
    caster = RayCaster(YELLOW)
    for pose in free_poses(YELLOW, 8, 4, 0.3, 9.7):
        view = View(
            x=pose.x, y=pose.y, z=0.6, yaw=pose.theta, pitch=-0.2, horizontal_fov=FOV, roll=math.pi
        )
        level = replace(view, roll=0.0)
        turned = caster.depth(view, 80, 60)[::-1, ::-1]
        assert (np.abs(turned - caster.depth(level, 80, 60)) > 0.02).mean() < 1e-4
        seen = caster.picture(view, 80, 60)[::-1, ::-1].astype(int)
        assert (np.abs(seen - caster.picture(level, 80, 60)) > 8).mean() < 0.01


def test_a_hair_of_roll_changes_nearly_nothing() -> None:
    """The way of cameras that roll and the way of level ones are two computations."""
    caster = RayCaster(YELLOW)
    different = 0
    for pose in free_poses(YELLOW, 8, 5, 0.3, 9.7):
        level = View(x=pose.x, y=pose.y, z=0.4, yaw=pose.theta, pitch=-0.2, horizontal_fov=FOV)
        rolled = replace(level, roll=1e-9)
        far = np.abs(caster.depth(level, 160, 120) - caster.depth(rolled, 160, 120)) > 0.02
        different += int(far.sum())
    assert different <= 8


@given(pitch=PITCHES, roll=ANGLES, yaw=ANGLES)
def test_the_horizon_lies_where_pitch_and_roll_put_it(
    pitch: float, roll: float, yaw: float
) -> None:
    """It passes the middle at the focal length times tan(pitch), turned by the roll."""
    frame = CameraFrame(40, 30)
    view = View(x=0.0, y=0.0, z=1.0, yaw=yaw, pitch=pitch, roll=roll, horizontal_fov=FOV)
    frame.aim(view)
    across, up = np.meshgrid(frame.across, frame.up)
    above = math.cos(roll) * up - math.sin(roll) * across + math.tan(pitch)
    certain = np.abs(above) > 1e-5
    red = reddish(RED_FLOOR.picture(view, 40, 30))
    assert (red == (above < 0.0))[certain].all()


Vector = tuple[float, float, float]


def turned(vector: Vector, *turns: tuple[float, float, float]) -> np.ndarray:
    """A vector turned by roll, pitch and yaw, about fixed axes in this order, for each turn."""
    x, y, z = vector
    for roll, pitch, yaw in turns:
        y, z = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
        x, z = x * math.cos(pitch) + z * math.sin(pitch), z * math.cos(pitch) - x * math.sin(pitch)
        x, y = x * math.cos(yaw) - y * math.sin(yaw), x * math.sin(yaw) + y * math.cos(yaw)
    return np.array((x, y, z))


@given(
    robot=st.tuples(ANGLES, PITCHES, ANGLES),
    mount=st.just((0.0, 0.0, 0.0)) | st.tuples(ANGLES, PITCHES, ANGLES),
    pan=ANGLES,
    tilt=PITCHES,
)
def test_a_mounted_camera_looks_along_the_turned_axes(
    robot: Vector, mount: Vector, pan: float, tilt: float
) -> None:
    view = mounted_view(
        SpatialPose(x=1.0, y=2.0, z=0.5, roll=robot[0], pitch=robot[1], yaw=robot[2]),
        BodyFrame(name="camera", x=0.3, y=0.1, z=0.4, roll=mount[0], pitch=mount[1], yaw=mount[2]),
        pan=pan,
        tilt=tilt,
        horizontal_fov=FOV,
    )
    right, up, forward = view.basis()
    head = (0.0, -tilt, pan)
    eye = np.array((1.0, 2.0, 0.5)) + turned((0.3, 0.1, 0.4), robot)
    assert np.allclose(view.eye, eye, atol=1e-9)
    assert np.allclose(forward, turned((1.0, 0.0, 0.0), head, mount, robot), atol=1e-9)
    assert np.allclose(up, turned((0.0, 0.0, 1.0), head, mount, robot), atol=1e-7)
    assert np.allclose(right, np.cross(forward, up), atol=1e-9)


@given(theta=ANGLES, pan=ANGLES, tilt=PITCHES, yaw=ANGLES)
def test_a_level_robot_and_one_that_hardly_tilts_see_the_same(
    theta: float, pan: float, tilt: float, yaw: float
) -> None:
    stand = SpatialPose(x=1.0, y=2.0, yaw=theta)
    mount = BodyFrame(name="camera", x=0.3, y=0.1, yaw=yaw)
    level, other = (
        mounted_view(each, mount, pan=pan, tilt=tilt, horizontal_fov=FOV)
        for each in (stand, replace(stand, pitch=1e-12))
    )
    assert level.roll == 0.0
    assert np.allclose(level.eye, other.eye, atol=1e-9)
    assert np.allclose(level.basis(), other.basis(), atol=1e-7)


def test_a_robot_nose_down_sees_more_floor_and_one_that_rolls_sees_it_slanted() -> None:
    camera = magellan_camera(RED_HALL)

    def floor(**stand: float) -> np.ndarray:
        camera.place(SpatialPose(**stand))
        return reddish(camera.capture(80, 60))

    level = floor().mean()
    assert floor(pitch=0.15).mean() > level + 0.1
    assert floor(pitch=-0.15).mean() < level - 0.1
    rolled = floor(roll=0.3)
    # Its right side is down, so that the floor stands higher in the right half of the picture.
    assert rolled[:, :20].mean() < rolled[:, 60:].mean()


def test_the_camera_moves_with_the_robot_that_pitches() -> None:
    stand = SpatialPose(pitch=math.pi / 2)
    mount = magellan_mount()
    view = mounted_view(stand, mount, pan=0.0, tilt=0.0, horizontal_fov=FOV)
    assert (view.x, view.z) == (pytest.approx(mount.z), pytest.approx(-mount.x))
    assert rays_of(view, 2, 2).mean(axis=(0, 1)) == pytest.approx((0.0, 0.0, -1.0), abs=1e-9)


@pytest.mark.parametrize("z", [-3.0, 0.0, 3.0, 90.0])
def test_a_camera_in_the_floor_or_the_ceiling_draws_from_just_inside(z: float) -> None:
    caster = RayCaster(YELLOW)
    view = View(x=5.2, y=0.9, z=z, yaw=1.5, pitch=0.0, horizontal_fov=FOV, roll=0.1)
    depth = caster.depth(view, 40, 30)
    assert np.isfinite(depth).all()
    assert (depth > 0.0).all()
    assert caster.picture(view, 40, 30).shape == (30, 40, 3)


@pytest.mark.parametrize("name", ["z", "roll", "pitch"])
def test_a_stand_that_is_no_number_is_ignored(name: str) -> None:
    camera = magellan_camera(YELLOW)
    before = camera.capture(40, 30)
    camera.place(SpatialPose(x=1.0, y=1.0, yaw=1.0, **{name: math.nan}), 0.0)
    assert np.array_equal(camera.capture(40, 30), before)
