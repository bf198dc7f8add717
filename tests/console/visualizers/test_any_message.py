"""Whatever a robot says, within the bounds of what is taken, every visualizer draws it."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.autonomy import AUTONOMY_STATE
from hub.gcm.fields import FARTHEST_M as LARGEST
from hub.gcm.flight import ALTITUDE
from hub.gcm.imu import IMU
from hub.gcm.mapping import INTEREST_POINTS, InterestPoints
from hub.gcm.navigation import NAVIGATION_STATUS, NavigationStatus, Point, Task
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.supervision import CAPABILITY_REPORTS, MODULE_REPORTS
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Lack, LackKind, Picture, RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.registry import VISUALIZERS
from rune_tui.visualizers.visualizer import Locating
from tests.console.visualizers import known
from tests.console.visualizers.conftest import NOW, Made, made_by, received
from tests.support.messages import camera_state, robot_state

CONTROL = "\x1b[31m\x07\x9b2J\u202e\ud800\n"
TINY = 5e-324
NUMBERS = st.sampled_from(
    (math.nan, math.inf, -math.inf, LARGEST, -LARGEST, TINY, 1e-9, -0.0, 0.0, -1.0, 3.2, 1e6)
)
SIZES = ((1, 2), (3, 4), (16, 8), (40, 30))


def going(path: tuple[Point, ...]) -> NavigationStatus:
    rest = {"number": 1, "sender": 0, "driver": 0, "points_left": 1, "distance_left": 1.0}
    return NavigationStatus(task=Task.GOING, why="", path=path, **rest)


@st.composite
def changed(draw: st.DrawFn, value: Any) -> Any:
    """A message with other numbers in some of its fields."""
    floats = [
        f.name for f in dataclasses.fields(value) if isinstance(getattr(value, f.name), float)
    ]
    names = draw(st.sets(st.sampled_from(floats), max_size=3))
    return dataclasses.replace(value, **{name: draw(NUMBERS) for name in sorted(names)})


@st.composite
def robots(draw: st.DrawFn) -> RobotState:
    marks = known.point(1, by=CONTROL, note=CONTROL)
    path = tuple(Point(x=draw(NUMBERS), y=draw(NUMBERS)) for _ in range(3))
    everything = known.everything() | {
        INTEREST_POINTS: InterestPoints(points=(draw(changed(marks)), marks)),
        NAVIGATION_STATUS: going(path),
        MODULE_REPORTS: known.modules(draw(changed(known.module(CONTROL, why=CONTROL)))),
        AUTONOMY_STATE: draw(changed(known.autonomy(why=CONTROL, sender=1))),
        CAPABILITY_REPORTS: known.capabilities(known.capability(CONTROL, module=CONTROL)),
    }
    everything[ALTITUDE] = draw(changed(everything[ALTITUDE]))
    turned = draw(changed(everything[IMU].orientation))
    everything[IMU] = dataclasses.replace(everything[IMU], orientation=turned)
    shape = draw(st.sampled_from(((6, 8), (1, 1), (1, 300), (300, 1), (0, 4))))
    camera = camera_state(robot_x=0.0, robot_y=0.0, robot_theta=0.0)
    grid = OccupancyMap(
        cells=np.arange(-12, 12, dtype=np.int8).reshape(4, 6),
        resolution=draw(st.sampled_from((1e-3, 0.05, 1e3))),
        origin_x=draw(st.sampled_from((0.0, LARGEST))),
        origin_y=draw(st.sampled_from((0.0, -LARGEST))),
    )
    picture = Picture(pixels=np.zeros((*shape, 3), np.uint8), camera=draw(changed(camera)))
    return Made().robot(
        navigation=received(draw(changed(robot_state(commanded_linear=0.4)))),
        camera=received(draw(changed(camera))),
        picture=draw(st.sampled_from((None, received(picture)))),
        map=received(grid),
        messages={definition.name: received(value) for definition, value in everything.items()},
        link=Made.link(
            detail=CONTROL, lacking={"PRO_MAP": Lack(kind=LackKind.BROKEN, why=CONTROL)}
        ),
    )


def turned(theta: float) -> RobotState:
    """A robot with a picture, ranges and everything else, whose heading is this [rad]."""
    camera = camera_state(robot_x=0.0, robot_y=0.0, robot_theta=0.0)
    navigation = dataclasses.replace(robot_state(), theta=theta)
    everything = {each.name: received(value) for each, value in known.everything().items()}
    picture = Picture(pixels=np.zeros((6, 8, 3), np.uint8), camera=camera)
    return Made().robot(
        navigation=received(navigation), picture=received(picture), messages=everything
    )


@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")
@example(robot=turned(math.inf), size=(40, 30))
@given(robot=robots(), size=st.sampled_from(SIZES))
def test_every_visualizer_draws_whatever_is_taken(robot: RobotState, size: tuple[int, int]) -> None:
    for function in VISUALIZERS:
        try:
            draw(function, robot, size)
        except Exception as error:
            error.add_note(f"by {function}")
            raise


def draw(function: str, robot: RobotState, size: tuple[int, int]) -> None:
    """Draw it, and look at what was drawn."""
    visualizer, state = made_by(function), ConsoleState(now=NOW)
    canvas = Canvas.blank(*size)
    hash(visualizer.source(robot, state))
    visualizer.draw(canvas, robot, state)
    assert all(chr(glyph).isprintable() for glyph in np.unique(canvas.glyphs).tolist() if glyph)
    if visualizer.rule.locates:
        place = cast("Locating", visualizer).locate((0.5, 0.5), size, robot, state)
        assert place is None or math.isfinite(place.x + place.y)
