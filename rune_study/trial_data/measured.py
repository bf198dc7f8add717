"""From recordings to the data that metrics take."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from hub.errors import CodecError
from hub.gcm.mapping import MAP, PointKind
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.vision import CAMERA_STATE
from hub.values import dataclass
from rune_study.metrics.awareness import Query
from rune_study.metrics.coverage import seen_cells
from rune_study.metrics.effectiveness import Signal, driven, signal
from rune_study.metrics.latency import motion_to_photon
from rune_study.metrics.map_quality import middles
from rune_study.metrics.trial import (
    Contacts,
    Motion,
    Questionnaires,
    RobotData,
    Secondary,
    Travel,
    TrialData,
)
from rune_study.metrics.trial_time import TrialTime
from rune_study.metrics.victims import Mark
from rune_study.statistics.arrays import Flags, Floats
from rune_study.trial_data.operator import OperatorInputs, frames_shown, inputs_of
from rune_study.trial_data.sightings import marks_of, pan_of
from rune_study.trial_data.track import Track, track_of
from rune_study.trial_data.trial_log import TrialLog
from rune_study.trial_data.truth import Truth
from rune_tui.model.own_records import RUNE_LINK, InputOutcome

Place = tuple[float, float]
NEW_AREA, DRIVEN = "new_area", "driven"
EFFECTIVENESS = (NEW_AREA, DRIVEN)
"""Names of the progress that is task effectiveness."""
_ANSWER_S = 1.0
"""An input that changes the motion of the robot does so within this time [s]."""
_CHANGE = 0.02
"""Change of velocity that is seen [m/s, rad/s]."""
_OCCUPIED = 65
"""Share from which on a cell of a map is occupied [%], as in ROS 2."""
_LOOK_S = 0.5
"""The camera's view counts as often as this [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What belongs to a trial besides its recordings.

    Attributes:
        time: Its begin, end and pauses [s of the log].
        truth: The arena; None: it is not known, as in the real world.
        effectiveness: Which progress is task effectiveness.
        queries: Queries of freezes with their answers; None: there were none.
        secondary: The secondary task; None: there was none.
        answers: Of the questionnaires after it.
    """

    time: TrialTime
    truth: Truth | None = None
    effectiveness: str = NEW_AREA
    queries: tuple[Query, ...] | None = None
    secondary: Secondary | None = None
    answers: Questionnaires = Questionnaires()


def trial_data(logs: Mapping[str, TrialLog], around: Surroundings) -> TrialData:
    """The data of a trial; what was not recorded is left out.

    Args:
        logs: The log of each robot, by its name in the layout; each has the console's records too.
        around: What belongs to the trial besides.
    """
    truth = around.truth
    seen = np.zeros_like(truth.grid.blocked) if truth is not None else None
    robots: list[RobotData] = []
    marks: list[Mark] = []
    marked: list[Floats] = []
    photons: list[Floats] = []
    for role, log in logs.items():
        robot = _name_in(log, role, logs)
        track = track_of(log, robot)
        progress = _progress(log, robot, track, around, seen)
        inputs = inputs_of(log)
        robots.append(_robot(log, (role, robot), track, progress, inputs, around.time))
        marks += _marks(log, robot, track, around.time)
        marked += _marked(log, robot, track)
        photons.append(_photons(log, role, track, inputs))
    return TrialData(
        length=around.time.length,
        robots=tuple(robots),
        inputs_known=any(log.has_console for log in logs.values()),
        marks=tuple(marks),
        victims=truth.victims if truth is not None else None,
        seen=seen,
        reachable=truth.reachable if truth is not None else None,
        marked=np.concatenate(marked) if marked and truth is not None else None,
        surface=truth.surface if truth is not None else None,
        photons=np.concatenate(photons) if any(map(len, photons)) else None,
        queries=around.queries,
        secondary=around.secondary,
        questionnaires=around.answers,
    )


def roles_of(log: TrialLog) -> list[str]:
    """Names of the robots in the console's layout, in its order; none without its records."""
    return list(dict.fromkeys(link.robot for _, link in log.own(RUNE_LINK)))


def _name_in(log: TrialLog, role: str, roles: Collection[str]) -> str:
    """The robot's name at its own hub, which has more of it than the console."""
    return next((robot for robot in log.robots if robot not in roles), role)


def _robot(
    log: TrialLog,
    names: tuple[str, str],
    track: Track,
    progress: Signal | None,
    inputs: OperatorInputs,
    time: TrialTime,
) -> RobotData:
    role, robot = names
    pan_times, pans = pan_of(log, robot)
    moments = time.moments(track.times)
    moved = len(track.times) > 0
    pan = np.interp(track.times, pan_times, pans) if len(pan_times) else None
    return RobotData(
        name=role,
        inputs=_within(inputs.by_robot.get(role), time),
        selections=_within(inputs.selections.get(role), time),
        held=_spans_within(inputs.held.get(role), time),
        progress=progress,
        travel=Travel(x=track.x, y=track.y) if moved else None,
        motion=Motion(times=moments, linear=track.linear, angular=track.angular, pan=pan)
        if moved
        else None,
        keys=_steering(inputs, role, time),
        contacts=Contacts(
            times=moments,
            counts=track.contacts.astype(float),
            bumpers=track.bumpers,
            linear=track.linear,
        )
        if track.true
        else None,
    )


def _steering(inputs: OperatorInputs, role: str, time: TrialTime) -> Signal | None:
    times, values = inputs.steering(role)
    return signal(time.moments(times), values) if len(times) else None


def _photons(log: TrialLog, role: str, track: Track, inputs: OperatorInputs) -> Floats:
    """Motion to photon of each input that set the robot in another motion [s] (n,)."""
    begins = np.array(
        [
            time
            for time, record in inputs.inputs
            if time >= 0.0
            and record.robot == role
            and record.pressed
            and not record.repeat
            and record.outcome is InputOutcome.SENT
        ]
    )
    if not track.true or not len(begins):
        return np.zeros(0)
    answered = np.array([_answered(track, begin) for begin in begins])
    moved = np.isfinite(answered)
    taken, shown = frames_shown(log, role)
    return motion_to_photon(begins[moved], answered[moved], taken, shown)


def _answered(track: Track, begin: float) -> float:
    """When a robot's motion changed after an input [s]; NaN: within `_ANSWER_S` it did not."""
    first, last = np.searchsorted(track.times, (begin, begin + _ANSWER_S))
    if first >= last:
        return math.nan
    here = slice(first, last)
    changed = np.abs(track.linear[here] - track.linear[first]) > _CHANGE
    changed |= np.abs(track.angular[here] - track.angular[first]) > _CHANGE
    return float(track.times[here][np.argmax(changed)]) if changed.any() else math.nan


def _marked(log: TrialLog, robot: str, track: Track) -> list[Floats]:
    """Middles of the occupied cells of the robot's last map, in the arena's frame [m]."""
    message = log.last(robot, MAP)
    if message is None:
        return []
    try:
        grid = OccupancyMap.of(message)
    except CodecError:
        return []
    found = middles(grid.cells >= _OCCUPIED, grid.resolution, grid.origin_x, grid.origin_y)
    place = _map_in_arena(log, robot, track)
    return [np.array([place(x, y) for x, y in found.tolist()], float).reshape(-1, 2)]


def _within(times: Floats | None, time: TrialTime) -> Floats:
    """Those of some times that are in the trial, in its own time."""
    if times is None:
        return np.zeros(0)
    return time.moments(times[time.during(times)])


def _spans_within(spans: Floats | None, time: TrialTime) -> Floats:
    """Those parts of some spans that are in the trial, in its own time."""
    if spans is None:
        return np.zeros((0, 2))
    moments = time.moments(spans)
    return moments[moments[:, 1] > moments[:, 0]]


def _progress(
    log: TrialLog, robot: str, track: Track, around: Surroundings, seen: Flags | None
) -> Signal | None:
    """Progress so far; what the robot's camera saw is added to `seen`."""
    if not len(track.times):
        return None
    looks = _Looks.of(log, robot, track)
    area = _new_area(looks, around, seen) if seen is not None and track.true else None
    if around.effectiveness == NEW_AREA:
        return area
    return Signal(times=around.time.moments(track.times), values=driven(track.x, track.y))


@dataclass(frozen=True, slots=True)
class _Looks:
    """Where the camera was, every `_LOOK_S`; n looks."""

    times: Floats
    x: Floats
    y: Floats
    heading: Floats
    width: float

    @classmethod
    def of(cls, log: TrialLog, robot: str, track: Track) -> _Looks:
        times = np.arange(track.times[0], track.times[-1] + _LOOK_S, _LOOK_S)
        index = np.minimum(np.searchsorted(track.times, times), len(track.times) - 1)
        pan_times, pans = pan_of(log, robot)
        heading = track.heading[index]
        if len(pan_times):
            heading = heading + np.interp(times, pan_times, pans)
        states = (state for _, state in log.values(robot, CAMERA_STATE))
        first = next(states, None)
        width = first.horizontal_fov if first is not None else 0.0
        return cls(times, track.x[index], track.y[index], heading, width)


def _new_area(looks: _Looks, around: Surroundings, seen: Flags) -> Signal | None:
    """Ground that this robot was the first to see [m^2]."""
    if around.truth is None or looks.width <= 0.0:
        return None
    grid = around.truth.grid
    areas = []
    for x, y, heading in zip(looks.x, looks.y, looks.heading, strict=True):
        seen |= seen_cells(grid, [x], [y], [heading], width=looks.width)
        areas.append(float(np.count_nonzero(seen & around.truth.reachable)))
    values = np.array(areas) * grid.resolution**2
    return Signal(times=around.time.moments(looks.times), values=values)


def _marks(log: TrialLog, robot: str, track: Track, time: TrialTime) -> Sequence[Mark]:
    """Marks of victims, in the arena's frame where the truth is known."""
    place = _map_in_arena(log, robot, track)
    found = []
    for moment, point in marks_of(log, robot):
        if point.kind is PointKind.VICTIM and math.isfinite(point.x) and math.isfinite(point.y):
            x, y = place(point.x, point.y)
            found.append(Mark(time=float(time.moments([moment])[0]), x=x, y=y))
    return found


def _map_in_arena(log: TrialLog, robot: str, track: Track) -> Callable[[float, float], Place]:
    """Turns places in `map` into places in the arena: both are known when the track begins."""
    first = next(log.values(robot, ROBOT_STATE), None)
    if not track.true or first is None:
        return lambda x, y: (x, y)
    moment, state = first
    index = min(int(np.searchsorted(track.times, moment)), len(track.times) - 1)
    turn = float(track.heading[index]) - state.theta
    cosine, sine = math.cos(turn), math.sin(turn)
    left = float(track.x[index]) - (cosine * state.x - sine * state.y)
    down = float(track.y[index]) - (sine * state.x + cosine * state.y)
    return lambda x, y: (left + cosine * x - sine * y, down + sine * x + cosine * y)
