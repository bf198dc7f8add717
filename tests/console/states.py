"""What a console may know, made for tests."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.diagnostics import Diagnostics
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.ranges import RANGES, RangeReadings, scan_of
from hub.gcm.vision import CAMERA_STATE
from rune_tui.compositor.cells import Cells
from rune_tui.layout.rules import Options
from rune_tui.layout.spec import (
    ArrangementSpec,
    LayoutSpec,
    PlaceSpec,
    ViewportSpec,
    ViewSpec,
    VisualizerSpec,
)
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_ranges import RobotRanges, ranges_of
from rune_tui.model.robot_state import (
    Lack,
    LackKind,
    LinkPhase,
    LinkState,
    Received,
    RobotState,
)
from rune_tui.startup.opening import BUILT_IN
from rune_tui.view import View
from tests.support.magellan import magellan_body

ABSENT = Lack(kind=LackKind.ABSENT, why="this robot has no module for it")
COMING = Lack(kind=LackKind.COMING, why="not started yet")
BROKEN = Lack(kind=LackKind.BROKEN, why="its modules cannot be started")


@functools.cache
def described(name: str) -> Received[RobotBody]:
    """What the hub of a Magellan of this name says of it."""
    body = dataclasses.replace(magellan_body(), name=name)
    return Received(value=body, measured=0.0, number=1)


def range_readings(
    sonar: npt.NDArray[np.float32] | float = 2.0,
    infrared: npt.NDArray[np.float32] | float = math.inf,
) -> RangeReadings:
    """Ranges of a Magellan in the open: every sonar reads 2 m, infrared sees nothing."""
    groups = magellan_body().ranges
    given = {"sonar": sonar, "infrared": infrared}
    return RangeReadings(
        scans=tuple(
            scan_of(group, np.broadcast_to(np.float32(given[group.name]), group.beams), 0.0)
            for group in groups
        )
    )


IN_THE_OPEN = range_readings()


def ranges_around(body: RobotBody, readings: RangeReadings) -> RobotRanges:
    """What the console makes of the readings of a body."""
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
    known = {ROBOT_DESCRIPTION.name: body, RANGES.name: readings}
    messages = {
        name: Received(value=value, measured=0.0, number=1) for name, value in known.items()
    }
    ranges = ranges_of(RobotState(name=body.name, link=link, messages=messages))
    assert ranges is not None
    return ranges


def renamed(robot: RobotState, name: str) -> RobotState:
    """The same robot with another name, which is its role too."""
    return robot.with_(
        name=name, messages={**robot.messages, ROBOT_DESCRIPTION.name: described(name)}
    )


def robot_of(
    *,
    navigation: Received[Any] | None = None,
    camera: Received[Any] | None = None,
    ranges: Received[Any] | None = None,
    messages: Mapping[str, Received[Any]] | None = None,
    **parts: Any,
) -> RobotState:
    """A robot of which its description and these newest messages are known.

    Without ranges, it is in the open, and without diagnostics it has no problems; both are as old
    as its state.
    """
    known = {ROBOT_DESCRIPTION.name: described(parts["name"]), **(messages or {})}
    if navigation is not None:
        known[ROBOT_STATE.name] = navigation
        known.setdefault(RANGES.name, dataclasses.replace(navigation, value=IN_THE_OPEN))
        well = dataclasses.replace(navigation, value=Diagnostics())
        parts.setdefault("diagnostics", {1: well})
    if ranges is not None:
        known[RANGES.name] = ranges
    if camera is not None:
        known[CAMERA_STATE.name] = camera
    return RobotState(messages=known, **parts)


class Standing(NamedTuple):
    """A viewport and where it stands."""

    spec: ViewportSpec
    place: PlaceSpec


def standing(
    name: str,
    visualizer: VisualizerSpec | None,
    place: tuple[int, int, int, int],
    *,
    robot: str = "magellan",
    title: str = "",
    **how: Any,
) -> Standing:
    """A viewport at a place: left, top, width and height [pixels]."""
    x, y, width, height = place
    return Standing(
        ViewportSpec(name=name, robot=robot, visualizer=visualizer, widgets=(), title=title),
        PlaceSpec(viewport=name, xpos=x, ypos=y, xsize=width, ysize=height, **how),
    )


def view_of(
    *viewports: Standing,
    xsize: int = 160,
    ysize: int = 96,
    background: tuple[int, int, int] = (0, 0, 0),
) -> ViewSpec:
    """A view of viewports that stand in the same places whatever the terminal's size."""
    places = tuple(each.place for each in viewports)
    return ViewSpec(
        background=background,
        viewports=tuple(each.spec for each in viewports),
        widgets=(),
        arrangements=(ArrangementSpec(xsize=xsize, ysize=ysize, places=places),),
    )


def layout_of(view: ViewSpec) -> LayoutSpec:
    """A layout of nothing but a view."""
    return LayoutSpec(path="", run_number=0, robots=(), view=view, vocabulary=BUILT_IN)


def visualizer_spec(
    function: str, *, option: float = 0.0, text: str = "", message: str = "", **options: Any
) -> VisualizerSpec:
    """What a layout says of a visualizer; what it leaves out has its default."""
    rule = BUILT_IN.visualizers[function].rule
    return VisualizerSpec(
        function=function,
        message=message or rule.message,
        option=option,
        text=text,
        options=Options.of(rule.options, options),
    )


def rendered(view: View, robots: Mapping[str, RobotState], state: ConsoleState) -> Cells | None:
    """What a view makes of these robots."""
    return view.render(dataclasses.replace(state, robots=robots))
