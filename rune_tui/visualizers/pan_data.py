"""visualizePanData: where the camera looks, left to the left."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar, Self

from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.angle_bar import Direction, draw_angle_bar
from rune_tui.visualizers.palette import PANEL
from rune_tui.visualizers.staleness import age_look


@dataclass(frozen=True, slots=True)
class PanData:
    """A bar centred on the pan, as long as the field of view, against a centre line."""

    whole_cells: ClassVar[bool] = False

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:  # noqa: ARG003 it has no options
        """The visualizer that a layout asks for."""
        return cls()

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the newest pan; an empty bar until there is one."""
        if robot.camera is None:
            canvas.fill(PANEL)
            return
        camera = robot.camera.value
        draw_angle_bar(
            canvas,
            Direction.ACROSS,
            angle=camera.pan,
            field_of_view=camera.horizontal_fov,
            limit=camera.pan_limit,
            age=robot.camera.age(state.now),
        )

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the pan, the field of view and the look of their age."""
        if robot.camera is None:
            return None
        camera = robot.camera.value
        look = age_look(robot.camera, state.now)
        return camera.pan, camera.horizontal_fov, camera.pan_limit, look
