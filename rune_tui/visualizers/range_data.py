"""visualizeRangeData: the robot from above, a pie for each range sensor."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar, Final, Self

import numpy as np

from hub.gcm.navigation import SENSOR_COUNT
from hub.gcm.navigation import RobotState as NavigationState
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import Pen, Point, drawing, toward
from rune_tui.visualizers.notice import write_notice
from rune_tui.visualizers.staleness import age_look, mark_age, weather

BODY_RADIUS_M: Final = 0.203
NEAR_M: Final = 0.5
DEFAULT_RIM_M: Final = 3.0

_OPENING = 2.0 * math.pi / SENSOR_COUNT
_SMOOTHING = 3
_FREE: Final[Colour] = (70, 130, 180, 130)
_UNBOUNDED: Final[Colour] = (70, 130, 180, 50)
_NEAR: Final[Colour] = (255, 140, 0, 210)
_ECHO: Final[Colour] = (170, 215, 255, 255)
_INFRARED: Final[Colour] = (255, 120, 220, 255)


@dataclass(frozen=True, slots=True)
class _Plan:
    """Where things are on the canvas [pixels].

    Attributes:
        centre: The robot's centre.
        rim: Length of `rim_m`.
        rim_m: Range at the rim [m].
        body: Radius of the body.
    """

    centre: Point
    rim: float
    rim_m: float
    body: float

    def length(self, range_m: float) -> float:
        """A range from the robot's centre [m], no further than the rim, in pixels."""
        return min(range_m, self.rim_m) / self.rim_m * self.rim


@dataclass(frozen=True, slots=True)
class RangeData:
    """A pie for each sonar, an arc for each infrared sensor, a wedge for each pressed bumper.

    What is near has a colour of its own and an exclamation mark; a pressed bumper has a "B".
    All else is clear, so that it can lie over video.

    Attributes:
        rim_m: Range at the rim of the drawing, from the robot's centre [m].
    """

    rim_m: float = DEFAULT_RIM_M

    rule: ClassVar = VisualizerRule(
        meaning="the robot and a pie for each range sensor",
        message="GCM_RobotState",
        option=NumberOption(
            default=0.0, least=0.0, most=100.0, unit="m", meaning="range at the rim; 0 means 3 m"
        ),
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for; its option is the range at the rim [m]."""
        sensible = math.isfinite(spec.option) and spec.option > BODY_RADIUS_M
        return cls(spec.option if sensible else DEFAULT_RIM_M)

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the newest ranges and their age."""
        if robot.navigation is None:
            write_notice(canvas, f"no ranges from {robot.name} yet", state.theme)
            return
        navigation = robot.navigation.value
        age = robot.navigation.age(state.now)
        rim = max(1.0, min(canvas.width, canvas.height) / 2.0 - 0.5)
        plan = _Plan(
            centre=(canvas.width / 2.0, canvas.height / 2.0),
            rim=rim,
            rim_m=self.rim_m,
            body=max(BODY_RADIUS_M / self.rim_m * rim, min(2.0, rim / 3.0)),
        )
        with drawing(canvas, smoothing=_SMOOTHING) as pen:
            _draw_ranges(pen, plan, navigation, state.theme)
            _draw_body(pen, plan, navigation, state.theme)
        weather(canvas, age)
        _write_marks(canvas, plan, navigation, state.theme)
        mark_age(canvas, age, state.theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with what is measured and the look of its age."""
        if robot.navigation is None:
            return robot.name, state.theme.name
        navigation = robot.navigation.value
        measured = (navigation.sonar.tobytes(), navigation.infrared.tobytes(), navigation.bumpers)
        return measured, age_look(robot.navigation, state.now), state.theme.name


def is_near(range_m: float) -> bool:
    """Whether something at this range from the robot's centre [m] is close to its body."""
    return range_m - BODY_RADIUS_M < NEAR_M


def pressed_bumpers(navigation: NavigationState) -> list[int]:
    """Numbers of the bumpers that are pressed."""
    return [sensor for sensor in range(SENSOR_COUNT) if navigation.bumpers >> sensor & 1]


def _direction(sensor: int) -> float:
    return sensor * _OPENING


def _draw_ranges(pen: Pen, plan: _Plan, navigation: NavigationState, theme: Theme) -> None:
    for sensor, reading in enumerate(navigation.sonar.tolist()):
        if math.isnan(reading):
            continue
        reach = plan.length(reading)
        colour = _NEAR if is_near(reading) else _FREE if math.isfinite(reading) else _UNBOUNDED
        pen.pie(plan.centre, reach, _direction(sensor), _OPENING, colour)
        if reading <= plan.rim_m:
            rim = theme.warning if is_near(reading) else _ECHO
            pen.arc(plan.centre, reach, _direction(sensor), _OPENING, rim)
    for sensor, reading in enumerate(navigation.infrared.tolist()):
        if reading <= plan.rim_m:
            reach = max(plan.length(reading), plan.body + 1.0)
            pen.arc(plan.centre, reach, _direction(sensor), _OPENING / 2.0, _INFRARED)


def _draw_body(pen: Pen, plan: _Plan, navigation: NavigationState, theme: Theme) -> None:
    for sensor in pressed_bumpers(navigation):
        pen.pie(plan.centre, plan.body + 2.0, _direction(sensor), _OPENING, theme.alarm)
    pen.circle(plan.centre, plan.body, fill=theme.panel, rim=theme.ink)
    pen.line([plan.centre, toward(plan.centre, plan.body + 1.0, 0.0)], theme.ink)


def _write_marks(canvas: Canvas, plan: _Plan, navigation: NavigationState, theme: Theme) -> None:
    for sensor, reading in enumerate(navigation.sonar.tolist()):
        if is_near(reading):
            reach = max(plan.length(reading), plan.body) + 1.5
            _write_at(canvas, toward(plan.centre, reach, _direction(sensor)), "!", theme.warning)
    for sensor in pressed_bumpers(navigation):
        _write_at(
            canvas, toward(plan.centre, plan.body + 1.0, _direction(sensor)), "B", theme.on_alarm
        )


def _write_at(canvas: Canvas, point: Point, mark: str, colour: Colour) -> None:
    column = int(np.clip(point[0], 0, canvas.width - 1))
    row = int(np.clip(point[1], 0, canvas.height - 1)) // 2
    canvas.text(column, row, mark, colour)
