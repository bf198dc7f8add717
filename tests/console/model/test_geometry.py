"""Pixels, angles and places on the ground: one way and back."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.vision import CameraState
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.pose import Pose
from tests.console.model.cameras import CAMERAS, FLYING, SIZES, WIDE, camera, geometry, numbers
from tests.support.cases import for_each


def pixel_grid(width: int, height: int) -> npt.NDArray[np.float64]:
    """Centres of some pixels from edge to edge, shape (n, 2)."""
    x = np.unique(np.linspace(0, width - 1, 9).round()) + 0.5
    y = np.unique(np.linspace(0, height - 1, 9).round()) + 0.5
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def built(state: CameraState, size: tuple[int, int]) -> tuple[PictureGeometry, Pose]:
    found, place = PictureGeometry.of(state, *size), Pose.of(state)
    assert found is not None
    assert place is not None
    return found, place


@given(state=st.one_of(CAMERAS, FLYING), size=SIZES)
def test_pixel_to_map_to_pixel_is_the_identity_for_every_pixel_on_the_ground(
    state: CameraState, size: tuple[int, int]
) -> None:
    view, place = built(state, size)
    pixels = pixel_grid(*size)
    ground = view.ground(pixels)
    seen = view.pixels(place.from_map(place.to_map(ground.points[ground.on_ground])))
    assert seen.in_front.all()
    assert seen.inside.all()
    # Metres in the map have 16 digits; a narrow picture of near ground makes most of them.
    focal = view.width / 2.0 / view.half_width
    assert seen.pixels == pytest.approx(pixels[ground.on_ground], abs=1e-9 + 2e-13 * focal)


@given(state=CAMERAS, size=SIZES)
def test_pixels_below_the_horizon_and_only_those_are_on_the_ground(
    state: CameraState, size: tuple[int, int]
) -> None:
    view, _ = built(state, size)
    pixels = pixel_grid(*size)
    ground = view.ground(pixels)
    clear = np.abs(pixels[:, 1] - view.horizon) > 1e-6
    assert (ground.on_ground == (pixels[:, 1] > view.horizon))[clear].all()
    assert (np.isfinite(ground.points).all(axis=1) == ground.on_ground).all()
    assert (np.isfinite(view.spreads(pixels)).all(axis=1) == ground.on_ground).all()


@given(tilt=numbers(-1.5, 1.5), pan=numbers(-3.0, 3.0), x=numbers(0.0, 160.0))
def test_a_pixel_on_the_horizon_is_not_on_the_ground(tilt: float, pan: float, x: float) -> None:
    view = geometry(pan=pan, tilt=tilt)
    assert view.ground_point(x, view.horizon) is None
    assert view.spread(x, view.horizon) is None
    assert view.ground_point(x, view.horizon - 3.0) is None
    assert view.ground_point(x, view.horizon + 3.0) is not None


@given(state=CAMERAS, size=SIZES)
def test_angles_at_the_mount_point_to_the_same_ground(
    state: CameraState, size: tuple[int, int]
) -> None:
    view, _ = built(state, size)
    pixels = pixel_grid(*size)
    aside, up = view.mount_angles(view.image_angles(pixels)).T
    ground = view.ground(pixels)
    near = up < -1e-3
    reach = view.mount_height / np.tan(-up[near])
    ahead, left = reach * np.cos(aside[near]), reach * np.sin(aside[near])
    expected = np.stack((ahead + view.mount_forward, left), axis=1)
    assert ground.points[near] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_angles_are_positive_to_the_left_and_up_and_the_corners_are_half_the_view() -> None:
    view = geometry(160, 120)
    left, up = view.image_angles((0.0, 0.0)).tolist()
    assert left == pytest.approx(WIDE / 2.0)
    assert math.tan(up) == pytest.approx(math.tan(WIDE / 2.0) * 3.0 / 4.0)
    assert view.image_angles((80.0, 60.0)) == pytest.approx([0.0, 0.0])


def test_pan_and_tilt_turn_the_middle_of_the_picture() -> None:
    view = geometry(pan=0.5, tilt=-0.3)
    assert view.mount_angles((0.0, 0.0)) == pytest.approx([0.5, -0.3])
    ahead, left = view.ground_point(80.0, 60.0) or (math.nan, math.nan)
    reach = 0.37 / math.tan(0.3)
    assert ahead == pytest.approx(0.05 + reach * math.cos(0.5))
    assert left == pytest.approx(reach * math.sin(0.5))


def test_a_tilted_picture_bends_angles_as_space_does_not_as_sums_do() -> None:
    view = geometry(tilt=math.radians(-20.0))
    aside, up = np.degrees(view.mount_angles(view.image_angles((160.0, 60.0)))).tolist()
    assert aside == pytest.approx(-25.77, abs=0.01)
    assert up == pytest.approx(-18.15, abs=0.01)


def test_a_narrow_picture_keeps_its_pixels_square() -> None:
    upright = geometry(90, 160)
    left, up = upright.image_angles((45.0 - 10.0, 80.0 - 10.0)).tolist()
    assert left == pytest.approx(up)


@given(state=CAMERAS, x=numbers(0.0, 160.0), y=numbers(0.0, 120.0))
def test_a_picture_shown_elsewhere_and_larger_shows_the_same_ground(
    state: CameraState, x: float, y: float
) -> None:
    view, _ = built(state, (160, 120))
    shown = view.shown(left=7.0, top=-5.0, width=320.0, height=239.0)
    moved = (7.0 + x * 2.0, -5.0 + y * 239.0 / 120.0)
    assert shown.image_angles(moved) == pytest.approx(view.image_angles((x, y)), abs=1e-12)
    assert shown.horizon == pytest.approx(-5.0 + view.horizon * 239.0 / 120.0, abs=1e-6)
    ground = shown.ground(moved)
    if ground.on_ground and 0.1 < x < 159.9 and 0.1 < y < 119.9:
        assert shown.pixels(ground.points).inside


def test_points_behind_beside_and_outside_are_told_apart() -> None:
    view = geometry()
    behind, beside, aside, below, ahead = range(5)
    seen = view.pixels([(-1.0, 0.0), (0.05, 3.0), (1.0, 3.0), (0.2, 0.0), (3.0, 0.0)])
    assert np.flatnonzero(~seen.in_front).tolist() == [behind, beside]
    assert np.flatnonzero(seen.inside).tolist() == [ahead]
    assert np.isnan(seen.pixels[[behind, beside]]).all()
    assert seen.pixels[aside, 0] < 0.0
    assert seen.pixels[below, 1] > 120.0
    many = view.pixels([(-1.0, 0.0), (1.0, 3.0), (3.0, 0.0)])
    assert many.in_front.tolist() == [False, True, True]
    assert many.inside.tolist() == [False, False, True]
    assert np.isnan(many.pixels).any(axis=1).tolist() == [True, False, False]


def test_straight_down_shows_the_ground_below_the_camera() -> None:
    view = geometry(tilt=-math.pi / 2.0)
    assert view.ground_point(80.0, 60.0) == pytest.approx((0.05, 0.0))
    assert view.horizon == -math.inf
    spread = view.spread(80.0, 60.0)
    assert spread is not None
    pixel_m = 0.37 * 2.0 * math.tan(WIDE / 2.0) / 160.0
    assert (spread.along, spread.across) == pytest.approx((pixel_m, pixel_m))


@given(
    tilt=numbers(-1.2, 0.3), pan=numbers(-2.0, 2.0), x=numbers(1.0, 159.0), y=numbers(1.0, 119.0)
)
def test_spread_is_what_half_a_pixel_to_all_sides_changes(
    tilt: float, pan: float, x: float, y: float
) -> None:
    view = geometry(tilt=tilt, pan=pan)
    if y < view.horizon + 5.0:
        return
    small = 1e-3
    steps = np.array([(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)]) * small / 2.0
    west, east, north, south = view.ground(steps + np.array((x, y))).points
    middle = np.array(view.ground_point(x, y)) - (0.05, 0.0)
    sight = middle / np.hypot(*middle)
    beside = np.array((-sight[1], sight[0]))
    spread = view.spread(x, y)
    assert spread is not None
    for direction, told in ((sight, spread.along), (beside, spread.across)):
        moved = abs((east - west) @ direction) + abs((south - north) @ direction)
        assert told == pytest.approx(moved / small, rel=1e-4)


@for_each(
    "wrong",
    [
        {"horizontal_fov": 0.0},
        {"horizontal_fov": math.nan},
        {"horizontal_fov": math.pi},
        {"pan": math.nan},
        {"tilt": math.inf},
        {"mount_height": 0.0},
        {"mount_height": math.nan},
        {"mount_forward": math.nan},
    ],
)
def test_a_state_that_tells_no_view_has_no_geometry(wrong: dict[str, float]) -> None:
    assert PictureGeometry.of(camera(**wrong), 160, 120) is None


def test_an_empty_picture_has_no_geometry() -> None:
    assert PictureGeometry.of(camera(), 0, 120) is None
    assert PictureGeometry.of(camera(), 160, 0) is None


@pytest.mark.parametrize("unknown", ["robot_x", "robot_y", "robot_theta"])
def test_a_robot_without_a_place_has_none_in_the_map(unknown: str) -> None:
    assert Pose.of(camera(**{unknown: math.nan})) is None


def test_a_robot_that_looks_north_has_its_left_in_the_west() -> None:
    place = Pose(x=2.0, y=3.0, theta=math.pi / 2.0)
    assert place.to_map((1.0, 0.5)) == pytest.approx([1.5, 4.0])
    assert place.from_map((1.5, 4.0)) == pytest.approx([1.0, 0.5])


@given(
    size=SIZES,
    x=st.floats(allow_nan=True, allow_infinity=True),
    y=st.floats(allow_nan=True, allow_infinity=True),
)
def test_no_pixel_whatever_its_numbers_gives_half_a_place(
    size: tuple[int, int], x: float, y: float
) -> None:
    view = geometry(*size, tilt=-0.2)
    with np.errstate(all="ignore"):
        found = view.ground_point(x, y)
    assert found is None or all(map(math.isfinite, found))


@given(state=FLYING, x=numbers(1.0, 159.0), y=numbers(1.0, 119.0))
def test_the_spread_of_a_pixel_of_a_tilted_robot_is_what_its_sides_differ_by(
    state: CameraState, x: float, y: float
) -> None:
    view, _ = built(state, (160, 120))
    spread, place = view.spread(x, y), view.ground_point(x, y)
    small = 1e-4
    sides = [view.ground_point(x + small, y), view.ground_point(x, y + small)]
    if spread is None or place is None or None in sides or spread.along > 1.0:
        return
    steps = [(side[0] - place[0], side[1] - place[1]) for side in sides if side]
    away = math.atan2(place[1] - view.mount_left, place[0] - view.mount_forward)
    cos, sin = math.cos(away), math.sin(away)
    along = sum(abs(dx * cos + dy * sin) for dx, dy in steps) / small
    across = sum(abs(dy * cos - dx * sin) for dx, dy in steps) / small
    assert (spread.along, spread.across) == pytest.approx((along, across), rel=1e-2, abs=1e-4)


def test_a_robot_that_flies_has_a_geometry_only_while_it_knows_its_height() -> None:
    low = camera(mount_height=0.0, robot_above_ground=0.4)
    assert PictureGeometry.of(low, 160, 120) is not None
    unknown = camera(robot_above_ground=math.nan)
    assert PictureGeometry.of(unknown, 160, 120) is None


def test_the_ground_of_a_robot_that_stands_tilted_is_the_plane_under_its_wheels() -> None:
    tilted = {"robot_roll": 0.1, "robot_pitch": -0.2}
    assert geometry(**tilted) == geometry()
    level = PictureGeometry.of(camera(**tilted), 160, 120, level=True)
    assert level is not None
    assert level.horizon == pytest.approx(
        60.0 * (1.0 + math.tan(0.2) / level.half_height), rel=0.01
    )
