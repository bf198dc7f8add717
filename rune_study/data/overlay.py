"""What a map shows of a trial: where robots drove, stayed and bumped, and which victims count."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hub.missions.matching import match
from hub.values import dataclass
from rune_study.metrics.bumps import bump_moments
from rune_study.metrics.trial import RobotData, TrialData
from rune_study.metrics.victims import RADIUS_M
from rune_study.statistics.arrays import Flags, Floats

CELL_M = 0.5
"""Edge of the cells in which time is counted [m]."""
_TOLERANCE_M = 0.04
"""Farthest distance of a path from the one that is drawn [m]."""
_JUMP_M = 1.0
"""Between positions this far apart nothing was driven, such as after a reset [m]."""
_FARTHEST_M = 10_000.0
"""Positions beyond this are damaged data [m]."""
_LONGEST_S = 1.0
"""A position counts as known for at most this time [s]."""

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialOverlay:
    """What a map shows of a trial; all places are in the arena's frame, if the arena is known.

    Attributes:
        participant: Number of the participant.
        trial: Number of the trial.
        code: Code of the condition.
        arena: Name or path of the arena; empty: it is not known.
        paths: Simplified paths of all robots [m], each of shape (n, 2).
        driven: Their length [m].
        bumps: Where robots bumped into something [m], shape (n, 2).
        victims: True places of victims [m], shape (n, 2).
        found: Which victims have a mark, shape (n,).
        false: Marks without a victim [m], shape (n, 2).
        stays: Time in each cell of `CELL_M`, by its column and row from the origin [s].
    """

    participant: int
    trial: int
    code: str
    arena: str
    paths: tuple[Floats, ...]
    driven: float
    bumps: Floats
    victims: Floats
    found: Flags
    false: Floats
    stays: Mapping[Cell, float]


def overlay_of(
    data: TrialData,
    *,
    participant: int,
    trial: int,
    code: str,
    arena: str,
    radius: float = RADIUS_M,
) -> TrialOverlay:
    """What a map shows of a trial.

    Args:
        data: The trial.
        participant: Number of the participant.
        trial: Number of the trial.
        code: Code of the condition.
        arena: Name or path of the arena; empty: it is not known.
        radius: Farthest distance of a mark from its victim [m].
    """
    pieces = [piece for robot in data.robots for piece in _pieces(robot)]
    victims = data.victims if data.victims is not None else np.empty((0, 2))
    marks = [(each.x, each.y) for each in data.marks or () if not each.removed]
    pairs = match(marks, victims, radius)
    found = np.zeros(len(victims), np.bool_)
    found[[each.place for each in pairs]] = True
    used = {each.mark for each in pairs}
    false = [mark for number, mark in enumerate(marks) if number not in used]
    stays: dict[Cell, float] = {}
    for robot in data.robots:
        _add_stays(stays, robot)
    return TrialOverlay(
        participant=participant,
        trial=trial,
        code=code,
        arena=arena,
        paths=tuple(simplified(piece, _TOLERANCE_M) for piece in pieces),
        driven=sum(float(np.hypot(*np.diff(piece, axis=0).T).sum()) for piece in pieces),
        bumps=_places([_bumps(robot) for robot in data.robots]),
        victims=victims,
        found=found,
        false=np.array(false, np.float64).reshape(-1, 2),
        stays=stays,
    )


def simplified(path: Floats, tolerance: float) -> Floats:
    """A path with fewer points, no point of the old one farther away (Douglas and Peucker 1973).

    Args:
        path: Points [m], shape (n, 2).
        tolerance: Farthest distance [m].
    """
    kept = np.zeros(len(path), np.bool_)
    if len(path):
        kept[[0, -1]] = True
    spans = [(0, len(path) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        away = _distances(path[first + 1 : last], path[first], path[last])
        farthest = int(np.argmax(away))
        if away[farthest] > tolerance:
            middle = first + 1 + farthest
            kept[middle] = True
            spans += [(first, middle), (middle, last)]
    return path[kept]


def _distances(points: Floats, begin: Floats, end: Floats) -> Floats:
    """From points (n, 2) to the line between two ends [m] (n,)."""
    along = end - begin
    length = float(along @ along)
    share = np.clip((points - begin) @ along / length, 0.0, 1.0) if length else np.zeros(1)
    away = points - begin - share[:, None] * along
    return np.hypot(away[:, 0], away[:, 1])


def _pieces(robot: RobotData) -> list[Floats]:
    """The path of a robot without jumps; each piece has two points at least."""
    path = _path(robot)
    path = path[_sound(path)]
    jumps = np.flatnonzero(np.hypot(*np.diff(path, axis=0).T) > _JUMP_M) + 1
    return [piece for piece in np.split(path, jumps) if len(piece) > 1]


def _path(robot: RobotData) -> Floats:
    if robot.travel is None:
        return np.empty((0, 2))
    return np.column_stack((robot.travel.x, robot.travel.y))


def _sound(path: Floats) -> Flags:
    """Which points of a path (n, 2) can be true (n,)."""
    return np.asarray((np.abs(path) <= _FARTHEST_M).all(axis=1))


def _bumps(robot: RobotData) -> Floats:
    path, contacts = _path(robot), robot.contacts
    if contacts is None or len(contacts.times) != len(path):
        return np.empty((0, 2))
    places = path[bump_moments(contacts.times, contacts.counts)]
    return places[_sound(places)]


def _add_stays(stays: dict[Cell, float], robot: RobotData) -> None:
    path, motion = _path(robot), robot.motion
    if motion is None or not len(path) or len(motion.times) != len(path):
        return
    seconds = np.clip(np.diff(motion.times, append=motion.times[-1]), 0.0, _LONGEST_S)
    sound = _sound(path)
    places = np.floor(path[sound] / CELL_M).astype(int)
    cells, inverse = np.unique(places, axis=0, return_inverse=True)
    sums = np.bincount(inverse.ravel(), seconds[sound], len(cells))
    for (column, row), time in zip(cells.tolist(), sums.tolist(), strict=True):
        stays[column, row] = stays.get((column, row), 0.0) + time


def _places(parts: list[Floats]) -> Floats:
    return np.concatenate(parts) if parts else np.empty((0, 2))
