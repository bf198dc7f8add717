"""visualizeNightMode: the state of night mode, as an icon and in words."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from typing import ClassVar, Final, Self

from hub.values import dataclass
from rune_tui.layout.rules import NIGHT_MODE_MESSAGE, ChoiceOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import Point, drawing, toward
from rune_tui.visualizers.parts.staleness import age_look, draw_age

_SEEN_GAIN: Final = 1.05
"""Least gain that is reported; a smaller one is not visible."""
_LARGEST_ICON: Final = 16
_LEAST_ICON: Final = 6
_SMOOTHING: Final = 4
_RAYS: Final = 8
_MOON, _SUN = "☾", "☼"


@dataclass(frozen=True, slots=True, kw_only=True)
class NightMode:
    """A moon and the word NIGHT in night mode, else a sun and the word day, or nothing.

    Attributes:
        by_day: Whether it shows anything by day.
    """

    by_day: bool = True

    rule: ClassVar = VisualizerRule(
        meaning="a moon and a word while night mode is on, how much pictures are brightened, and "
        "the headlight",
        message=NIGHT_MODE_MESSAGE,
        others=("GCM_CameraState",),
        options={
            "day": ChoiceOption(
                default="shown", choices=("shown", "hidden"), meaning="what it shows by day"
            )
        },
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(by_day=spec.options.word("day") == "shown")

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the icon, and the words that fit beside it."""
        words = _words(robot, state)
        night = _is_night(robot, state)
        if not night and not self.by_day:
            return
        theme = state.theme
        canvas.fill(theme.panel)
        ink = theme.warning if night else theme.faint
        size = min(canvas.height, _LARGEST_ICON, canvas.width)
        if size >= _LEAST_ICON:
            _draw_icon(canvas, size, theme, night=night)
        else:
            size = 1
            canvas.text(0, (canvas.rows - 1) // 2, _MOON if night else _SUN, ink)
        shown = words[0]
        for word in words[1:]:
            if size + 1 + len(shown) + 1 + len(word) <= canvas.width:
                shown += f" {word}"
        canvas.text(size + 1, (canvas.rows - 1) // 2, shown, ink)
        if robot.camera is not None:
            draw_age(canvas, robot.camera.age(state.now), theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the words and the drawing of their age."""
        night = _is_night(robot, state)
        if not night and not self.by_day:
            return night
        look = robot.camera and age_look(robot.camera, state.now)
        return night, _words(robot, state), look, state.theme.name


def _is_night(robot: RobotState, state: ConsoleState) -> bool:
    """Whether this console requests it, or the camera does it."""
    return robot.name in state.night or any(_effects(robot))


def _words(robot: RobotState, state: ConsoleState) -> tuple[str, ...]:
    """The words, the most important first."""
    first = "NIGHT" if _is_night(robot, state) else "day"
    if robot.camera is None:
        return first, "camera not heard"
    effects = tuple(_effects(robot))
    elsewhere = effects and robot.name not in state.night
    return first, *effects, *(("set elsewhere",) if elsewhere else ())


def _effects(robot: RobotState) -> Iterator[str]:
    """The state of the camera's night mode."""
    if robot.camera is None:
        return
    camera = robot.camera.value
    if camera.gain >= _SEEN_GAIN and math.isfinite(camera.gain):
        yield f"x{camera.gain:.1f}"
    if camera.headlight > 0.0:
        yield f"light {min(1.0, camera.headlight):.0%}"


def _draw_icon(canvas: Canvas, size: int, theme: Theme, *, night: bool) -> None:
    radius = size / 2.0 - 1.0
    centre: Point = (size / 2.0, canvas.height / 2.0)
    with drawing(canvas, smoothing=_SMOOTHING) as pen:
        if night:
            pen.circle(centre, radius, fill=theme.warning)
            dark = centre[0] + radius / 2.0, centre[1] - radius / 3.0
            pen.circle(dark, radius * 0.8, fill=theme.panel)
            return
        pen.circle(centre, radius / 2.0, fill=theme.faint)
        for ray in range(_RAYS):
            direction = ray * 2.0 * math.pi / _RAYS
            ends = [toward(centre, radius * share, direction) for share in (0.7, 1.0)]
            pen.line(ends, theme.faint, 0.75)
