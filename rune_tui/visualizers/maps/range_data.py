"""visualizeRangeData: the robot from above, a pie for each range sensor."""

from __future__ import annotations

import enum
import math
from collections.abc import Hashable, Iterator, Sequence
from typing import ClassVar, Final, Self

import numpy as np
import numpy.typing as npt

from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.navigation import SENSOR_COUNT, Assistance, MotionState
from hub.gcm.navigation import RobotState as NavigationState
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.body import corners, largest_radius, rim
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import Pen, Point, drawing, toward
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.staleness import age_look, fade_by_age, mark_age

NEAR_M: Final = 0.5
CLOSE_M: Final = 0.15
DEFAULT_RIM_M: Final = 3.0

_OPENING = 2.0 * math.pi / SENSOR_COUNT
_SMOOTHING = 3
_LEAST_ROOM: Final = 2.0
"""Least reach of the drawing [radii of the body]."""
_POINT_M: Final = 1e-3
"""Least size of a body with visible corners [m]."""
_FREE_ALPHA, _UNBOUNDED_ALPHA, _NEAR_ALPHA = 190, 90, 235
_PLATE_ALPHA, _RING_ALPHA = 150, 130
_RING_STEPS: Final = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_LEAST_RING: Final = 3.5
"""Least distance between rings [pixels]."""
_MOST_RINGS: Final = 4
_LEAST_RIM: Final = 8.0
"""Least rim of a drawing with rings [pixels]."""
_RING_DIRECTION: Final = math.radians(-146.0)
"""Bearing of the distances at rings: between two sensors, behind on the right."""


@dataclass(frozen=True, slots=True)
class _Plan:
    """The measures of the drawing on the canvas [pixels].

    Attributes:
        centre: The robot's centre.
        rim: Length of `rim_m`.
        rim_m: Range at the rim [m].
        outline: Corners of the body; none: a circle.
        body: Radius of the circle around the body.
    """

    centre: Point
    rim: float
    rim_m: float
    outline: Sequence[Point]
    body: float

    def length(self, range_m: float) -> float:
        """A range from the robot's centre [m] in pixels, at most to the rim."""
        return min(range_m, self.rim_m) / self.rim_m * self.rim


class Nearness(enum.IntEnum):
    """The distance of an obstacle from the body.

    Attributes:
        FAR: There is room.
        NEAR: Take care; has a colour and an exclamation mark.
        CLOSE: About to touch; has another colour and an X.
    """

    FAR = 0
    NEAR = 1
    CLOSE = 2


_MARKS: Final = {Nearness.NEAR: "!", Nearness.CLOSE: "X"}


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeData:
    """A pie for each range sensor, an arc for each infrared one, a wedge for each pressed bumper.

    The direction behind an obstacle has a colour of its own, up to the rim. A near obstacle has
    another colour and a mark; a pressed bumper has a "B". The rest is clear, so that it can
    cover video.

    Attributes:
        rim_m: Range at the rim of the drawing, from the robot's centre [m].
        sensors: The sensors: "sonar", "infrared", "both", or the nearest of both as "fused".
        near_m: Obstacles nearer to the body than this are near [m].
        close_m: Obstacles nearer to the body than this are close [m].
    """

    rim_m: float = DEFAULT_RIM_M
    sensors: str = "both"
    near_m: float = NEAR_M
    close_m: float = CLOSE_M

    rule: ClassVar = VisualizerRule(
        above=True,
        meaning="the robot, a pie for each range sensor, and rings at whole distances",
        message="GCM_RobotState",
        others=(ROBOT_DESCRIPTION.name,),
        option=NumberOption(
            default=0.0, least=0.0, most=100.0, unit="m", meaning="range at the rim; 0 means 3 m"
        ),
        options={
            "sensors": ChoiceOption(
                default="both",
                choices=("sonar", "infrared", "fused", "both"),
                meaning="a pie for each sonar, or for each infrared sensor, or up to what the "
                "nearer of both says, or for each sonar and an arc for each infrared sensor",
            ),
            "near": NumberOption(
                default=NEAR_M,
                least=0.0,
                most=10.0,
                unit="m",
                meaning="what is nearer to the body has a warning colour and an exclamation mark",
            ),
            "close": NumberOption(
                default=CLOSE_M,
                least=0.0,
                most=10.0,
                unit="m",
                meaning="what is nearer to the body has an alarming colour and an X",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True
    urgency: ClassVar[Urgency] = Urgency.RANGES

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for; its option is the range at the rim [m]."""
        sensible = math.isfinite(spec.option) and spec.option > 0.0
        return cls(
            rim_m=spec.option if sensible else DEFAULT_RIM_M,
            sensors=spec.options.word("sensors"),
            near_m=spec.options.number("near"),
            close_m=spec.options.number("close"),
        )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the newest ranges and their age."""
        if robot.navigation is None:
            write_notice(canvas, f"no ranges from {robot.title} yet", state.theme)
            return
        navigation = robot.navigation.value
        age = robot.navigation.age(state.now)
        plan = self._plan(canvas, robot.body)
        rings = _rings(plan)
        with drawing(canvas, smoothing=_SMOOTHING) as pen:
            pen.circle(plan.centre, plan.rim, fill=(*state.theme.ground[:3], _PLATE_ALPHA))
            self._draw_pies(pen, plan, navigation, robot.body, state.theme)
            line = (*state.theme.faint[:3], _RING_ALPHA)
            for ring in rings:
                pen.circle(plan.centre, plan.length(ring), rim=line)
            for sensor, reading in enumerate(self._arcs(navigation).tolist()):
                if reading <= plan.rim_m:
                    reach = max(plan.length(reading), plan.body + 1.0)
                    pen.arc(plan.centre, reach, _direction(sensor), _OPENING / 2.0, state.theme.ink)
            _draw_body(pen, plan, navigation, state.theme)
        fade_by_age(canvas, age)
        _write_metres(canvas, plan, rings, state.theme)
        self._write_marks(canvas, plan, navigation, robot.body, state.theme)
        mark_age(canvas, age, state.theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the ranges and the drawing of their age."""
        if robot.navigation is None:
            return robot.name, state.theme.name
        navigation = robot.navigation.value
        pies, arcs = self._pies(navigation).tobytes(), self._arcs(navigation).tobytes()
        return (
            pies,
            arcs,
            navigation.bumpers,
            avoids_obstacles(navigation),
            robot.body,
            age_look(robot.navigation, state.now),
            state.theme.name,
        )

    def _pies(self, navigation: NavigationState) -> npt.NDArray[np.float32]:
        """The range of each direction that has a pie [m], shape (16,)."""
        if self.sensors not in {"infrared", "fused"}:
            return navigation.sonar
        # Infrared is short: no echo does not mean a free way.
        seen = np.where(np.isinf(navigation.infrared), np.float32(np.nan), navigation.infrared)
        return np.fmin(navigation.sonar, seen) if self.sensors == "fused" else seen

    def _arcs(self, navigation: NavigationState) -> npt.NDArray[np.float32]:
        """The range of each direction that also has an arc [m], shape (16,) or (0,)."""
        return navigation.infrared if self.sensors == "both" else np.empty(0, np.float32)

    def _plan(self, canvas: Canvas, body: RobotBody | None) -> _Plan:
        # The drawing leaves room around a large robot.
        radius = largest_radius(body)
        rim_m = max(self.rim_m, _LEAST_ROOM * radius)
        rim = max(1.0, min(canvas.width, canvas.height) / 2.0 - 0.5)
        centre = (canvas.width / 2.0, canvas.height / 2.0)
        drawn = max(radius / rim_m * rim, min(2.0, rim / 3.0))
        # On the canvas, ahead is up and left is left.
        around = corners(body) * (drawn / radius if radius > _POINT_M else 0.0)
        points = [(centre[0] - left, centre[1] - ahead) for ahead, left in around.tolist()]
        return _Plan(centre=centre, rim=rim, rim_m=rim_m, outline=points, body=drawn)

    def _nearness(self, room: float, navigation: NavigationState) -> Nearness:
        return effective_nearness(nearness_of(room, self.near_m, self.close_m), navigation)

    def _draw_pies(
        self,
        pen: Pen,
        plan: _Plan,
        navigation: NavigationState,
        body: RobotBody | None,
        theme: Theme,
    ) -> None:
        pies = self._pies(navigation)
        for sensor, (reading, room) in enumerate(_with_room(pies, body)):
            if math.isnan(reading):
                continue
            reach, nearness = plan.length(reading), self._nearness(room, navigation)
            colour = _colour(nearness, theme)
            if nearness:
                # To the rim, so that its side is clear at a glance; the free part is before it.
                blocked = (*colour[:3], _NEAR_ALPHA)
                pen.pie(plan.centre, plan.rim, _direction(sensor), _OPENING, blocked)
                reach = max(reach, plan.body + 1.0)
                colour = theme.accent
            alpha = _FREE_ALPHA
            if math.isinf(reading):
                alpha = _UNBOUNDED_ALPHA
            pen.pie(plan.centre, reach, _direction(sensor), _OPENING, (*colour[:3], alpha))
            if reading <= plan.rim_m:
                pen.arc(plan.centre, reach, _direction(sensor), _OPENING, theme.good)

    def _write_marks(
        self,
        canvas: Canvas,
        plan: _Plan,
        navigation: NavigationState,
        body: RobotBody | None,
        theme: Theme,
    ) -> None:
        pies, arcs = self._pies(navigation), self._arcs(navigation)
        nearest = np.fmin(pies, arcs) if len(arcs) else pies
        for sensor, (reading, room) in enumerate(_with_room(nearest, body)):
            nearness = self._nearness(room, navigation)
            if nearness:
                reach = max(plan.length(reading), plan.body) + 1.5
                spot = toward(plan.centre, reach, _direction(sensor))
                ink = theme.warning if nearness is Nearness.NEAR else theme.alarm_ink
                _write_at(canvas, spot, _MARKS[nearness], ink)
        for sensor in pressed_bumpers(navigation):
            spot = toward(plan.centre, plan.body + 1.0, _direction(sensor))
            _write_at(canvas, spot, "B", theme.on_alarm)


def _rings(plan: _Plan) -> list[float]:
    """Distances with a ring [m]: round ones, as many as are distinct."""
    metre = plan.rim / plan.rim_m
    least = max(_LEAST_RING / metre, plan.rim_m / _MOST_RINGS)
    step = next((each for each in _RING_STEPS if each >= least), 0.0)
    if plan.rim < _LEAST_RIM or not step:
        return []
    return [step * number for number in range(1, math.floor(plan.rim_m / step + 1e-6) + 1)]


def _write_metres(canvas: Canvas, plan: _Plan, rings: Sequence[float], theme: Theme) -> None:
    """The distance of each ring; the last has the unit."""
    for number, ring in enumerate(rings):
        x, y = toward(plan.centre, plan.length(ring), _RING_DIRECTION)
        words = f"{ring:g} m" if number == len(rings) - 1 else f"{ring:g}"
        column = max(0, min(canvas.width - len(words), int(x)))
        canvas.text(column, min(canvas.rows - 1, int(y) // 2), words, theme.soft)


def _with_room(
    ranges: npt.NDArray[np.float32], body: RobotBody | None
) -> Iterator[tuple[float, float]]:
    """Each range from the robot's centre, and the free room beside its body [m]."""
    rooms = ranges - rim(body, len(ranges)) if len(ranges) else ranges
    return zip(ranges.tolist(), rooms.tolist(), strict=True)


def nearness_of(room: float, near_m: float = NEAR_M, close_m: float = CLOSE_M) -> Nearness:
    """The class of a distance from the body [m]."""
    if room < close_m:
        return Nearness.CLOSE
    return Nearness.NEAR if room < near_m else Nearness.FAR


def effective_nearness(nearness: Nearness, navigation: NavigationState) -> Nearness:
    """The class that counts: a robot that navigation steers may pass near obstacles."""
    return min(nearness, Nearness.NEAR) if avoids_obstacles(navigation) else nearness


def avoids_obstacles(navigation: NavigationState) -> bool:
    """Whether the robot moves by itself and navigation avoids near obstacles."""
    return navigation.motion is MotionState.GOING and navigation.assistance is Assistance.ON


def pressed_bumpers(navigation: NavigationState) -> list[int]:
    """Numbers of the bumpers that are pressed."""
    return [sensor for sensor in range(SENSOR_COUNT) if navigation.bumpers >> sensor & 1]


def _direction(sensor: int) -> float:
    return sensor * _OPENING


def _colour(nearness: Nearness, theme: Theme) -> Colour:
    colours = {Nearness.NEAR: theme.warning, Nearness.CLOSE: theme.alarm}
    return colours.get(nearness, theme.accent)


def _draw_body(pen: Pen, plan: _Plan, navigation: NavigationState, theme: Theme) -> None:
    for sensor in pressed_bumpers(navigation):
        pen.pie(plan.centre, plan.body + 2.0, _direction(sensor), _OPENING, theme.alarm)
    if plan.outline:
        pen.polygon(plan.outline, theme.panel)
        pen.line([*plan.outline, plan.outline[0]], theme.ink)
    else:
        pen.circle(plan.centre, plan.body, fill=theme.panel, rim=theme.ink)
    pen.line([plan.centre, toward(plan.centre, plan.body + 1.0, 0.0)], theme.ink)


def _write_at(canvas: Canvas, point: Point, mark: str, colour: Colour) -> None:
    column = int(np.clip(point[0], 0, canvas.width - 1))
    row = int(np.clip(point[1], 0, canvas.height - 1)) // 2
    canvas.text(column, row, mark, colour)
