"""The simulated camera: where its head can look, how fast, and what it takes."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.vision import CameraCommand, CameraMotion
from hub.robots.simulated_camera import SimulatedCamera
from hub.sim.arena import load_arena
from hub.sim.camera.pan_tilt_zoom import PAN_SPEED, TILT_SPEED, PanTiltZoom
from hub.sim.spatial_pose import SpatialPose
from tests.support.magellan import magellan_body, magellan_camera

BODY = magellan_body().cameras[0]
TELE_FOV = 2.0 * math.atan(math.tan(BODY.horizontal_fov / 2.0) / BODY.zoom)
ANY = st.floats(allow_nan=True, allow_infinity=True)


def camera() -> SimulatedCamera:
    return magellan_camera(load_arena("empty"))


@given(commands=st.lists(st.tuples(st.booleans(), ANY, ANY, ANY, st.floats(0.0, 3.0)), max_size=6))
def test_no_commands_bring_the_head_beyond_its_limits_or_make_it_faster(
    commands: list[tuple[bool, float, float, float, float]],
) -> None:
    head = PanTiltZoom(BODY.pan_limit, BODY.tilt_lowest, BODY.tilt_highest)
    for relative, pan, tilt, zoom, seconds in commands:
        before = (head.pan, head.tilt, head.zoom)
        (head.go_by if relative else head.go_to)(pan, tilt, zoom)
        head.advance(seconds)
        assert abs(head.pan) <= BODY.pan_limit
        assert abs(head.tilt) <= BODY.tilt_highest
        assert 0.0 <= head.zoom <= 1.0
        assert abs(head.pan - before[0]) <= PAN_SPEED * seconds + 1e-9
        assert abs(head.tilt - before[1]) <= TILT_SPEED * seconds + 1e-9
        assert abs(head.zoom - before[2]) <= 0.5 * seconds + 1e-9


def test_the_head_takes_its_time_and_says_so() -> None:
    it = camera()
    it.move(CameraCommand(motion=CameraMotion.ABSOLUTE, pan=1.0, tilt=-0.2, zoom=1.0))
    it.advance(0.5)
    state = it.camera_state(3.0)
    assert state.pan == pytest.approx(0.5 * PAN_SPEED)
    assert (state.tilt, state.zoom, state.slewing) == (-0.2, pytest.approx(0.25), 1)
    it.advance(2.0)
    state = it.camera_state(4.0)
    assert (state.stamp, state.pan, state.zoom, state.slewing) == (4.0, 1.0, 1.0, 0)
    assert state.horizontal_fov == pytest.approx(TELE_FOV)


def test_relative_commands_add_up_even_when_they_come_quickly() -> None:
    it = camera()
    for _ in range(3):
        it.move(CameraCommand(pan=0.1))
    it.advance(1.0)
    assert it.camera_state(0.0).pan == pytest.approx(0.3)


def test_not_a_number_leaves_an_amount_and_home_looks_ahead() -> None:
    it = camera()
    it.move(CameraCommand(motion=CameraMotion.ABSOLUTE, pan=0.5, tilt=0.2, zoom=0.5))
    it.move(CameraCommand(motion=CameraMotion.ABSOLUTE, pan=math.nan, tilt=-math.inf, zoom=0.1))
    it.advance(5.0)
    state = it.camera_state(0.0)
    assert (state.pan, state.tilt, state.zoom) == (0.5, BODY.tilt_lowest, 0.1)
    it.move(CameraCommand(motion=CameraMotion.HOME))
    it.advance(5.0)
    state = it.camera_state(0.0)
    assert (state.pan, state.tilt, state.zoom) == (0.0, 0.0, 0.0)
    assert state.horizontal_fov == pytest.approx(BODY.horizontal_fov)
    assert math.tan(state.vertical_fov / 2) == pytest.approx(
        math.tan(BODY.horizontal_fov / 2) * 0.75
    )


@pytest.mark.parametrize(
    ("asked", "got"),
    [((160, 120), (160, 120)), ((9999, 9999), (320, 240)), ((0, -5), (1, 1)), ((320, 1), (320, 1))],
)
def test_pictures_are_never_larger_than_the_sensor(
    asked: tuple[int, int], got: tuple[int, int]
) -> None:
    picture = camera().capture(*asked)
    assert picture.shape == (got[1], got[0], 3)


def test_panning_left_moves_the_picture_right() -> None:
    it = camera()
    red = np.array([214, 40, 40])

    def sign_column() -> float:
        picture = it.capture(160, 120).astype(int)
        near = (picture[..., 0] - picture[..., 1] > 45) & (
            np.abs(picture[..., 1] - picture[..., 2]) < 12
        )
        assert near.sum() > 20, red
        return float(np.nonzero(near)[1].mean())

    it.place(SpatialPose(x=6.0))
    ahead = sign_column()
    it.move(CameraCommand(pan=0.15))
    it.advance(1.0)
    assert sign_column() > ahead + 15


def test_the_camera_sees_the_same_when_robot_and_head_turn_against_each_other() -> None:
    it = camera()
    it.place(SpatialPose())
    straight = it.capture(80, 60)
    x, y = 0.05 - 0.05 * math.cos(0.5), -0.05 * math.sin(0.5)
    it.place(SpatialPose(x=x, y=y, yaw=0.5))
    it.move(CameraCommand(pan=-0.5))
    it.advance(2.0)
    turned = it.capture(80, 60)
    assert (turned == straight).mean() > 0.99


@pytest.mark.parametrize("value", [math.nan, math.inf, -1e300])
def test_a_place_that_is_nowhere_does_no_harm(value: float) -> None:
    it = camera()
    it.place(SpatialPose(x=value, y=value))
    it.place(SpatialPose(yaw=value))
    assert it.capture(20, 15).shape == (15, 20, 3)


def test_two_cameras_take_the_same_picture_bit_for_bit() -> None:
    pictures = []
    for _ in range(2):
        it = magellan_camera(load_arena("yellow"))
        it.place(SpatialPose(x=5.0, y=3.0, yaw=1.0))
        pictures.append(it.capture(160, 120))
    assert (pictures[0] == pictures[1]).all()


def test_pictures_of_many_sizes_do_not_fill_the_memory() -> None:
    it = camera()
    tracemalloc.start()
    try:
        for width in range(300, 316):
            it.capture(width, 240)
        kept, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert kept < 15e6
