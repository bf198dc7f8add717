"""visualizePanData, visualizeTiltData: the camera's direction, as a bar of its field of view."""

from __future__ import annotations

import enum
import math
from abc import ABC, abstractmethod
from collections.abc import Hashable
from typing import ClassVar, Self

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.vision import CameraState
from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.cameras import CAMERA_OPTION, MAIN, camera_of, seen_by
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.staleness import age_look, draw_age


class Direction(enum.Enum):
    """The direction of the bar: positive angles are left or up."""

    ACROSS = "across"
    UPWARD = "upward"


class AngleBar(ABC):
    """Draws one angle of the camera; clear without one."""

    whole_cells: ClassVar[bool] = False
    urgency: ClassVar[Urgency] = Urgency.DRIVE
    direction: ClassVar[Direction]

    def __init__(self, camera: str = MAIN) -> None:
        self.camera = camera

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(spec.options.word("camera"))

    @staticmethod
    @abstractmethod
    def reading(camera: CameraState) -> tuple[float, float, float]:
        """Angle, field of view in its direction, and largest angle [rad]."""

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the newest angle."""
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        if robot.camera is None:
            canvas.fill(state.theme.panel)
            return
        angle, field_of_view, limit = self.reading(robot.camera.value)
        draw_angle_bar(
            canvas,
            self.direction,
            angle=angle,
            field_of_view=field_of_view,
            limit=limit,
            age=robot.camera.age(state.now),
            theme=state.theme,
        )

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the angle, the field of view and the fading of their age."""
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        if robot.camera is None:
            return state.theme.name
        look = age_look(robot.camera, state.now)
        return self.reading(robot.camera.value), look, state.theme.name


class PanData(AngleBar):
    """A bar centred on the pan, as long as the field of view, against a centre line."""

    rule: ClassVar = VisualizerRule(
        meaning="where the camera looks from left to right, as a bar as wide as its field of view",
        message="GCM_CameraState",
        others=(ROBOT_DESCRIPTION.name,),
        options={"camera": CAMERA_OPTION},
    )
    direction = Direction.ACROSS

    @staticmethod
    def reading(camera: CameraState) -> tuple[float, float, float]:
        """Pan, field of view and largest pan [rad]."""
        return camera.pan, camera.horizontal_fov, camera.pan_limit


class TiltData(AngleBar):
    """A bar centred on the tilt, as long as the field of view, against a centre line."""

    rule: ClassVar = VisualizerRule(
        meaning="the same, up and down",
        message="GCM_CameraState",
        others=(ROBOT_DESCRIPTION.name,),
        options={"camera": CAMERA_OPTION},
    )
    direction = Direction.UPWARD

    @staticmethod
    def reading(camera: CameraState) -> tuple[float, float, float]:
        """Tilt, field of view and largest tilt [rad]."""
        return camera.tilt, camera.vertical_fov, camera.tilt_limit


def draw_angle_bar(
    canvas: Canvas,
    direction: Direction,
    *,
    angle: float,
    field_of_view: float,
    limit: float,
    age: float,
    theme: Theme,
) -> None:
    """Draw the camera's field of view within its whole range.

    Args:
        canvas: Its whole length stands for -(limit + field_of_view / 2) to the positive same.
        direction: Direction of the bar.
        angle: Pan or tilt [rad], positive left or up.
        field_of_view: In that direction, after zoom [rad].
        limit: Largest pan or tilt [rad].
        age: Age of the angle [s].
        theme: The colours.
    """
    canvas.fill(theme.track)
    across = direction is Direction.ACROSS
    length = canvas.width if across else canvas.height
    whole = 2.0 * limit + field_of_view
    if not (math.isfinite(angle) and math.isfinite(whole) and whole > 0.0):
        return
    low, high = bar_span(length, angle / whole, field_of_view / whole)
    middle = (length - 1) // 2, length // 2 + 1
    with drawing(canvas) as pen:
        for (start, end), colour in (((low, high), theme.accent), (middle, theme.ink)):
            if across:
                pen.rectangle(start, 0, end, canvas.height, colour)
            else:
                pen.rectangle(0, start, canvas.width, end, colour)
    draw_age(canvas, age, theme)


def bar_span(length: int, offset: float, share: float) -> tuple[int, int]:
    """First and one past last pixel of the bar, counted from the left or the top.

    Args:
        length: Whole length [pixels].
        offset: Angle as a share of the whole, positive left or up, -0.5 to 0.5.
        share: Field of view as a share of the whole.
    """
    size = max(1, round(min(1.0, share) * length))
    start = round((0.5 - max(-0.5, min(0.5, offset))) * length - size / 2.0)
    start = max(0, min(length - size, start))
    return start, start + size
