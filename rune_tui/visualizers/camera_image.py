"""visualizeCameraImage: the newest camera picture, or in words why there is none."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar, Self

from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.resize import fitted, fitted_size
from rune_tui.visualizers.notice import link_trouble, write_notice
from rune_tui.visualizers.staleness import age_look, mark_age, weather


@dataclass(frozen=True, slots=True)
class CameraImage:
    """Shows the picture as large as the viewport allows, its aspect kept, black around it."""

    rule: ClassVar = VisualizerRule(meaning="the camera's picture", message="GCM_Common_Image")
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:  # noqa: ARG003 it has no options
        """The visualizer that a layout asks for."""
        return cls()

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the picture, its age and the link's trouble."""
        trouble = _explanation(robot, state.now)
        if robot.picture is None or not robot.picture.value.pixels.size:
            canvas.fill(state.theme.panel)
        else:
            canvas.fill(state.theme.ground)
            age = robot.picture.age(state.now)
            canvas.paste(*fitted(robot.picture.value.pixels, canvas.width, canvas.height))
            weather(canvas, age)
            mark_age(canvas, age, state.theme)
        if trouble:
            write_notice(canvas, trouble, state.theme)

    def in_picture(
        self, pixel: tuple[float, float], size: tuple[int, int], robot: RobotState
    ) -> tuple[float, float] | None:
        """Where in the camera's picture a pixel of the viewport is; None beside the picture."""
        if robot.picture is None or not robot.picture.value.pixels.size:
            return None
        height, width = robot.picture.value.pixels.shape[:2]
        wide, high = fitted_size(width, height, *size)
        across = (pixel[0] - (size[0] - wide) // 2) / wide
        down = (pixel[1] - (size[1] - high) // 2) / high
        return (across, down) if 0.0 <= across <= 1.0 and 0.0 <= down <= 1.0 else None

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the picture, the look of its age, and the words."""
        words = _explanation(robot, state.now)
        if robot.picture is None:
            return words, state.theme.name
        look = age_look(robot.picture, state.now)
        return robot.picture.number, look, words, state.theme.name


def _explanation(robot: RobotState, now: float) -> str:
    trouble = link_trouble(robot, now)
    if not trouble and robot.picture is None:
        trouble = f"waiting for the first picture from {robot.name}"
    return f"{trouble}; {robot.link.detail}" if trouble and robot.link.detail else trouble
