"""visualizeMapData: the map, the robot on it, and the marks."""

from __future__ import annotations

import copy
import math
from collections.abc import Hashable
from typing import ClassVar, Final, Self

import numpy as np

from hub.gcm.capability import Capability
from hub.gcm.edges import EDGES
from hub.gcm.mapping import INTEREST_POINTS, InterestPoint
from hub.gcm.navigation import NAVIGATION_STATUS, Task
from hub.gcm.occupancy_map import OccupancyMap
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.edges import edges_of
from rune_tui.model.map_window import MapWindow
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import RobotState
from rune_tui.model.robot_task import navigation_task
from rune_tui.model.sightings import Floats
from rune_tui.model.theme import Theme
from rune_tui.model.topics import topics_of
from rune_tui.model.view_cones import view_cones
from rune_tui.model.world import WorldPoint
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.grid_picture import UNKNOWN, grid_colours, grid_values
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.maps import map_marks
from rune_tui.visualizers.maps.edge_marks import draw_edges, write_edge
from rune_tui.visualizers.parts.notice import link_trouble, write_notice
from rune_tui.visualizers.parts.severity import Severity
from rune_tui.visualizers.parts.staleness import age_look, age_text, fade_by_age, mark_age
from rune_tui.visualizers.parts.task_words import goal_word
from rune_tui.visualizers.parts.trail import Trail

OLD_MAP_S: Final = 30.0
"""Age from which words report it [s]; maps come every ten seconds."""

_ACROSS_M: Final = 10.0
_MARGIN: Final = 1.08
"""Size of the whole map, relative to its known part."""
_SLOW_M_S: Final = 0.1
"""Mean speed of a robot whose whole trail a replay shows soon [m/s]."""
_FINEST_M: Final = 1e-3
"""No pixel shows less of the world [m]."""
_NORTH: Final = math.pi / 2.0
_CONTRAST: Final = np.clip((np.arange(101) - 30) * 100 // 35, 0, 100)
"""Cells count as surely free up to 30 and as surely occupied from 65 on, as in ROS's maps."""
_DOTTED: Final = 0.3
"""Contrast of the dots of unknown ground, as a share of that of faint ink."""
_GRAIN: Final = 320.0
"""Smaller steps of the robot are not visible, as a share of the shown width."""
_TURN_GRAIN: Final = {True: math.radians(0.5), False: math.radians(2.0)}
"""Turns too small to see, on a map that turns with the robot and on one that does not [rad]."""


class MapData:
    """Draws a robot's map with its trail."""

    rule: ClassVar = VisualizerRule(
        locates=True,
        meaning="the map: walls, free floor, the unknown dotted; the robot and its heading, where "
        "it has been and where it wants to go, what its cameras see, victims (V) and landmarks "
        "(L), and dots with the word EDGE where the ground ends",
        message="GCM_Common_Map",
        others=(
            "GCM_RobotState",
            "GCM_CameraState",
            INTEREST_POINTS.name,
            NAVIGATION_STATUS.name,
            EDGES.name,
        ),
        option=NumberOption(
            default=0.0,
            least=0.0,
            most=1000.0,
            unit="m",
            meaning="how much of the world is shown from left to right; 0 means 10 m",
        ),
        options={
            "show": ChoiceOption(
                default="robot",
                choices=("robot", "whole"),
                meaning="what is around the robot, or all that is known",
            ),
            "up": ChoiceOption(
                default="north", choices=("north", "robot"), meaning="what is up in it"
            ),
            "trail": NumberOption(
                default=50.0,
                least=0.0,
                most=500.0,
                unit="m",
                meaning="how much of the way behind the robot is shown",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True

    def __init__(
        self, *, viewport: str, across: float, whole: bool, turns: bool, trail: float
    ) -> None:
        """Start without a map.

        Args:
            viewport: Its viewport.
            across: The width that it shows [m].
            whole: Whether it shows the whole map, not the surroundings of the robot.
            turns: Whether the robot's heading is up, not north.
            trail: Length of the trail behind the robot [m].
        """
        self._viewport = viewport
        self._across = across
        self._whole = whole
        self._turns = turns
        self._trail = Trail(trail)
        self.memory_s = trail / _SLOW_M_S
        self._known: tuple[OccupancyMap | None, Floats] = None, np.empty((0, 2))

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(
            viewport=spec.viewport,
            across=spec.option if spec.option > 0.0 else _ACROSS_M,
            whole=spec.options.word("show") == "whole",
            turns=spec.options.word("up") == "robot",
            trail=spec.options.number("trail"),
        )

    def __copy__(self) -> Self:
        """A visualizer with the same trails, which grow by themselves."""
        twin = object.__new__(type(self))
        vars(twin).update(vars(self), _trail=copy.copy(self._trail))
        return twin

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the map, or the reason in words why there is none."""
        theme = state.theme
        window = self._window(robot, state, (canvas.width, canvas.height))
        if window is None:
            canvas.fill(theme.panel)
        else:
            self._draw_world(canvas, window, robot, state)
            age = 0.0 if robot.navigation is None else robot.navigation.age(state.now)
            fade_by_age(canvas, age)
            _write_remark(canvas, _remark(robot, state.now), theme)
            mark_age(canvas, age, theme)
        explanation = _explanation(robot, state.now)
        if explanation:
            write_notice(canvas, explanation, theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the map, visible motions, and words; extends the robot's trail.

        The trail grows only by visible motions.
        """
        pose = self._follow(robot)
        step = self._across / self._zoom(state) / _GRAIN
        turn = _TURN_GRAIN[self._turns]
        return (
            robot.name,
            robot.map and robot.map.number,
            pose and (round(pose.x / step), round(pose.y / step), round(pose.theta / turn)),
            tuple(cone.seen_at(turn, step) for cone in view_cones(robot, state)),
            tuple((point.number, point.kind, point.x, point.y) for point in _points(robot)),
            _route(robot).tobytes(),
            edges_of(robot, state.now).tobytes(),
            _goal(robot, state.now),
            state.ghosts.get(robot.name),
            robot.navigation and age_look(robot.navigation, state.now),
            (_remark(robot, state.now), _explanation(robot, state.now)),
            self._zoom(state),
            state.theme.name,
        )

    def locate(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> WorldPoint | None:
        """The place of a pixel; None: no map is shown."""
        window = self._window(robot, state, size)
        if window is None:
            return None
        x, y = window.points(pixel).tolist()
        cell = robot.map.value.resolution if robot.map is not None else 0.0
        # A map shows no distance from the robot; the error is half the diagonal of a pixel.
        uncertainty = max(window.metres_per_pixel, cell) / math.sqrt(2.0)
        return WorldPoint(x=x, y=y, uncertainty=uncertainty)

    def _draw_world(
        self, canvas: Canvas, window: MapWindow, robot: RobotState, state: ConsoleState
    ) -> None:
        theme = state.theme
        _draw_grid(canvas, window, robot, theme)
        pose, route = self._follow(robot), _route(robot)
        edges = [(x, y) for x, y in window.pixels(edges_of(robot, state.now)).tolist()]
        cones = [] if pose is None else [(pose, cone) for cone in view_cones(robot, state)]
        for where, cone in cones:
            map_marks.draw_cone(canvas, window, where, cone, theme)
        with drawing(canvas) as pen:
            map_marks.draw_trail(pen, window, self._trail.points(robot.name), theme)
            map_marks.draw_route(pen, window, route, theme)
            draw_edges(pen, edges, theme)
        if pose is not None:
            map_marks.draw_robot(canvas, window, pose, robot.body, theme)
        if (ghost := state.ghosts.get(robot.name)) is not None:
            map_marks.write_ghost(canvas, window, ghost, theme)
        map_marks.write_goal(canvas, window, *_goal(robot, state.now), theme)
        if pose is not None:
            x, y = window.pixels((pose.x, pose.y)).tolist()
            write_edge(canvas, edges, (x, y), theme)
        map_marks.write_points(canvas, window, _points(robot), theme)
        map_marks.write_north(canvas, window, theme)
        map_marks.write_scale(canvas, window, theme)

    def _follow(self, robot: RobotState) -> Pose | None:
        """The robot's pose, which extends the trail."""
        pose = _pose(robot)
        if pose is not None:
            self._trail.follow(robot.name, pose)
        return pose

    def _zoom(self, state: ConsoleState) -> float:
        return state.zooms.get(self._viewport, 1.0)

    def _window(
        self, robot: RobotState, state: ConsoleState, size: tuple[int, int]
    ) -> MapWindow | None:
        """The shown part; None: no map."""
        pose = _pose(robot)
        up = pose.theta if self._turns and pose is not None else _NORTH
        known = self._corners(robot)
        scale = max(_FINEST_M, self._across / self._zoom(state) / size[0])
        if len(known) and self._whole:
            return _around(known, size, up, self._zoom(state))
        if pose is None and not len(known):
            return None
        x, y = (pose.x, pose.y) if pose is not None else known.mean(axis=0).tolist()
        if not self._turns:
            # In steps of whole pixels, so that walls do not flicker.
            x, y = round(x / scale) * scale, round(y / scale) * scale
        return MapWindow(x=x, y=y, metres_per_pixel=scale, width=size[0], height=size[1], up=up)

    def _corners(self, robot: RobotState) -> Floats:
        """Corners of the rectangle around all known cells [m], shape (4, 2) or (0, 2)."""
        if robot.map is None:
            return np.empty((0, 2))
        if self._known[0] is not robot.map.value:
            self._known = robot.map.value, _known_corners(robot.map.value)
        return self._known[1]


def _pose(robot: RobotState) -> Pose | None:
    if robot.navigation is None:
        return None
    state = robot.navigation.value
    if not all(map(math.isfinite, (state.x, state.y, state.theta))):
        return None
    return Pose(x=state.x, y=state.y, theta=state.theta)


def _points(robot: RobotState) -> tuple[InterestPoint, ...]:
    """The marks, if the robot reports them."""
    received = robot.newest(INTEREST_POINTS)
    points = received.value.points if received is not None else ()
    return tuple(point for point in points if math.isfinite(point.x) and math.isfinite(point.y))


def _route(robot: RobotState) -> Floats:
    """The path of the robot's task [m], shape (n, 2); n is 0 if it has none."""
    received = robot.newest(NAVIGATION_STATUS)
    if received is None or received.value.task is not Task.GOING:
        return np.empty((0, 2))
    points = [(point.x, point.y) for point in received.value.path]
    path: Floats = np.array(points, np.float64).reshape(-1, 2)
    known: Floats = path[np.isfinite(path).all(axis=1)]
    return known


def _goal(robot: RobotState, now: float) -> tuple[tuple[float, float], str, Severity]:
    """The target of the robot's task, or of the last one with its outcome; empty: none."""
    task = navigation_task(robot)
    if task is None or not (math.isfinite(task.x) and math.isfinite(task.y)):
        return (0.0, 0.0), "", Severity.PLAIN
    return (task.x, task.y), *goal_word(task, now)


def _whole(number: float) -> int | None:
    return round(number) if math.isfinite(number) else None


def _known_corners(grid: OccupancyMap) -> Floats:
    known = grid.cells > UNKNOWN
    columns, rows = np.flatnonzero(known.any(axis=0)), np.flatnonzero(known.any(axis=1))
    if not len(rows):
        return np.empty((0, 2))
    low = np.array((columns[0], rows[0]))
    high = np.array((columns[-1] + 1, rows[-1] + 1))
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    return np.array((grid.origin_x, grid.origin_y)) + np.array(corners) * grid.resolution


def _around(corners: Floats, size: tuple[int, int], up: float, zoom: float) -> MapWindow:
    """The window that shows all corners, centred."""
    x, y = ((corners.min(axis=0) + corners.max(axis=0)) / 2.0).tolist()
    width, height = size
    metres = MapWindow(x=x, y=y, metres_per_pixel=1.0, width=width, height=height, up=up)
    spread = np.ptp(metres.pixels(corners), axis=0) * _MARGIN
    scale = max(_FINEST_M, float((spread / size).max()) / zoom)
    return MapWindow(x=x, y=y, metres_per_pixel=scale, width=width, height=height, up=up)


def _draw_grid(canvas: Canvas, window: MapWindow, robot: RobotState, theme: Theme) -> None:
    """Walls, free floor, and unknown ground, which is dotted."""
    unknown = theme.unknown
    if robot.map is None:
        canvas.fill(unknown)
        nothing = np.ones((canvas.height, canvas.width), np.bool_)
    else:
        colours = grid_colours(
            free=theme.floor, occupied=theme.wall, unknown=unknown, outside=unknown
        )
        colours[:101] = colours[_CONTRAST]
        values = grid_values(robot.map.value, window)
        canvas.pixels[...] = colours[values.view(np.uint8)]
        nothing = values < 0
    for first in (0, 2):
        dots = canvas.pixels[first::4, first::4]
        dots[nothing[first::4, first::4]] = _between(unknown, theme.faint, _DOTTED)


def _between(first: Colour, second: Colour, share: float) -> Colour:
    red, green, blue = (
        round(a + (b - a) * share) for a, b in zip(first[:3], second[:3], strict=True)
    )
    return red, green, blue, 255


def _remark(robot: RobotState, now: float) -> str:
    """Words about the map."""
    if robot.map is not None and robot.map.age(now) > OLD_MAP_S:
        return f"map {age_text(robot.map.age(now))} old"
    return "" if _pose(robot) is not None else "position unknown"


def _write_remark(canvas: Canvas, remark: str, theme: Theme) -> None:
    if remark:
        spot = (max(0.0, float(canvas.width - len(remark))), canvas.height - 1.0)
        map_marks.write_at(canvas, spot, remark, theme.warning, theme)


def _explanation(robot: RobotState, now: float) -> str:
    """Why there is no map; the banner reports a lost link."""
    if robot.map is not None or topics_of(robot) is not None:  # a recording waits for nothing
        return ""
    trouble = link_trouble(robot, now)
    if trouble:
        return f"{trouble}; {robot.link.detail}" if robot.link.detail else trouble
    lack = robot.link.lacking.get(Capability.PRO_MAP)
    if lack is None:
        return f"waiting for the first map from {robot.title}"
    return f"no map from {robot.title}: {Capability.PRO_MAP}: {lack.why}"
