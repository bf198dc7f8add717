"""Presses and clicks, and what the console may know when they come, made for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from rune_tui.controls.events import ControlEvent, Hit
from rune_tui.layout.rules import Options
from rune_tui.layout.spec import EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Received, RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.widgets.registry import WIDGETS
from rune_tui.widgets.widget import Widget
from tests.console.visualizers.conftest import NOW, Made, received
from tests.support.messages import camera_state, robot_state

VICTIM, LANDMARK = PointKind.VICTIM, PointKind.LANDMARK
PLACE = WorldPoint(x=3.0, y=-1.0, uncertainty=0.125, distance=2.5)


def spec(handler: str, /, **options: float | str) -> WidgetSpec:
    options_of_it = Options.of(WIDGETS[handler].rule.options, options)
    return WidgetSpec(handler=handler, options=options_of_it, events=(), viewport="camera")


def widget_of(handler: str, robot: str = "magellan", /, **options: float | str) -> Widget:
    return WIDGETS[handler].from_spec(spec(handler, **options), robot)


def event_spec(key: str, control: str = "", value: float = 1.0) -> EventSpec:
    return EventSpec(name=key, control=control, value=value, line=1)


def at(now: float) -> ConsoleState:
    return ConsoleState(now=now)


def down(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True)


def again(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True, repeat=True)


def up(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=False)


def click(
    place: WorldPoint | None = PLACE,
    *,
    in_picture: tuple[float, float] | None = None,
    viewport: str = "camera",
    robot: str = "magellan",
) -> ControlEvent:
    """A click on a viewport that shows this place."""
    hit = Hit(viewport=viewport, x=0.5, y=0.5, place=place, robot=robot, in_picture=in_picture)
    return ControlEvent(name="mouse left", pressed=True, hits=(hit,))


def marked(
    number: int, kind: PointKind = VICTIM, *, x: float = 3.0, y: float = -1.0, by: str = "jane"
) -> InterestPoint:
    empty = np.empty(0, np.uint8)
    return InterestPoint(
        number=number, kind=kind, x=x, y=y, by=by, version=1, kept=1, thumbnail=empty
    )


def points(*marks: InterestPoint, number: int = 1) -> dict[str, Received[Any]]:
    """The message that these are marked."""
    value = InterestPoints(points=marks)
    return {INTEREST_POINTS.name: received(value, number=number)}


def seeing(*marks: InterestPoint, now: float = NOW, **changes: Any) -> ConsoleState:
    """A console of "jane" that knows all of one robot, and that this is marked on its map."""
    values: dict[str, Any] = {
        "navigation": received(robot_state(x=1.0, y=1.0, theta=0.5)),
        "camera": received(camera_state(headlight=0.0)),
        "messages": points(*marks),
    }
    robot: RobotState = Made().robot(**values | changes)
    return ConsoleState(now=now, robots={"magellan": robot}, operator="jane", clock="12:00:00")
