"""What the simulated camera shows lies where the geometry says."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.pose import Pose
from tests.console.model.simulated_views import (
    FEET_HIGH,
    FEET_LOW,
    LANDMARK,
    POST,
    POST_RADIUS,
    VICTIM,
    aimed,
    take,
)
from tests.support.cases import for_each


def looked(
    things: str,
    robot: Pose,
    aim: tuple[float, float, float],
    size: tuple[int, int],
    stance: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[npt.NDArray[np.uint8], PictureGeometry]:
    """A picture and its geometry."""
    picture = take(things, robot, aim, size, stance)
    rows, columns = picture.pixels.shape[:2]
    view = PictureGeometry.of(picture.camera, columns, rows)
    assert view is not None
    return picture.pixels, view


def foot_of(
    thing: str,
    robot: Pose,
    aim: tuple[float, float, float],
    size: tuple[int, int],
    stance: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[float, float, float]:
    """Where the lowest pixel that a thing covers is on the ground: map x, y [m], and its range."""
    pixels, view = looked(thing, robot, aim, size, stance)
    empty, _ = looked("", robot, aim, size, stance)
    rows, columns = np.nonzero((pixels != empty).any(axis=2))
    lowest = rows.max()
    assert 0 < lowest < size[1] - 1, "its foot is not in the picture"
    # The foot is between the centres of the lowest row it covers and of the next one.
    found = view.ground_point(columns[rows == lowest].mean() + 0.5, lowest + 1.0)
    assert found is not None
    x, y = robot.to_map(found).tolist()
    return x, y, math.hypot(*found)


@for_each("size", [(160, 120), (320, 240), (240, 240), (320, 120)])
@for_each(
    ("heading", "distance", "zoom", "aside", "up"),
    [
        (0.0, 2.0, 0.0, 0.0, 0.0),
        (0.9, 1.0, 0.0, 0.15, 0.1),
        (-0.7, 1.5, 0.0, -0.2, -0.02),
        (1.4, 2.5, 0.5, 0.1, 0.05),
        (-1.5, 2.5, 0.9, 0.0, 0.02),
        (0.3, 4.0, 0.97, -0.01, -0.01),
    ],
)
def test_the_foot_of_a_post_is_found_within_3_percent(
    size: tuple[int, int], heading: float, distance: float, zoom: float, aside: float, up: float
) -> None:
    """`heading` is that of the robot beside the way to the post, so it is the pan as well."""
    bearing = 0.8
    robot = Pose(
        x=POST[0] - distance * math.cos(bearing),
        y=POST[1] - distance * math.sin(bearing),
        theta=bearing + heading,
    )
    pan, tilt = aimed(robot, POST, aside, up)
    x, y, away = foot_of(LANDMARK, robot, (pan, tilt, zoom), size)
    assert abs(math.dist((x, y), POST) - POST_RADIUS) < 0.03 * away


@pytest.mark.parametrize(
    ("x", "y", "zoom", "aside", "up"),
    [
        (-2.0, -1.5, 0.0, 0.0, 0.0),
        (-1.2, -2.0, 0.0, 0.2, 0.05),
        (-3.5, -1.0, 0.3, -0.1, -0.05),
        (-2.3, 0.5, 0.8, 0.02, 0.02),
    ],
)
def test_the_feet_of_a_victim_are_found_within_3_percent(
    x: float, y: float, zoom: float, aside: float, up: float
) -> None:
    robot = Pose(x=x, y=y, theta=-2.0)
    nearest = tuple(np.clip((x, y), FEET_LOW, FEET_HIGH).tolist())
    pan, tilt = aimed(robot, nearest, aside, up)
    found_x, found_y, away = foot_of(VICTIM, robot, (pan, tilt, zoom), (320, 240))
    beyond = np.clip((found_x, found_y), FEET_LOW, FEET_HIGH) - (found_x, found_y)
    assert float(np.hypot(*beyond)) < 0.03 * away


@for_each(("tilt", "zoom"), [(-0.3, 0.0), (-0.1, 0.6), (0.0, 0.9), (0.2, 0.0), (0.1, 0.3)])
def test_the_horizon_is_where_no_ray_of_the_simulator_falls_any_more(
    tilt: float, zoom: float
) -> None:
    """Floor and ceiling of the empty hall differ in colour; their border is the horizon."""
    pixels, view = looked("", Pose(x=0.0, y=0.0, theta=0.3), (0.4, tilt, zoom), (160, 120))
    ground = view.ground(np.stack(np.indices((120, 160))[::-1] + 0.5, axis=-1)).on_ground
    ceiling = pixels.astype(int)[..., 2] - pixels.astype(int)[..., 0]
    assert ceiling[~ground].min() > ceiling[ground].max()


@for_each(
    ("above", "roll", "pitch", "tilt"),
    [
        (1.2, 0.0, 0.0, -0.4),
        (1.2, 0.25, 0.0, -0.4),
        (1.2, 0.0, 0.2, -0.3),
        (2.0, -0.3, 0.15, -0.4),
        (0.8, 0.15, 0.3, 0.0),
    ],
)
def test_a_robot_that_flies_tilted_finds_the_foot_of_a_post_within_3_percent(
    above: float, roll: float, pitch: float, tilt: float
) -> None:
    robot = Pose(x=POST[0] - 3.0, y=POST[1] - 0.2, theta=0.0)
    x, y, away = foot_of(LANDMARK, robot, (0.0, tilt, 0.0), (320, 240), (above, roll, pitch))
    assert abs(math.dist((x, y), POST) - POST_RADIUS) < 0.03 * away


@for_each(("roll", "pitch", "pan"), [(0.3, 0.0, 0.4), (-0.2, 0.1, -0.8), (0.5, -0.1, 0.0)])
def test_the_horizon_of_a_tilted_robot_is_a_line_across_the_picture(
    roll: float, pitch: float, pan: float
) -> None:
    robot = Pose(x=0.0, y=0.0, theta=0.3)
    pixels, view = looked("", robot, (pan, 0.0, 0.0), (160, 120), (1.0, roll, pitch))
    ground = view.ground(np.stack(np.indices((120, 160))[::-1] + 0.5, axis=-1)).on_ground
    ceiling = pixels.astype(int)[..., 2] - pixels.astype(int)[..., 0]
    assert ceiling[~ground].min() > ceiling[ground].max()
    ends = view.horizon_line
    assert ends is not None
    for x, y in ends:
        assert min(x, 160.0 - x, y, 120.0 - y) == pytest.approx(0.0, abs=1e-6)
        assert view.ground_point(x, y + 1.0) is not None
        assert view.ground_point(x, y - 1.0) is None
