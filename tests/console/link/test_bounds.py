"""What of a robot's message is taken, whatever it says."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hub.errors import CodecError
from hub.gcm import map_coding
from hub.gcm.mapping import Map
from hub.gcm.vision import Image, ImageCoding
from rune_tui.link.bounds import LARGEST, MOST_ENTRIES, MOST_LETTERS, bounded
from rune_tui.link.pictures import COARSEST_M, FINEST_M, map_of, picture_of
from tests.console.visualizers.known import module, modules, point, points
from tests.messages import camera_state, robot_state

MARKED = points(point(1), point(2, uncertainty=0.0, distance=2.5))


def image(width: int, height: int, **changes: Any) -> Image:
    values: dict[str, Any] = {"coding": ImageCoding.RAW, "channels": 1, "camera": camera_state()}
    data = np.zeros(width * height, np.uint8)
    return Image(width_px=width, height_px=height, length=len(data), data=data, **values | changes)


def coded_map(width: int, height: int, **changes: Any) -> Map:
    data = map_coding.encode(np.zeros((height, width), np.int8))
    values: dict[str, Any] = {"resolution": 0.05, "origin_x": 0.0, "origin_y": 0.0}
    return Map(
        stamp=0.0,
        width_cells=width,
        height_cells=height,
        length=len(data),
        data=data,
        **values | changes,
    )


def test_what_an_ordinary_robot_says_comes_back_as_it_is() -> None:
    ordinary = (robot_state(x=3.0, battery_voltage=math.nan), camera_state(), MARKED)
    assert all(bounded(message) is message for message in ordinary)


def test_numbers_that_no_robot_can_mean_are_not_known() -> None:
    sonar = np.full(16, 3e38, np.float32)
    sonar[3] = np.inf
    kept = bounded(robot_state(x=1e308, y=-1e11, linear=LARGEST, theta=math.inf, sonar=sonar))
    assert math.isnan(kept.x)
    assert math.isnan(kept.y)
    assert kept.linear == LARGEST
    assert kept.theta == math.inf
    assert np.isnan(kept.sonar[:3]).all()
    assert np.isinf(kept.sonar[3])
    assert kept.sonar.dtype == np.float32


@pytest.mark.parametrize("metres", [math.inf, -math.inf, -0.1, 1e300])
def test_a_mark_that_cannot_be_so_far_or_so_unsure_says_nothing_of_it(metres: float) -> None:
    kept = bounded(points(point(1, uncertainty=metres, distance=metres, x=-0.1))).points[0]
    assert math.isnan(kept.uncertainty)
    assert math.isnan(kept.distance)
    assert kept.x == -0.1


def test_lists_and_texts_are_cut_at_any_depth() -> None:
    many = bounded(modules(*[module("m", why="x" * (MOST_LETTERS + 1))] * (MOST_ENTRIES + 5)))
    assert len(many.modules) == MOST_ENTRIES
    assert {len(report.why) for report in many.modules} == {MOST_LETTERS}
    assert len(bounded(modules(*[module("m")] * MOST_ENTRIES)).modules) == MOST_ENTRIES


@pytest.mark.parametrize("size", [(8193, 1), (1, 8193), (2049, 2048)])
def test_a_picture_that_no_terminal_can_show_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(CodecError, match="a picture of"):
        picture_of(image(*size))


def test_a_picture_says_no_more_of_its_camera_than_can_be_meant() -> None:
    assert math.isnan(picture_of(image(4, 3, camera=camera_state(tilt=1e300))).camera.tilt)


@pytest.mark.parametrize(
    "wrong",
    [
        {"resolution": FINEST_M / 2.0},
        {"resolution": COARSEST_M * 2.0},
        {"resolution": math.nan},
        {"resolution": -0.05},
        {"origin_x": 1e300},
        {"origin_x": math.inf},
        {"origin_y": math.nan},
    ],
)
def test_a_map_that_lies_nowhere_or_has_absurd_cells_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(CodecError, match="a map of cells of"):
        map_of(coded_map(3, 2, **wrong))


@pytest.mark.parametrize("size", [(8193, 1), (1, 8193)])
def test_a_map_that_is_too_long_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(CodecError, match="at most 8192"):
        map_of(coded_map(*size))
    assert map_of(coded_map(8192, 1)).cells.shape == (1, 8192)
