"""visualizeGroundPlane: lines on the ground over the video, and the path ahead."""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import Any, ClassVar, Final, Self

import numpy as np

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.ranges import RANGES
from hub.gcm.vision import CameraState
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.body import largest_radius
from rune_tui.model.cameras import CAMERA_OPTION, MAIN, camera_of, seen_by
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.covered_ground import covered, covers_of, uncovered
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.ground_lines import visible_lines
from rune_tui.model.pose import Pose
from rune_tui.model.robot_ranges import ranges_of
from rune_tui.model.robot_state import Received, RobotState
from rune_tui.model.sightings import Floats
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import Pen, drawing
from rune_tui.visualizers.parts.staleness import Staleness, age_look, draw_age
from rune_tui.visualizers.video.picture_frame import FIT, FIT_OPTION, PictureFrame
from rune_tui.visualizers.video.way_ahead import Course, WayAhead

_SPACING_M: Final = 1.0
_RING_STEP: Final = math.radians(5.0)
_BREAK: Final = np.full((1, 2), np.nan)
_GRID_ALPHA: Final = 110
_PLATE_ALPHA: Final = 235
_DASH, _GAP = 2.0, 3.0
_EDGE: Final = 2.0
"""Thickness of the edges of the path [pixels]."""
_CAMERA_SHAPE: Final = (4, 3)
"""Size of the picture if there is none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Ground:
    """The view of the ground.

    Attributes:
        geometry: The picture and its camera.
        level: The same over level ground, for the horizon; None: not known.
        stands: Whether the robot stands on the ground.
        pose: The robot's pose then; None: not known.
        received: The message with the camera's state.
    """

    geometry: PictureGeometry
    level: PictureGeometry | None
    stands: bool
    pose: Pose | None
    received: Received[Any]

    @classmethod
    def of(cls, robot: RobotState) -> Self | None:
        """The ground of the newest picture; without one, of the camera's state."""
        if robot.picture is not None and all(robot.picture.value.shape):
            height, width = robot.picture.value.shape
            return cls._seen(robot.picture, robot.picture.value.camera, (width, height))
        if robot.camera is not None:
            return cls._seen(robot.camera, robot.camera.value, _CAMERA_SHAPE)
        return None

    @classmethod
    def _seen(
        cls, received: Received[Any], camera: CameraState, size: tuple[int, int]
    ) -> Self | None:
        geometry = PictureGeometry.of(camera, *size)
        if geometry is None:
            return None
        return cls(
            geometry=geometry,
            level=PictureGeometry.of(camera, *size, level=True),
            stands=camera.stands,
            pose=Pose.of(camera),
            received=received,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundPlane:
    """Lines at whole distances from the robot's centre, the horizon, and the path ahead.

    | the robot | the lines lie |
    | --- | --- |
    | stands, also tilted on a ramp | in the plane under its wheels; the horizon is level |
    | flies or dives | on level ground at the depth that it measures, without the path |
    | flies or dives, and does not know its height | nowhere |

    The rest is clear; it covers a camera viewport of the same place, size and fit.

    Attributes:
        spacing: Distance between two lines [m].
        farthest: Distance of the last line [m].
        rings: Whether lines are circles around the robot, not a grid along its axes.
        braking: Guaranteed deceleration of the robot [m/s^2].
        fit: Fit of the picture under it, one of the choices of `FIT_OPTION`.
        camera: The camera of the picture under it, as `CAMERA_OPTION` says.
    """

    spacing: float
    farthest: float
    rings: bool
    braking: float
    fit: str = FIT
    camera: str = MAIN

    rule: ClassVar = VisualizerRule(
        meaning="lines on the ground at known distances, the horizon, and the ground that the "
        "robot will pass over, unless it flies or dives; to lie over a viewport of the camera's "
        "picture of the same place, size and fit",
        message="GCM_CameraState",
        others=("GCM_RobotState", ROBOT_DESCRIPTION.name, RANGES.name),
        option=NumberOption(
            default=0.0,
            least=0.0,
            most=10.0,
            unit="m",
            meaning="from one line to the next; 0 means 1 m",
        ),
        options={
            "fit": FIT_OPTION,
            "camera": CAMERA_OPTION,
            "farthest": NumberOption(
                default=5.0, least=0.5, most=20.0, unit="m", meaning="where the last line is"
            ),
            "lines": ChoiceOption(
                default="grid",
                choices=("grid", "rings"),
                meaning="lines along and across the robot, or circles around it",
            ),
            "braking": NumberOption(
                default=2.0,
                least=0.05,
                most=20.0,
                unit="m/s^2",
                meaning="how hard the robot brakes, for the mark where it would stop",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        farthest = spec.options.number("farthest")
        wanted = spec.option if spec.option > 0.0 else _SPACING_M
        return cls(
            # Limits the number of lines, so that they stay distinct.
            spacing=max(wanted, farthest / 40.0),
            farthest=farthest,
            rings=spec.options.word("lines") == "rings",
            braking=spec.options.number("braking"),
            fit=spec.options.word("fit"),
            camera=spec.options.word("camera"),
        )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the lines as seen by the picture's camera, once there is one."""
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        ground = _Ground.of(robot)
        if ground is None:
            return
        age = ground.received.age(state.now)
        size = int(ground.geometry.width), int(ground.geometry.height)
        frame = PictureFrame.of(
            self.fit, *size, (canvas.width, canvas.height), tall=state.pixel_height
        )
        geometry = frame.shown(ground.geometry)
        course = _course(robot, ground, state)
        way = course.way(reach=self.farthest, braking=self.braking) if course else None
        covers = _covers(robot, state)
        grid = (*state.theme.ink[:3], _GRID_ALPHA)
        stop: list[Floats] | None = None
        with drawing(canvas) as pen:
            _draw_lines(pen, visible_lines(geometry, uncovered(self._lines(), covers)), grid)
            if ground.level is not None:
                _draw_horizon(pen, frame.shown(ground.level), grid)
            if course is not None and way is not None:
                ink = state.theme.faint if course.old else state.theme.accent
                stop = _draw_way(pen, geometry, way, covers, ink, state.theme.warning)
        _clear_beside(canvas, frame)
        self._write_distances(canvas, geometry, covers, state.theme)
        # A part behind an obstacle is hidden, but inside the picture.
        if course is not None and way is not None and not (stop is None and covers):
            _write_way(canvas, course, way.stop_distance, stop, state.theme)
        draw_age(canvas, age, state.theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the camera's state, the path ahead, and the drawing of their ages."""
        robot = seen_by(robot, camera_of(self.camera, robot, state))
        ground = _Ground.of(robot)
        if ground is None:
            return state.theme.name
        look = age_look(ground.received, state.now)
        course = _course(robot, ground, state)
        covers = _covers(robot, state)
        return ground.geometry, ground.level, look, course, covers, state.theme.name

    def _distances(self) -> Floats:
        count = math.floor(self.farthest / self.spacing + 1e-9)
        return np.linspace(self.spacing, count * self.spacing, count)

    def _lines(self) -> Floats:
        """Corners of all lines in the robot's frame [m], with a row of NaN between lines."""
        lines: list[Floats] = []
        if self.rings:
            around = np.arange(0.0, 2.0 * math.pi + _RING_STEP, _RING_STEP)
            circle = np.stack((np.cos(around), np.sin(around)), axis=1)
            for distance in self._distances():
                lines += [circle * distance, _BREAK]
            return np.concatenate(lines)
        distances = self._distances()
        end = distances[-1] if len(distances) else 0.0
        for distance in np.concatenate((-distances, (0.0,), distances)):
            across = np.array(((distance, -end), (distance, end)))
            lines += [across, _BREAK, across[:, ::-1], _BREAK]
        return np.concatenate(lines)

    def _write_distances(
        self, canvas: Canvas, geometry: PictureGeometry, covers: tuple[float, ...], theme: Theme
    ) -> None:
        """Write each line's distance at the left edge of the picture."""
        left = max(0.0, geometry.left) + 1.0
        top, bottom = max(0.0, geometry.top), min(canvas.height, geometry.top + geometry.height)
        rows = np.arange(top, bottom) + 0.5
        seen = geometry.ground(np.stack((np.full_like(rows, left), rows), axis=1))
        measured, word = self._measured(seen.points, geometry)
        hidden = covered(seen.points, covers)
        taken = -1
        for distance in self._distances():
            over = np.flatnonzero(measured >= distance)
            if not len(over) or over[-1] + 1 >= len(rows):
                continue
            row = int(rows[over[-1]]) // 2
            if row == taken or row >= canvas.rows or hidden[over[-1]]:
                continue
            taken = row
            _write(canvas, int(left), row, f"{distance:g} m{word}", theme.ink, theme)

    def _measured(self, points: Floats, geometry: PictureGeometry) -> tuple[Floats, str]:
        """The distance of points by the lines' measure, and the word for their direction."""
        if self.rings:
            return np.hypot(points[:, 0], points[:, 1]), ""
        cos, sin = math.cos(geometry.pan), math.sin(geometry.pan)
        # Those lines count that cross the picture.
        if abs(cos) >= abs(sin):
            return math.copysign(1.0, cos) * points[:, 0], "" if cos > 0.0 else " behind"
        return math.copysign(1.0, sin) * points[:, 1], " left" if sin > 0.0 else " right"


def _covers(robot: RobotState, state: ConsoleState) -> tuple[float, ...]:
    """The distance of the visible ground in each direction."""
    measured = robot.newest(RANGES)
    if measured is None or age_look(measured, state.now)[0] is Staleness.STALE:
        return ()
    return covers_of(ranges_of(robot))


def _course(robot: RobotState, ground: _Ground, state: ConsoleState) -> Course | None:
    """The robot's command, in its frame at the time of the picture.

    None for a robot that flies or dives: it does not pass over the ground that would be marked.
    """
    if robot.navigation is None or not ground.stands:
        return None
    step, _ = age_look(robot.navigation, state.now)
    if step is Staleness.STALE:
        return None
    return Course.of(
        robot.navigation.value,
        radius=largest_radius(robot.body),
        then=ground.pose,
        old=step is Staleness.OLD,
    )


def _draw_lines(pen: Pen, pieces: list[Floats], colour: Colour, width: float = 1.0) -> None:
    for piece in pieces:
        pen.line(list(map(tuple, piece.tolist())), colour, width)


def _draw_horizon(pen: Pen, geometry: PictureGeometry, colour: Colour) -> None:
    if (ends := geometry.horizon_line) is not None:
        first, last = sorted(ends)
        pen.dashes([first, last], colour, dash=_DASH, gap=_GAP)


def _draw_way(
    pen: Pen,
    geometry: PictureGeometry,
    way: WayAhead,
    covers: tuple[float, ...],
    ink: Colour,
    stop_ink: Colour,
) -> list[Floats] | None:
    """Draw the visible part of the path.

    Returns:
        The visible part of its end for a stop now; None: nothing of the path is visible.
    """
    edges = visible_lines(geometry, uncovered(way.edges, covers))
    _draw_lines(pen, edges, ink, _EDGE)
    _draw_lines(pen, visible_lines(geometry, uncovered(way.arrows, covers)), ink)
    stop = visible_lines(geometry, way.stop)
    _draw_lines(pen, stop, stop_ink)
    return stop if edges else None


def _clear_beside(canvas: Canvas, frame: PictureFrame) -> None:
    """Remove the parts of thick lines beside the picture."""
    canvas.pixels[: max(0, frame.top)] = 0
    canvas.pixels[max(0, frame.top + frame.height) :] = 0
    canvas.pixels[:, : max(0, frame.left)] = 0
    canvas.pixels[:, max(0, frame.left + frame.width) :] = 0


def _write_way(
    canvas: Canvas, course: Course, distance: float, stop: list[Floats] | None, theme: Theme
) -> None:
    """Write the stopping distance [m], or that the robot turns or leaves the picture."""
    if stop is None:
        _write_low(canvas, course.words, theme.accent, theme)
    elif stop:
        middle = np.nan_to_num((stop[0][0] + stop[0][-1]) / 2.0)
        x, y = np.clip(middle, 0.0, (canvas.width, 2.0 * canvas.rows)).tolist()
        words = f"stop {distance:.1f} m"
        column = max(0, min(canvas.width, int(x + len(words) / 2)) - len(words))
        _write(canvas, column, min(canvas.rows - 1, int(y) // 2), words, theme.warning, theme)
    else:
        _write_low(canvas, f"stops in {distance:.1f} m", theme.warning, theme)


def _write_low(canvas: Canvas, string: str, ink: Colour, theme: Theme) -> None:
    """Words above the last row, where layouts often have a status line."""
    column, row = max(0, (canvas.width - len(string)) // 2), max(0, canvas.rows - 2)
    _write(canvas, column, row, string, ink, theme)


def _write(canvas: Canvas, column: int, row: int, string: str, ink: Colour, theme: Theme) -> None:
    under = canvas.pixels[2 * row : 2 * row + 2, max(0, column) : column + len(string)]
    under[...] = (*theme.panel[:3], _PLATE_ALPHA)
    canvas.text(column, row, string, ink)
