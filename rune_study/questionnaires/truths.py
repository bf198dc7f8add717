"""The truths that questions of a freeze can name: what they are, and how an answer is compared.

Level 1 is what the operator perceives, level 2 what it means, level 3 what he expects.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np

from hub.pose import Pose
from hub.values import dataclass
from rune_study.metrics.awareness import AnswerKind
from rune_study.questionnaires.ground import Ground, Place

Value = float | str | Place | None
AHEAD_S: Final = 5.0
"""How far questions of level 3 look ahead, if nothing changes [s]."""
_BODY_M: Final = 0.25
"""Distance of a wall from the robot's middle at which they touch [m]."""
_STILL: Final = 0.02
"""Velocity below which a robot stands [m/s, rad/s]."""
_STEP_S: Final = 0.05
STANDS, FORWARD, BACKWARD, LEFT, RIGHT = "stands", "forward", "backward", "left", "right"
_MOTIONS: Final = (STANDS, FORWARD, BACKWARD, LEFT, RIGHT)


@dataclass(frozen=True, kw_only=True)
class Moment:
    """What is true of a robot when a trial is frozen.

    Attributes:
        pose: Its pose in `map`.
        linear: Forward velocity [m/s].
        angular: Turn rate [rad/s].
        commanded_linear: Commanded forward velocity [m/s].
        commanded_angular: Commanded turn rate [rad/s].
        pan: Of its camera, positive left [rad]; NaN: not known.
        battery: Charge left, 0 to 1; NaN: not known.
        collisions: Number in this trial; None: not known.
        marks: Marks of victims in `map` [m].
        found: Number of victims with a mark; None: not known.
        victims: Number of victims there are; None: not known.
        robots_moving: Number of robots that move, of all.
        time_left: Until the end of the trial at the latest [s].
        ground: Its ground; None: not known.
    """

    pose: Pose
    linear: float = 0.0
    angular: float = 0.0
    commanded_linear: float = 0.0
    commanded_angular: float = 0.0
    pan: float = math.nan
    battery: float = math.nan
    collisions: int | None = None
    marks: tuple[Place, ...] = ()
    found: int | None = None
    victims: int | None = None
    robots_moving: int = 0
    time_left: float = math.nan
    ground: Ground | None = None

    @property
    def moves(self) -> bool:
        """Whether it moves."""
        return max(abs(self.linear), abs(self.angular)) > _STILL


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedTruth:
    """Something that is true.

    Attributes:
        name: Its name in files.
        level: 1, 2 or 3.
        kind: How an answer is compared with it.
        unit: Of its value and tolerance.
        tolerance: Largest error of a right answer, if the question names none.
        meaning: For people.
        words: The values it can have, if it is a choice.
        in_map: Whether a bearing counts from the x axis of `map`, not from the robot's front.
        of: Its value; None or NaN: it is not known.
    """

    name: str
    level: int
    kind: AnswerKind
    unit: str
    tolerance: float
    meaning: str
    words: tuple[str, ...] = ()
    in_map: bool = False
    of: Callable[[Moment], Value]

    def value(self, moment: Moment) -> Value:
        """Its value at a moment; None: it is not known."""
        found = self.of(moment)
        return None if isinstance(found, float) and math.isnan(found) else found


def _motion(linear: float, angular: float) -> str:
    """What a robot with these velocities does: it drives, else it turns, else it stands."""
    if abs(linear) > _STILL:
        return FORWARD if linear > 0.0 else BACKWARD
    if abs(angular) > _STILL:
        return LEFT if angular > 0.0 else RIGHT
    return STANDS


def _degrees(angle: float) -> float:
    return math.degrees(angle) % 360.0


def _towards(moment: Moment, place: Place) -> float:
    """Direction of a place as the robot sees it [deg]: 0 ahead, 90 left; NaN: it is there."""
    x, y = moment.pose.inward(*place)
    return _degrees(math.atan2(y, x)) if math.hypot(x, y) > 1e-6 else math.nan


def _nearest_wall(moment: Moment) -> Place | None:
    if moment.ground is None:
        return None
    walls = moment.ground.surfaces()
    if not len(walls):
        return None
    away = np.hypot(walls[:, 0] - moment.pose.x, walls[:, 1] - moment.pose.y)
    x, y = walls[int(np.argmin(away))].tolist()
    return x, y


def _wall_direction(moment: Moment) -> float:
    wall = _nearest_wall(moment)
    return math.nan if wall is None else _towards(moment, wall)


def _wall_distance(moment: Moment) -> float:
    wall = _nearest_wall(moment)
    return math.nan if wall is None else math.dist(wall, (moment.pose.x, moment.pose.y))


def _mark_direction(moment: Moment) -> float:
    here = moment.pose.x, moment.pose.y
    nearest = min(moment.marks, key=lambda mark: math.dist(mark, here), default=None)
    return math.nan if nearest is None else _towards(moment, nearest)


def _ahead(moment: Moment, seconds: float) -> Pose:
    """The pose after a time at the present velocities."""
    turn = moment.angular * seconds
    if abs(moment.angular) < 1e-6:
        arc = Pose(x=moment.linear * seconds, theta=turn)
    else:
        radius = moment.linear / moment.angular
        arc = Pose(x=radius * math.sin(turn), y=radius * (1.0 - math.cos(turn)), theta=turn)
    return moment.pose.then(arc)


def _pose_ahead(moment: Moment) -> Place:
    pose = _ahead(moment, AHEAD_S)
    return pose.x, pose.y


def _touches(moment: Moment) -> str | None:
    if moment.ground is None:
        return None
    walls = moment.ground.surfaces()
    for count in range(round(AHEAD_S / _STEP_S) + 1):
        pose = _ahead(moment, count * _STEP_S)
        if len(walls) and np.hypot(walls[:, 0] - pose.x, walls[:, 1] - pose.y).min() <= _BODY_M:
            return "yes"
    return "no"


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


_BEARING, _PLACE, _NUMBER, _CHOICE = (
    AnswerKind.BEARING, AnswerKind.PLACE, AnswerKind.NUMBER, AnswerKind.CHOICE,
)  # fmt: skip
_ROWS = (
    NamedTruth(name="position", level=1, kind=_PLACE, unit="m", tolerance=1.0,
          of=lambda it: (it.pose.x, it.pose.y),
          meaning="where the robot is, in `map`"),
    NamedTruth(name="heading", level=1, kind=_BEARING, unit="deg", tolerance=30.0, in_map=True,
          of=lambda it: _degrees(it.pose.theta),
          meaning="where it faces, counter-clockwise from the x axis of `map`"),
    NamedTruth(name="motion", level=1, kind=_CHOICE, unit="", tolerance=0.0, words=_MOTIONS,
          of=lambda it: _motion(it.linear, it.angular),
          meaning="what it did: drive, or turn on the spot, or stand"),
    NamedTruth(name="speed", level=1, kind=_NUMBER, unit="m/s", tolerance=0.1,
          of=lambda it: abs(it.linear),
          meaning="how fast it drove, forward or backward"),
    NamedTruth(name="camera", level=1, kind=_BEARING, unit="deg", tolerance=15.0,
          of=lambda it: _degrees(it.pan),
          meaning="where its main camera looked, from straight ahead, 90 to the left"),
    NamedTruth(name="battery", level=1, kind=_NUMBER, unit="%", tolerance=10.0,
          of=lambda it: 100.0 * it.battery,
          meaning="charge of the battery that is left"),
    NamedTruth(name="victims_found", level=1, kind=_NUMBER, unit="victims", tolerance=0.0,
          of=lambda it: _number(it.found),
          meaning="number of victims with a mark near them"),
    NamedTruth(name="marks", level=1, kind=_NUMBER, unit="marks", tolerance=0.0,
          of=lambda it: float(len(it.marks)),
          meaning="number of victims that are marked, rightly or not"),
    NamedTruth(name="collisions", level=1, kind=_NUMBER, unit="collisions", tolerance=0.0,
          of=lambda it: _number(it.collisions),
          meaning="number of collisions in this trial"),
    NamedTruth(name="robots_moving", level=1, kind=_NUMBER, unit="robots", tolerance=0.0,
          of=lambda it: float(it.robots_moving),
          meaning="number of robots that moved"),
    NamedTruth(name="wall_direction", level=1, kind=_BEARING, unit="deg", tolerance=45.0,
          of=_wall_direction,
          meaning="where the nearest obstacle is, from straight ahead, 90 to the left"),
    NamedTruth(name="wall_distance", level=1, kind=_NUMBER, unit="m", tolerance=0.3,
          of=_wall_distance,
          meaning="how far the nearest obstacle is from the robot's middle"),
    NamedTruth(name="start_direction", level=2, kind=_BEARING, unit="deg", tolerance=30.0,
          of=lambda it: _towards(it, (0.0, 0.0)),
          meaning="where the origin of `map` is, from straight ahead, 90 to the left"),
    NamedTruth(name="start_distance", level=2, kind=_NUMBER, unit="m", tolerance=1.0,
          of=lambda it: math.hypot(it.pose.x, it.pose.y),
          meaning="how far the origin of `map` is, in a straight line"),
    NamedTruth(name="mark_direction", level=2, kind=_BEARING, unit="deg", tolerance=30.0,
          of=_mark_direction,
          meaning="where the nearest marked victim is, from straight ahead, 90 to the left"),
    NamedTruth(name="victims_left", level=2, kind=_NUMBER, unit="victims", tolerance=0.0,
          of=lambda it: _number(it.victims) - _number(it.found),
          meaning="number of victims without a mark near them"),
    NamedTruth(name="time_left", level=2, kind=_NUMBER, unit="s", tolerance=60.0,
          of=lambda it: it.time_left,
          meaning="time until the end of the trial, at the latest"),
    NamedTruth(name="next_motion", level=3, kind=_CHOICE, unit="", tolerance=0.0, words=_MOTIONS,
          of=lambda it: _motion(it.commanded_linear, it.commanded_angular),
          meaning="what it does next: the motion that is commanded"),
    NamedTruth(name="next_position", level=3, kind=_PLACE, unit="m", tolerance=1.0,
          of=_pose_ahead,
          meaning="where it is after 5 s at these velocities, in `map`"),
    NamedTruth(name="next_heading", level=3, kind=_BEARING, unit="deg", tolerance=30.0, in_map=True,
          of=lambda it: _degrees(_ahead(it, AHEAD_S).theta),
          meaning="where it faces after 5 s at these velocities, as `heading`"),
    NamedTruth(name="next_collision", level=3, kind=_CHOICE, unit="", tolerance=0.0,
          words=("yes", "no"), of=_touches,
          meaning="whether it touches an obstacle within 5 s at these velocities"),
)  # fmt: skip

TRUTHS: Mapping[str, NamedTruth] = MappingProxyType({each.name: each for each in _ROWS})
"""All truths by name."""


def rounded(value: Value) -> Value:
    """A truth with as many digits as a journal keeps."""
    if isinstance(value, float):
        return round(value, 4)
    return (round(value[0], 4), round(value[1], 4)) if isinstance(value, tuple) else value


def with_moving(moments: Sequence[Moment | None]) -> list[Moment | None]:
    """The moments of all robots, each with the number of those that move."""
    count = sum(each is not None and each.moves for each in moments)
    return [each and dataclasses.replace(each, robots_moving=count) for each in moments]
