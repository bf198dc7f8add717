"""visualizeRangeData: the robot from above, and the ranges around it."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from typing import ClassVar, Final, Self

import numpy as np

from hub.gcm.body import ROBOT_DESCRIPTION, Bumper, RangeKind
from hub.gcm.edges import EDGES
from hub.gcm.ranges import RANGES
from hub.gcm.vision import CAMERA_STATE
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.body import pressed_bumpers
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.edges import edges_around
from rune_tui.model.robot_ranges import RobotRanges, lack_of_ranges, ranges_of
from rune_tui.model.robot_state import RobotState
from rune_tui.model.sightings import Bools, Floats
from rune_tui.model.theme import Theme
from rune_tui.model.view_cones import ViewCone, view_cones
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import Pen, Point, drawing, toward
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.maps.edge_marks import draw_edges, write_edge
from rune_tui.visualizers.maps.range_shapes import (
    Plan,
    Slice,
    fans,
    outlines,
    slices,
    to_the_rim,
)
from rune_tui.visualizers.parts.nearness import (
    CLOSE_M,
    NEAR_M,
    Nearness,
    avoids_obstacles,
    nearness_of,
)
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.staleness import (
    Staleness,
    age_look,
    fade_by_age,
    mark_age,
    staleness,
)

DEFAULT_RIM_M: Final = 3.0

_SOUND: Final = (RangeKind.SONAR, RangeKind.ECHO_SOUNDER)
_LIGHT: Final = (RangeKind.INFRARED, RangeKind.LASER)
_KINDS: Final = {"sonar": _SOUND, "infrared": _LIGHT}
_SMOOTHING = 3
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
_MARK_APART: Final = math.radians(12.0)
"""Of two marks whose directions differ by less, the nearer obstacle has one [rad]."""
_VIEW_GRAIN: Final = math.radians(1.0)
"""Turns of a camera that are too small to see [rad]."""
_BUMPER: Final = 2.0
"""Width of a pressed bumper [pixels]."""

_MARKS: Final = {Nearness.NEAR: "!", Nearness.CLOSE: "X"}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Shown:
    """The ranges that are drawn.

    Attributes:
        ranges: The robot's ranges.
        readings: Range of each beam as it is drawn [m], shape (n,); NaN: none.
        nearness: `Nearness` of each beam's obstacle, shape (n,).
        pies: Numbers of the beams with a pie.
        arcs: Numbers of the beams with an arc.
        scans: The scans.
    """

    ranges: RobotRanges
    readings: Floats
    nearness: Floats
    pies: Sequence[int]
    arcs: Sequence[int]
    scans: Sequence[slice]

    def of_slice(self, each: Slice) -> Nearness:
        return Nearness(int(self.nearness[each.number]))


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeData:
    """The body of the robot, its ranges, its pressed bumpers, and edges, from above.

    A wide beam is a pie, a scan of narrow beams a filled outline, another narrow beam an arc. The
    direction behind a near obstacle has a colour of its own, up to the rim, and a mark; a pressed
    bumper has a "B". Places where the ground ends are dots with the word EDGE. The rest is clear,
    so that it can cover video.

    Attributes:
        rim_m: Range at the rim of the drawing, from the robot's centre [m].
        sensors: The kinds: "sonar" for sound, "infrared" for light, "both", or "fused".
        near_m: Obstacles nearer to the body than this are near [m].
        close_m: Obstacles nearer to the body than this are close [m].
    """

    rim_m: float = DEFAULT_RIM_M
    sensors: str = "both"
    near_m: float = NEAR_M
    close_m: float = CLOSE_M

    rule: ClassVar = VisualizerRule(
        above=True,
        meaning="the robot's body, a pie for each wide range sensor, an outline for each scan, "
        "rings at whole distances, the field of view of each camera at the rim, and dots with the "
        "word EDGE where the ground ends",
        message="GCM_RobotState",
        others=(ROBOT_DESCRIPTION.name, RANGES.name, EDGES.name, CAMERA_STATE.name),
        option=NumberOption(
            default=0.0, least=0.0, most=100.0, unit="m", meaning="range at the rim; 0 means 3 m"
        ),
        options={
            "sensors": ChoiceOption(
                default="both",
                choices=("sonar", "infrared", "fused", "both"),
                meaning="sonar: only sensors that use sound, each a pie; infrared: only those that "
                "use light, lasers too, each a pie or a scan's outline; both: wide beams as pies, "
                "scans as outlines, other narrow beams as arcs; fused: as both, but a pie ends at "
                "what a narrow beam in it finds",
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
        lack, theme = lack_of_ranges(robot), state.theme
        if lack or robot.body is None:
            write_notice(canvas, lack, theme)
            return
        plan = Plan.of(canvas, robot.body, self.rim_m)
        shown, bumpers = self._shown(robot, state), _pressed(robot, state)
        rings, edges = _rings(plan), _edges(plan, robot, state)
        with drawing(canvas, smoothing=_SMOOTHING) as pen:
            pen.circle(plan.centre, plan.rim, fill=(*theme.ground[:3], _PLATE_ALPHA))
            if shown is not None:
                _draw_scans(pen, plan, shown, theme)
                _draw_pies(pen, plan, shown, theme)
            line = (*theme.faint[:3], _RING_ALPHA)
            for ring in rings:
                pen.circle(plan.centre, plan.length(ring), rim=line)
            if shown is not None:
                _draw_lines(pen, plan, shown, theme)
            _draw_views(pen, plan, view_cones(robot, state), theme)
            draw_edges(pen, edges, theme)
            _draw_body(pen, plan, bumpers, theme)
        measured = robot.newest(RANGES)
        age = measured.age(state.now) if measured is not None else 0.0
        fade_by_age(canvas, age)
        _write_metres(canvas, plan, rings, theme)
        if shown is not None:
            _write_marks(canvas, plan, shown, theme)
        write_edge(canvas, edges, plan.centre, theme)
        for bumper in bumpers:
            _write_at(canvas, _bumper_spot(plan, bumper), "B", theme.on_alarm)
        if shown is None or not (shown.pies or shown.arcs or shown.scans):
            _write_low(canvas, self._nothing, theme)
        mark_age(canvas, age, theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the ranges and the drawing of their age."""
        lack, measured = lack_of_ranges(robot), robot.newest(RANGES)
        if lack:
            return lack, state.theme.name
        ranges = ranges_of(robot)
        return (
            ranges.ranges[self._wanted(ranges)].tobytes() if ranges is not None else b"",
            _pressed(robot, state),
            tuple(cone.seen_at(_VIEW_GRAIN, 1.0) for cone in view_cones(robot, state)),
            edges_around(robot, state.now).tobytes(),
            avoids_obstacles(robot, state.now),
            robot.body,
            age_look(measured, state.now) if measured is not None else None,
            state.theme.name,
        )

    @property
    def _nothing(self) -> str:
        """What the robot does not have, in words."""
        return f"no {self.sensors if self.sensors in _KINDS else 'ranges'} around"

    def _wanted(self, ranges: RobotRanges) -> Bools:
        """Which beams are drawn, shape (n,)."""
        beams, kinds = ranges.of.beams, _KINDS.get(self.sensors)
        return ranges.of.level if kinds is None else ranges.of.level & beams.of_kind(*kinds)

    def _shown(self, robot: RobotState, state: ConsoleState) -> _Shown | None:
        """The ranges that are drawn; None: the robot has no range sensors."""
        ranges = ranges_of(robot)
        if ranges is None:
            return None
        of, wanted = ranges.of, self._wanted(ranges)
        readings = np.where(wanted, ranges.ranges, np.nan).astype(np.float64)
        # Infrared light reaches not far: no obstacle does not mean a free way.
        readings[np.isinf(readings) & of.beams.of_kind(RangeKind.INFRARED)] = np.nan
        alone = wanted & ~of.in_scan
        pies = alone if self.sensors in _KINDS else alone & of.wide
        arcs = alone & ~pies
        room = ranges.room
        if self.sensors == "fused":
            readings, room, arcs = _fused(ranges, readings, pies, arcs)
        limit = avoids_obstacles(robot, state.now)
        nearness = np.zeros(len(room))
        for number in np.flatnonzero(wanted & (room < self.near_m)).tolist():
            nearness[number] = nearness_of(room[number], self.near_m, self.close_m, avoids=limit)
        return _Shown(
            ranges=ranges,
            readings=readings,
            nearness=nearness,
            pies=np.flatnonzero(pies).tolist(),
            arcs=np.flatnonzero(arcs).tolist(),
            scans=[scan for scan in of.scans if wanted[scan].any()],
        )


def _fused(
    ranges: RobotRanges, readings: Floats, pies: Bools, arcs: Bools
) -> tuple[Floats, Floats, Bools]:
    """Wide beams that end at what a narrow beam in their cone finds.

    Returns:
        The ranges [m], the room beside the body [m], and the narrow beams that are in no cone.
    """
    beams, readings, room = ranges.of.beams, readings.copy(), ranges.room.copy()
    inside = np.zeros(len(readings), np.bool_)
    for number in np.flatnonzero(pies).tolist():
        x, y = ranges.x - beams.x[number], ranges.y - beams.y[number]
        aside = (np.arctan2(y, x) - beams.bearing[number] + np.pi) % math.tau - np.pi
        found = arcs & (np.abs(aside) <= ranges.of.half[number])
        inside |= found
        if found.any():
            nearest = np.where(found, np.hypot(x, y), np.inf).min()
            readings[number] = np.fmin(readings[number], nearest)
            room[number] = min(room[number], ranges.room[found].min())
    return readings, room, arcs & ~inside


def _pressed(robot: RobotState, state: ConsoleState) -> tuple[Bumper, ...]:
    """The bumpers that are pressed, if that is known."""
    known = robot.navigation
    if known is None or staleness(known.age(state.now)) is Staleness.STALE:
        return ()
    return pressed_bumpers(robot.body, known.value.bumpers)


def _draw_views(pen: Pen, plan: Plan, cones: Sequence[ViewCone], theme: Theme) -> None:
    """An arc at the rim for the field of view of each camera; the chosen one's is stronger."""
    for cone in cones:
        if math.isnan(cone.bearing):
            continue
        colour = (*theme.cone[:3], 255 if cone.chosen else _RING_ALPHA)
        pen.arc(plan.centre, plan.rim, cone.bearing, cone.width, colour)


def _edges(plan: Plan, robot: RobotState, state: ConsoleState) -> list[Point]:
    """The known edges within the rim."""
    around = edges_around(robot, state.now)
    shown = around[np.hypot(around[:, 0], around[:, 1]) <= plan.rim_m]
    return [plan.at(x, y) for x, y in shown.tolist()]


def _bumper_spot(plan: Plan, bumper: Bumper) -> Point:
    """The middle of a bumper."""
    pieces = plan.edge(bumper.direction, bumper.width)
    if not pieces:
        return toward(plan.centre, plan.body + 1.0, bumper.direction)
    longest = max(pieces, key=len)
    return longest[len(longest) // 2]


def _draw_scans(pen: Pen, plan: Plan, shown: _Shown, theme: Theme) -> None:
    """Fill the area that each scan has measured, and what is behind near obstacles."""
    ranges = shown.ranges
    for scan in shown.scans:
        nearness = shown.nearness[scan]
        for fan in fans(plan, ranges, scan, np.where(nearness > 0.0, nearness, np.nan)):
            colour = _colour(Nearness(int(shown.nearness[fan.first])), theme)
            blocked = (*colour[:3], _NEAR_ALPHA)
            pen.polygon([fan.origin, *to_the_rim(plan, ranges, fan)], blocked)
        endless = np.where(np.isnan(shown.readings[scan]), np.nan, np.isinf(shown.readings[scan]))
        for fan in fans(plan, ranges, scan, endless):
            alpha = _UNBOUNDED_ALPHA if math.isinf(shown.readings[fan.first]) else _FREE_ALPHA
            pen.polygon([fan.origin, *fan.edge], (*theme.accent[:3], alpha))


def _draw_pies(pen: Pen, plan: Plan, shown: _Shown, theme: Theme) -> None:
    for pie in slices(plan, shown.ranges, shown.readings, shown.pies):
        reach, nearness = pie.reach, shown.of_slice(pie)
        if nearness:
            # To the rim, so that its side is clear at a glance; the free part is before it.
            blocked = (*_colour(nearness, theme)[:3], _NEAR_ALPHA)
            pen.pie(pie.origin, pie.rim, pie.direction, pie.opening, blocked)
            reach = max(reach, _least_reach(plan, pie))
        alpha = _UNBOUNDED_ALPHA if math.isinf(pie.range) else _FREE_ALPHA
        free = (*theme.accent[:3], alpha)
        pen.pie(pie.origin, reach, pie.direction, pie.opening, free)
        if pie.ends:
            pen.arc(pie.origin, reach, pie.direction, pie.opening, theme.good)


def _draw_lines(pen: Pen, plan: Plan, shown: _Shown, theme: Theme) -> None:
    """Draw the ends of scans and of other narrow beams."""
    for scan in shown.scans:
        for line in outlines(plan, shown.ranges, scan):
            x, y = line[0]
            pen.line(line if len(line) > 1 else [(x, y), (x + 1.0, y)], theme.good)
    for arc in slices(plan, shown.ranges, shown.readings, shown.arcs):
        if arc.ends:
            reach = max(arc.reach, _least_reach(plan, arc))
            pen.arc(arc.origin, reach, arc.direction, arc.opening / 2.0, theme.ink)


def _least_reach(plan: Plan, pie: Slice) -> float:
    """Length at which a pie's end is beside a round body; the end is beside any other anyway."""
    return 0.0 if plan.outline else plan.to_circle(pie.origin, pie.direction, plan.body + 1.0)


def _write_marks(canvas: Canvas, plan: Plan, shown: _Shown, theme: Theme) -> None:
    for number in _marked(shown):
        origin = plan.at(
            float(shown.ranges.of.beams.x[number]), float(shown.ranges.of.beams.y[number])
        )
        nearness = Nearness(int(shown.nearness[number]))
        direction = float(shown.ranges.of.beams.bearing[number])
        reach = plan.length(float(shown.readings[number]))
        if not plan.outline:
            reach = max(reach, plan.to_circle(origin, direction, plan.body))
        spot = toward(origin, reach + 1.5, direction)
        ink = theme.warning if nearness is Nearness.NEAR else theme.alarm_ink
        _write_at(canvas, spot, _MARKS[nearness], ink)


def _marked(shown: _Shown) -> Iterator[int]:
    """Numbers of the beams whose obstacles have a mark, the nearest first."""
    near = np.flatnonzero(shown.nearness > 0.0)
    kept: list[float] = []
    for number in near[np.argsort(shown.ranges.room[near], kind="stable")].tolist():
        direction = float(shown.ranges.of.beams.bearing[number])
        if all(abs(math.remainder(direction - each, math.tau)) >= _MARK_APART for each in kept):
            kept.append(direction)
            yield number


def _rings(plan: Plan) -> list[float]:
    """Distances with a ring [m]: round ones, as many as are distinct."""
    metre = plan.rim / plan.rim_m
    least = max(_LEAST_RING / metre, plan.rim_m / _MOST_RINGS)
    step = next((each for each in _RING_STEPS if each >= least), 0.0)
    if plan.rim < _LEAST_RIM or not step:
        return []
    return [step * number for number in range(1, math.floor(plan.rim_m / step + 1e-6) + 1)]


def _write_metres(canvas: Canvas, plan: Plan, rings: Sequence[float], theme: Theme) -> None:
    """The distance of each ring; the last has the unit."""
    for number, ring in enumerate(rings):
        x, y = toward(plan.centre, plan.length(ring), _RING_DIRECTION)
        words = f"{ring:g} m" if number == len(rings) - 1 else f"{ring:g}"
        column = max(0, min(canvas.width - len(words), int(x)))
        canvas.text(column, min(canvas.rows - 1, int(y) // 2), words, theme.soft)


def _colour(nearness: Nearness, theme: Theme) -> Colour:
    return theme.alarm if nearness is Nearness.CLOSE else theme.warning


def _draw_body(pen: Pen, plan: Plan, bumpers: Sequence[Bumper], theme: Theme) -> None:
    if not plan.outline:
        for bumper in bumpers:
            reach = plan.body + _BUMPER
            pen.pie(plan.centre, reach, bumper.direction, bumper.width, theme.alarm)
        pen.circle(plan.centre, plan.body, fill=theme.panel, rim=theme.ink)
    else:
        pen.polygon(plan.outline, theme.panel)
        pen.line([*plan.outline, plan.outline[0]], theme.ink)
        for bumper in bumpers:
            for piece in plan.edge(bumper.direction, bumper.width):
                pen.line(piece, theme.alarm, _BUMPER)
    pen.line([plan.centre, toward(plan.centre, plan.body + 1.0, 0.0)], theme.ink)


def _write_low(canvas: Canvas, words: str, theme: Theme) -> None:
    """Words on the last row."""
    words = words[: canvas.width]
    canvas.text((canvas.width - len(words)) // 2, canvas.rows - 1, words, theme.soft)


def _write_at(canvas: Canvas, point: Point, mark: str, colour: Colour) -> None:
    column = int(np.clip(point[0], 0, canvas.width - 1))
    row = int(np.clip(point[1], 0, canvas.height - 1)) // 2
    canvas.text(column, row, mark, colour)
