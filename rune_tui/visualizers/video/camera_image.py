"""visualizeCameraImage: the newest picture, or the reason for none in words."""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable
from typing import ClassVar, Final, Self

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.ranges import RANGES
from hub.gcm.vision import CameraState
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.cameras import (
    CAMERA_OPTION,
    MAIN,
    camera_of,
    camera_title,
    seen_by,
    unknown_camera,
)
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.line_of_sight import Surroundings, place_of_pixel, unsure
from rune_tui.model.pose import Pose
from rune_tui.model.robot_ranges import ranges_of
from rune_tui.model.robot_state import Picture, RobotState
from rune_tui.model.theme import Theme
from rune_tui.model.world import WorldPoint
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.resize import covering_size, fitted_size
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import link_trouble, write_notice
from rune_tui.visualizers.parts.staleness import age_look, fade_by_age, mark_age
from rune_tui.visualizers.video.picture_frame import FIT, FIT_OPTION, PictureFrame
from rune_tui.visualizers.video.picture_marks import draw_marks, marks_source

_ASIDE_DEG: Final = 5.0
_SAME_MOMENT_S: Final = 0.5
_SAME_PLACE_M: Final = 0.05
_SAME_HEADING: Final = math.radians(2.0)
"""Ranges belong to a picture within these differences of time, place and heading."""
_CROSS: Final = (2, 4, 6)
"""Distances from the middle of the crosshair at which its colours begin and end [pixels]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraImage:
    """Shows the picture; its pixels give places on the ground.

    Attributes:
        fit: Its fit into the viewport, one of the choices of `FIT_OPTION`.
        crosshair: Whether to mark its middle, and to write the camera's direction if it is not
            ahead.
        aside_deg: Least angle for these words.
        camera: The camera, as `CAMERA_OPTION` says.
        interval_s: Shortest time between two pictures [s]; 0: that of the layout's `VIS_VID`.
    """

    fit: str = FIT
    crosshair: bool = False
    aside_deg: float = _ASIDE_DEG
    camera: str = MAIN
    interval_s: float = 0.0

    rule: ClassVar = VisualizerRule(
        pictures=True,
        locates=True,
        draws_over=True,
        meaning="the camera's picture",
        message="GCM_Common_Image",
        others=(ROBOT_DESCRIPTION.name,),
        option=NumberOption(
            default=0.0,
            least=0.0,
            most=180.0,
            unit="deg",
            meaning="how far aside the camera looks before the crosshair's words say so; 0 means 5",
        ),
        options={
            "fit": FIT_OPTION,
            "camera": CAMERA_OPTION,
            "crosshair": ChoiceOption(
                default="off",
                choices=("off", "on"),
                meaning="marks the picture's middle, and says in words when the camera looks aside",
            ),
            "interval_ms": NumberOption(
                default=0.0,
                least=0.0,
                most=1000.0,
                unit="ms",
                meaning="shortest time between two pictures; 0: that of the capability VIS_VID, "
                "which is the least; of several viewports of a camera, the shortest counts",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True
    urgency: ClassVar[Urgency] = Urgency.VIDEO

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(
            fit=spec.options.word("fit"),
            crosshair=spec.options.word("crosshair") == "on",
            aside_deg=spec.option if spec.option > 0.0 else _ASIDE_DEG,
            camera=spec.options.word("camera"),
            interval_s=spec.options.number("interval_ms") / 1000.0,
        )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the picture, its camera's name, its age and the link's trouble."""
        camera = camera_of(self.camera, robot, state)
        robot = seen_by(robot, camera)
        trouble = _explanation(robot, camera, state.now)
        if robot.picture is None or not robot.picture.value.pixels.size:
            canvas.fill(state.theme.panel)
        else:
            canvas.fill(state.theme.ground)
            picture = robot.picture.value
            age = robot.picture.age(state.now)
            frame = self._frame(picture, (canvas.width, canvas.height), state)
            size, brightness = (frame.width, frame.height), state.theme.picture
            canvas.place_picture(picture.pixels, frame.left, frame.top, size, brightness=brightness)
            fade_by_age(canvas, age)
            self._draw_marks(canvas, robot, picture, state)
            if self.crosshair:
                _mark_middle(canvas, frame, state.theme)
                self._write_direction(canvas, picture.camera, state.theme)
            _write_name(canvas, camera_title(camera, robot), state.theme)
            mark_age(canvas, age, state.theme)
        if trouble:
            write_notice(canvas, trouble, state.theme)

    def draw_over(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the marks and the ghost again: the operator must see a mark to confirm it."""
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        if robot.picture is not None and robot.picture.value.pixels.size:
            self._draw_marks(canvas, robot, robot.picture.value, state)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the picture, the drawing of its age, and the words."""
        camera = camera_of(self.camera, robot, state)
        robot = seen_by(robot, camera)
        words = _explanation(robot, camera, state.now), camera_title(camera, robot)
        if robot.picture is None:
            return words, state.theme.name
        look = age_look(robot.picture, state.now)
        return robot.picture.number, look, words, marks_source(robot, state), state.theme.name

    def picture_size(self, width: int, height: int) -> tuple[int, int]:
        """Width and height of the 4:3 picture that a viewport of this size can show [pixels]."""
        return (fitted_size if self.fit == FIT else covering_size)(4, 3, width, height)

    def in_picture(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> tuple[float, float] | None:
        """Place in the camera's picture of a viewport's pixel; None beside the picture."""
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        if robot.picture is None or not robot.picture.value.pixels.size:
            return None
        return self._frame(robot.picture.value, size, state).shares(pixel)

    def locate(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> WorldPoint | None:
        """The place that a pixel shows, by `line_of_sight`; None: not known.

        Also None beside the picture, and if the robot's pose is not known.
        """
        inside = self.in_picture(pixel, size, robot, state) is not None
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        if robot.picture is None or not inside:
            return None
        picture = robot.picture.value
        rows, columns = picture.pixels.shape[:2]
        pose, whole = Pose.of(picture.camera), PictureGeometry.of(picture.camera, columns, rows)
        if pose is None or whole is None:
            return None
        frame = self._frame(picture, size, state)
        # An enlarged picture has no more details than its own pixels.
        coarse = max(1.0, frame.width / columns, frame.height / rows)
        around = _surroundings(robot, pose)
        place = place_of_pixel(frame.shown(whole), pixel, coarse, around)
        level = PictureGeometry.of(picture.camera, columns, rows, level=True)
        if place is None or level is None or level == whole:
            return place
        return unsure(place, place_of_pixel(frame.shown(level), pixel, coarse, around))

    def _draw_marks(
        self, canvas: Canvas, robot: RobotState, picture: Picture, state: ConsoleState
    ) -> None:
        rows, columns = picture.pixels.shape[:2]
        pose, whole = Pose.of(picture.camera), PictureGeometry.of(picture.camera, columns, rows)
        if pose is not None and whole is not None:
            frame = self._frame(picture, (canvas.width, canvas.height), state)
            draw_marks(canvas, frame.shown(whole), pose, robot, state)

    def _frame(self, picture: Picture, size: tuple[int, int], state: ConsoleState) -> PictureFrame:
        height, width = picture.pixels.shape[:2]
        return PictureFrame.of(self.fit, width, height, size, tall=state.pixel_height)

    def _write_direction(self, canvas: Canvas, camera: CameraState, theme: Theme) -> None:
        words = aside_words(camera.pan, self.aside_deg)
        if not words:
            return
        shown = words if len(words) <= canvas.width else words.removeprefix("camera is ")
        # On the second row: the first one may have the picture's age.
        row = min(1, canvas.rows - 1)
        column = max(0, (canvas.width - len(shown)) // 2)
        with drawing(canvas) as pen:
            pen.rectangle(column, 2 * row, column + len(shown), 2 * row + 2, theme.panel)
        canvas.text(column, row, shown, theme.warning)


def _surroundings(robot: RobotState, pose: Pose) -> Surroundings:
    """The surroundings of the newest picture."""
    navigation, measured, near = robot.navigation, robot.newest(RANGES), False
    if navigation is not None and measured is not None and robot.picture is not None:
        value, then = navigation.value, robot.picture.measured
        near = (
            max(abs(each.measured - then) for each in (navigation, measured)) < _SAME_MOMENT_S
            and math.hypot(value.x - pose.x, value.y - pose.y) < _SAME_PLACE_M
            and math.isfinite(value.theta)
            and abs(math.remainder(value.theta - pose.theta, math.tau)) < _SAME_HEADING
        )
    off = (navigation.value.position_off, navigation.value.heading_off) if navigation else (0, 0)
    return Surroundings(
        pose=pose,
        grid=robot.map.value if robot.map is not None else None,
        ranges=ranges_of(robot) if near else None,
        position_off=off[0] if math.isfinite(off[0]) else 0.0,
        heading_off=off[1] if math.isfinite(off[1]) else 0.0,
    )


def aside_words(pan: float, least_deg: float) -> str:
    """The direction of a camera turned by at least this angle [rad]; empty: by less."""
    if not math.isfinite(pan) or abs(math.degrees(pan)) < least_deg:
        return ""
    return f"camera is {abs(math.degrees(pan)):.0f}° {'left' if pan > 0.0 else 'right'}"


def _mark_middle(canvas: Canvas, frame: PictureFrame, theme: Theme) -> None:
    x, y = frame.left + frame.width // 2, frame.top + frame.height // 2
    inks = (theme.ink, theme.ground)
    with drawing(canvas) as pen:
        # Two colours, visible on dark and on bright pictures.
        for (near, far), colour in zip(itertools.pairwise(_CROSS), inks, strict=True):
            for first, end in ((near, far), (1 - far, 1 - near)):
                pen.rectangle(x + first, y, x + end, y + 1, colour)
                pen.rectangle(x, y + first, x + 1, y + end, colour)


def _write_name(canvas: Canvas, name: str, theme: Theme) -> None:
    """The camera's name in the upper left corner."""
    if not name:
        return
    shown = f" {name} "[: canvas.width]
    with drawing(canvas) as pen:
        pen.rectangle(0, 0, len(shown), 2, theme.panel)
    canvas.text(0, 0, shown, theme.ink)


def _explanation(robot: RobotState, camera: str, now: float) -> str:
    """Why there is no picture; the banner reports a lost link."""
    if robot.picture is not None:
        return ""
    trouble = link_trouble(robot, now)
    if not trouble and (unknown := unknown_camera(camera, robot)):
        return unknown
    if not trouble:
        source = f"camera {camera} of {robot.title}" if camera else robot.title
        trouble = f"waiting for the first picture from {source}"
    return f"{trouble}; {robot.link.detail}" if trouble and robot.link.detail else trouble
