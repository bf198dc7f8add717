"""Where the line of sight of a click ends, and what says so."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.occupancy_map import OccupancyMap
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.line_of_sight import SURE_HEIGHT_M, Surroundings, hidden, place_of_pixel, unsure
from rune_tui.model.pose import Pose
from rune_tui.model.robot_ranges import RobotRanges
from rune_tui.model.world import DistanceSource, WorldPoint
from tests.console.states import range_readings, ranges_around
from tests.support.car import CAR, car_readings, laser_of
from tests.support.magellan import magellan_body
from tests.support.messages import camera_state

WIDTH, HEIGHT = 160, 120
HERE = Pose(x=0.0, y=0.0, theta=0.0)
WALL_M = 1.5
"""How far ahead of the origin the wall's near side is [m]."""


def geometry(mount_height: float = 0.37, tilt: float = -0.1) -> PictureGeometry:
    camera = camera_state(tilt=tilt, mount_forward=0.0, mount_height=mount_height)
    made = PictureGeometry.of(camera, WIDTH, HEIGHT)
    assert made is not None
    return made


def wall(resolution: float = 0.05) -> OccupancyMap:
    """Ten metres square around the origin, free, with a wall across, 1.5 m ahead."""
    size = round(10.0 / resolution)
    cells = np.zeros((size, size), np.int8)
    column = round((WALL_M + 5.0) / resolution)
    cells[:, column : column + 3] = 100
    return OccupancyMap(cells=cells, resolution=resolution, origin_x=-5.0, origin_y=-5.0)


def unknown() -> OccupancyMap:
    cells = np.full((200, 200), -1, np.int8)
    return OccupancyMap(cells=cells, resolution=0.05, origin_x=-5.0, origin_y=-5.0)


def clicked(row: float, seen: PictureGeometry | None = None, **known: object) -> WorldPoint | None:
    """The place of a pixel in the picture's middle column."""
    surroundings = Surroundings(pose=HERE, **known)  # type: ignore[arg-type]
    return place_of_pixel(seen or geometry(), (WIDTH / 2.0, row), 1.0, surroundings)


def around(**readings: Any) -> RobotRanges:
    return ranges_around(magellan_body(), range_readings(**readings))


def row_of_floor(distance: float) -> float:
    row: float = geometry().pixels((distance, 0.0)).pixels[1]
    return row


def test_floor_before_all_that_is_known_is_where_it_was() -> None:
    place = clicked(row_of_floor(1.0), grid=wall())
    assert place is not None
    assert (place.x, place.source) == (pytest.approx(1.0), DistanceSource.FLOOR)
    assert place.height == 0.0


def test_a_body_before_a_wall_is_not_marked_behind_the_wall() -> None:
    """Its breast is seen where the floor would be three metres away."""
    row = row_of_floor(3.1)
    assert clicked(row).x == pytest.approx(3.1)  # type: ignore[union-attr]
    place = clicked(row, grid=wall())
    assert place is not None
    assert place.x == pytest.approx(WALL_M, abs=0.05)
    assert place.source is DistanceSource.MAP
    assert place.height == pytest.approx(0.37 * (1.0 - WALL_M / 3.1), abs=0.02)
    assert place.uncertainty < 0.2


def test_above_the_horizon_a_wall_of_the_map_is_a_place_and_nothing_is_none() -> None:
    row = geometry().horizon - 20.0
    assert clicked(row) is None
    place = clicked(row, grid=wall())
    assert place is not None
    assert place.x == pytest.approx(WALL_M, abs=0.05)
    assert place.height > 0.37


def test_an_echo_counts_where_the_map_knows_nothing() -> None:
    place = clicked(row_of_floor(4.0), grid=unknown(), ranges=around(sonar=2.0))
    assert place is not None
    assert (place.x, place.source) == (pytest.approx(2.0), DistanceSource.RANGES)
    assert place.uncertainty == pytest.approx(2.0 * math.sin(math.radians(27.0 / 2.0)), rel=0.1)


def test_ground_that_the_map_knows_as_free_is_not_cut_by_an_echo_from_beside() -> None:
    place = clicked(row_of_floor(1.2), grid=wall(), ranges=around(sonar=0.8))
    assert place is not None
    assert (place.x, place.source) == (pytest.approx(1.2), DistanceSource.FLOOR)


def test_what_infrared_sees_ends_the_line_whatever_the_map_says() -> None:
    """A person who came after the map was made."""
    infrared = np.full(16, np.inf, np.float32)
    infrared[0] = 0.6
    place = clicked(row_of_floor(1.3), grid=wall(), ranges=around(infrared=infrared))
    assert place is not None
    assert (place.x, place.source) == (pytest.approx(0.6), DistanceSource.RANGES)


def test_a_sensor_finds_what_is_on_the_line_not_what_is_beside_it() -> None:
    """The camera is at the car's origin, its sonar and its laser at its front."""
    far = row_of_floor(6.0)
    place = clicked(far, ranges=ranges_around(CAR, car_readings(front=1.4)))
    assert place is not None
    assert (place.x, place.source) == (pytest.approx(2.0, abs=0.01), DistanceSource.RANGES)
    place = clicked(far, ranges=ranges_around(CAR, car_readings(laser=laser_of(l0=1.0))))
    assert place is not None
    assert place.x == pytest.approx(1.4, abs=0.01)
    beside = ranges_around(CAR, car_readings(laser=laser_of(l3=1.0), side=0.4, down=0.1))
    place = clicked(far, ranges=beside)
    assert place is not None
    assert place.source is DistanceSource.FLOOR


def test_a_line_that_may_pass_over_the_obstacle_says_that_it_may_be_behind_it() -> None:
    high = geometry(mount_height=1.5)
    place = clicked(high.pixels((2.4, 0.0)).pixels[1], high, grid=wall())
    assert place is not None
    assert place.height > SURE_HEIGHT_M
    assert place.uncertainty >= 2.4 - WALL_M - 0.05


@given(st.floats(0.0, 1.0), st.floats(0.0, 0.5), st.floats(0.3, 1.2))
def test_a_pose_that_is_not_sure_makes_a_place_less_sure(
    position: float, heading: float, distance: float
) -> None:
    row = row_of_floor(distance)
    sure = clicked(row, grid=wall())
    unsure = clicked(row, grid=wall(), position_off=position, heading_off=heading)
    assert sure is not None
    assert unsure is not None
    least = 2.0 * math.hypot(position, heading * distance)
    assert unsure.uncertainty >= least * (1.0 - 1e-9)
    assert unsure.uncertainty >= sure.uncertainty
    assert (unsure.x, unsure.y) == (sure.x, sure.y)


@given(
    st.floats(0.0, WIDTH), st.floats(0.0, HEIGHT), st.floats(-3.2, 3.2), st.floats(-100.0, 100.0)
)
def test_any_pixel_from_anywhere_is_a_place_that_the_camera_sees_there_or_none(
    column: float, row: float, theta: float, x: float
) -> None:
    pose = Pose(x=x, y=0.3, theta=theta)
    known = Surroundings(pose=pose, grid=wall(0.2), ranges=around())
    seen = geometry()
    place = place_of_pixel(seen, (column, row), 1.0, known)
    if place is None:
        return
    assert math.isfinite(place.x + place.y + place.height + place.uncertainty)
    ahead, left = pose.from_map((place.x, place.y)).tolist()
    if math.hypot(ahead, left) < 1e-6:  # the camera touches a wall: there is no direction
        return
    up = place.height - seen.mount_height
    bearing, elevation = seen.mount_angles(seen.image_angles((column, row))).tolist()
    assert math.remainder(math.atan2(left, ahead) - bearing, math.tau) == pytest.approx(0, abs=1e-6)
    assert math.atan2(up, math.hypot(ahead, left)) == pytest.approx(elevation, abs=1e-6)


def test_a_mark_behind_a_wall_of_the_map_is_hidden_and_one_at_it_is_not() -> None:
    def is_hidden(x: float) -> bool:
        return hidden(WorldPoint(x=x, y=0.0, uncertainty=0.1), HERE, (0.0, 0.0), wall())

    assert [is_hidden(x) for x in (1.0, WALL_M + 0.1, 3.0)] == [False, False, True]
    assert not hidden(WorldPoint(x=9.0, y=0.0, uncertainty=0.1), HERE, (0.0, 0.0), None)


def test_a_place_on_the_floor_before_a_tilted_robot_may_be_on_the_ramp_or_on_level_ground() -> None:
    floor, wall_ = clicked(row_of_floor(0.8)), clicked(geometry().horizon - 20.0, grid=wall())
    assert floor is not None
    assert wall_ is not None
    level = dataclasses.replace(floor, x=floor.x + 0.5)
    assert unsure(floor, level).uncertainty == pytest.approx(0.5)
    assert unsure(floor, None).uncertainty == floor.distance
    assert unsure(floor, floor) == floor
    assert unsure(wall_, level) == wall_
