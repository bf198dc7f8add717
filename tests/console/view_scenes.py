"""Robots, viewports and views that the view's tests draw."""

from __future__ import annotations

from typing import Any

import numpy as np

from hub.gcm.navigation import MotionState
from rune_tui.compositor.cells import Cells
from rune_tui.layout.spec import ViewSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.view import View
from tests.console.states import (
    Standing,
    layout_of,
    range_readings,
    rendered,
    robot_of,
    standing,
    view_of,
    visualizer_spec,
)
from tests.support.messages import camera_state, robot_state

STATE = ConsoleState(now=100.0)
CAMERA = camera_state(pan=0.5, tilt=0.1)
NAVIGATION = robot_state(
    linear=0.1,
    commanded_linear=0.1,
    battery_fraction=0.5,
    motion=MotionState.MOVING,
)


def known(value: Any, number: int = 1, age: float = 0.1) -> Received[Any]:
    return Received(value=value, measured=STATE.now - age, number=number)


def robot(name: str = "magellan", shade: int = 200, number: int = 1, **changes: Any) -> RobotState:
    """A linked robot whose camera sees a wall of one shade of red."""
    wall = np.zeros((48, 64, 3), np.uint8)
    wall[..., 0] = shade
    values: dict[str, Any] = {
        "link": LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="tcp://127.0.0.1:1381"),
        "picture": known(Picture(pixels=wall, camera=CAMERA), number),
        "navigation": known(NAVIGATION),
        "camera": known(CAMERA),
        "ranges": known(range_readings(sonar=1.5)),
    }
    return robot_of(name=name, **values | changes)


def viewport(
    function: str, place: tuple[int, int, int, int], *, text: str = "", **changes: Any
) -> Standing:
    shown = visualizer_spec(function, text=text)
    return standing(changes.pop("name", function), **{"visualizer": shown} | changes, place=place)


def view(*viewports: Standing, xsize: int = 160, ysize: int = 96) -> ViewSpec:
    return view_of(*viewports, xsize=xsize, ysize=ysize, background=(1, 2, 3))


EVERYTHING = view(
    viewport("visualizeCameraImage", (0, 0, 160, 94)),
    viewport("visualizeRangeData", (118, 50, 40, 40), zpos=2, transparency=40),
    viewport("visualizePanData", (40, 0, 80, 2), zpos=1),
    viewport("visualizeTiltData", (158, 20, 2, 40), zpos=1),
    viewport("visualizeLabel", (2, 2, 30, 2), zpos=3, text="Magellan"),
    viewport("visualizeStatus", (0, 94, 160, 2), zpos=3),
)


def shown(spec: ViewSpec, columns: int, rows: int, **changes: Any) -> Cells:
    screen = View(layout_of(spec))
    screen.resize(columns, rows)
    cells = rendered(screen, {"magellan": robot(**changes)}, STATE)
    assert cells is not None
    return cells


def words(cells: Cells) -> str:
    return "\n".join("".join(chr(p or 32) for p in row) for row in cells.glyphs.tolist())


def two_panes() -> View:
    """A picture on the left, another robot's state on the right."""
    left = viewport("visualizeCameraImage", (0, 0, 50, 40))
    right = viewport("visualizeStatus", (50, 0, 50, 40), robot="blimp")
    return View(layout_of(view(left, right, xsize=100, ysize=40)))
