"""The shapes of ranges on a plan of the robot from above."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from hub.gcm.body import RobotBody
from hub.values import dataclass
from rune_tui.model.body import corners, largest_radius
from rune_tui.model.robot_ranges import RobotRanges
from rune_tui.model.sightings import Floats
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import Point, toward

PIE: Final = math.radians(22.5)
"""Largest angle at which a narrow beam that is alone is drawn [rad]."""

_LEAST_ROOM: Final = 2.0
"""Least reach of the drawing [radii of the body]."""
_POINT_M: Final = 1e-3
"""Least size of a body with visible corners [m]."""
_JOIN_M: Final = 0.5
"""Ends of neighbours in a scan are joined if they are nearer to each other than this [m]."""
_EDGE_STEPS: Final = 24
"""Number of points on an edge of the body."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The measures of the drawing on the canvas [pixels].

    Attributes:
        centre: The robot's origin.
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

    @classmethod
    def of(cls, canvas: Canvas, body: RobotBody | None, rim_m: float) -> Plan:
        """The plan that fits a canvas, with room around a large robot."""
        radius = largest_radius(body)
        rim_m = max(rim_m, _LEAST_ROOM * radius)
        rim = max(1.0, min(canvas.width, canvas.height) / 2.0 - 0.5)
        centre = (canvas.width / 2.0, canvas.height / 2.0)
        drawn = max(radius / rim_m * rim, min(2.0, rim / 3.0))
        # On the canvas, ahead is up and left is left.
        around = corners(body) * (drawn / radius if radius > _POINT_M else 0.0)
        points = [(centre[0] - left, centre[1] - ahead) for ahead, left in around.tolist()]
        return cls(centre, rim, rim_m, points, drawn)

    def at(self, x: float, y: float) -> Point:
        """The pixel of a point in the robot's frame [m]."""
        scale = self.rim / self.rim_m
        return self.centre[0] - y * scale, self.centre[1] - x * scale

    def length(self, range_m: float) -> float:
        """A distance [m] in pixels, at most to the rim."""
        return min(range_m, self.rim_m) / self.rim_m * self.rim

    def to_circle(self, origin: Point, direction: float, radius: float) -> float:
        """Distance from a point to a circle around the centre, in a direction [pixels]."""
        x, y = origin[0] - self.centre[0], origin[1] - self.centre[1]
        along = -x * math.sin(direction) - y * math.cos(direction)
        return max(0.0, math.sqrt(max(0.0, radius**2 - x * x - y * y + along**2)) - along)

    def edge(self, direction: float, width: float) -> list[list[Point]]:
        """The pieces of the outline in an angle around the centre; none if it is a circle."""
        pieces: list[list[Point]] = [[]]
        for begin, end in itertools.pairwise([*self.outline, *self.outline[:1]]):
            for step in range(_EDGE_STEPS):
                share = step / _EDGE_STEPS
                x, y = (a + (b - a) * share for a, b in zip(begin, end, strict=True))
                turn = math.atan2(self.centre[0] - x, self.centre[1] - y)
                if abs(math.remainder(turn - direction, math.tau)) <= width / 2.0:
                    pieces[-1].append((x, y))
                elif pieces[-1]:
                    pieces.append([])
        return [piece for piece in pieces if piece]


@dataclass(frozen=True, slots=True, kw_only=True)
class Slice:
    """A beam as a pie or an arc.

    Attributes:
        number: Number of the beam.
        origin: Tip of the pie.
        direction: Of its middle [rad], counter-clockwise from up.
        opening: Its angle [rad].
        range: Its range [m].
        reach: The range, at most to the rim [pixels].
        rim: Distance from the tip to the rim [pixels].
    """

    number: int
    origin: Point
    direction: float
    opening: float
    range: float
    reach: float
    rim: float

    @property
    def ends(self) -> bool:
        """Whether an obstacle within the rim ends it."""
        return math.isfinite(self.range) and self.reach < self.rim


@dataclass(frozen=True, slots=True, kw_only=True)
class Fan:
    """Neighbours of a scan with something in common.

    Attributes:
        origin: Its tip.
        first: Number of the first beam.
        last: Number of the last.
        edge: The outer corners on the canvas.
    """

    origin: Point
    first: int
    last: int
    edge: Sequence[Point]


def slices(
    plan: Plan, ranges: RobotRanges, readings: Floats, numbers: Sequence[int]
) -> Iterator[Slice]:
    """The beams of these numbers with a known range [m], the farthest first."""
    of, beams = ranges.of, ranges.of.beams
    known = [number for number in numbers if not math.isnan(readings[number])]
    for number in sorted(known, key=lambda each: -readings[each]):
        own, step = float(beams.opening[number]), float(of.step[number]) or math.tau
        opening = min(own, step) if of.wide[number] else max(own, min(step, PIE))
        origin = plan.at(float(beams.x[number]), float(beams.y[number]))
        direction = float(beams.bearing[number])
        rim = min(
            plan.to_circle(origin, direction + side * opening / 2.0, plan.rim)
            for side in (-1.0, 0.0, 1.0)
        )
        reading = float(readings[number])
        scale = math.cos(beams.elevation[number]) * plan.rim / plan.rim_m
        yield Slice(
            number=number,
            origin=origin,
            direction=direction,
            opening=opening,
            range=reading,
            reach=min(reading * scale, rim),
            rim=rim,
        )


def fans(plan: Plan, ranges: RobotRanges, scan: slice, which: Floats) -> Iterator[Fan]:
    """Runs of neighbours with the same number in `which`, up to their ends, in a scan.

    Args:
        plan: The plan.
        ranges: The ranges.
        scan: The beams of the scan.
        which: A number for each beam of the scan, shape (n,); NaN: it is in no run.
    """
    beams = ranges.of.beams
    origin = plan.at(float(beams.x[scan.start]), float(beams.y[scan.start]))
    reach = scan_reach(plan, ranges, scan)
    half = ranges.of.step[scan.start] / 2.0
    breaks = np.flatnonzero(np.diff(which) != 0.0) + 1
    for run in np.split(np.arange(len(which)), breaks):
        if not len(run) or math.isnan(which[run[0]]):
            continue
        turns = beams.bearing[scan][run][:, None] + np.array((-half, half))
        # The corners follow the beams, also those of a sensor that turns to the right.
        if len(run) > 1 and _turns_right(beams.bearing[scan][run[:2]]):
            turns = turns[:, ::-1]
        edge = _points(origin, np.repeat(reach[run], 2), turns.ravel())
        yield Fan(
            origin=origin,
            first=scan.start + int(run[0]),
            last=scan.start + int(run[-1]),
            edge=edge,
        )


def to_the_rim(plan: Plan, ranges: RobotRanges, fan: Fan) -> Sequence[Point]:
    """The outer corners of a fan that reaches to the rim."""
    directions = ranges.of.beams.bearing[fan.first : fan.last + 1]
    half = ranges.of.step[fan.first] / 2.0
    ends = (float(directions[0]), float(directions[-1]))
    side = -1.0 if len(directions) > 1 and _turns_right(directions[:2]) else 1.0
    turns = (ends[0] - side * half, *directions.tolist(), ends[1] + side * half)
    return [toward(fan.origin, plan.to_circle(fan.origin, turn, plan.rim), turn) for turn in turns]


def outlines(plan: Plan, ranges: RobotRanges, scan: slice) -> Iterator[Sequence[Point]]:
    """The lines through the ends of a scan's beams within the rim."""
    beams = ranges.of.beams
    bearings = beams.bearing[scan]
    x, y = ranges.x[scan], ranges.y[scan]
    shown = np.hypot(x, y) <= plan.rim_m
    origin = plan.at(float(beams.x[scan.start]), float(beams.y[scan.start]))
    points = _points(origin, scan_reach(plan, ranges, scan), bearings)
    order = list(range(len(points)))
    if abs(len(points) * ranges.of.step[scan.start] - math.tau) < ranges.of.step[scan.start]:
        order.append(0)  # the last is a neighbour of the first
    line: list[Point] = []
    for number, before in zip(order, (-1, *order), strict=False):
        joins = bool(line) and math.hypot(x[number] - x[before], y[number] - y[before]) <= _JOIN_M
        if not (shown[number] and joins) and line:
            yield line
            line = []
        if shown[number]:
            line.append(points[number])
    if line:
        yield line


def scan_reach(plan: Plan, ranges: RobotRanges, scan: slice) -> Floats:
    """The reach of each beam of a scan, at most to the rim [pixels], shape (n,)."""
    beams = ranges.of.beams
    x, y = (float(each[scan.start]) * plan.rim / plan.rim_m for each in (beams.x, beams.y))
    along = x * np.cos(beams.bearing[scan]) + y * np.sin(beams.bearing[scan])
    rim = np.sqrt(np.maximum(0.0, plan.rim**2 - x * x - y * y + along**2)) - along
    length = ranges.ranges[scan] * np.cos(beams.elevation[scan]) * plan.rim / plan.rim_m
    reach: Floats = np.fmin(length, np.maximum(rim, 0.0))
    return reach


def _points(origin: Point, reach: Floats, turns: Floats) -> list[Point]:
    x = origin[0] - reach * np.sin(turns)
    y = origin[1] - reach * np.cos(turns)
    return list(zip(x.tolist(), y.tolist(), strict=True))


def _turns_right(two: Floats) -> bool:
    """Whether the second of two neighbouring directions lies right of the first."""
    return math.remainder(float(two[1] - two[0]), math.tau) < 0.0
