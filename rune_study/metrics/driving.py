"""How the robot was driven: path length, success by path length, camera off centre, commands."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.metrics.effectiveness import driven
from rune_study.statistics.arrays import Floats, floats

STEP_M = 0.05
"""Shorter steps of a path are noise until they add up [m]."""
OFF_CENTRE = math.radians(15.0)
"""A camera that looks farther to a side is off centre [rad]; exactly this is not."""
MOVES_MPS, TURNS_RADPS = 0.05, 0.1
"""Above one of these speeds the robot drives."""
STICK_MOVE = 0.05
"""A stick that moves more, as a share of its travel, says a new intention."""


def path_length(x: npt.ArrayLike, y: npt.ArrayLike, step: float = STEP_M) -> float:
    """Length of a path along samples that are at least `step` apart, and on to the last one [m].

    Args:
        x: Positions [m], shape (n,); those that are not finite are left out.
        y: The same.
        step: Shortest step that counts at once [m].
    """
    places = np.column_stack((floats(x, "x"), floats(y, "y")))
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places):
        return 0.0
    length = driven(places[:, 0], places[:, 1], step)
    last = int(np.searchsorted(length, length[-1]))  # where the last step that counts ended
    return float(length[-1] + math.dist(places[last], places[-1]))


def path_ratio(done: float, shortest: float, *, arrived: bool) -> float:
    """Path that was driven over the shortest one; NaN if the goal was not reached.

    Args:
        done: Length of the path [m].
        shortest: Length of the shortest one [m].
        arrived: Whether the goal was reached.
    """
    return done / shortest if arrived and shortest > 0.0 else math.nan


def success_by_path_length(done: float, shortest: float, *, arrived: bool) -> float:
    """SPL: 0 without success, else the shortest path over the longer of both, at most 1.

    P. Anderson et al., On Evaluation of Embodied Navigation Agents, 2018.

    Args:
        done: Length of the path [m].
        shortest: Length of the shortest one [m]; NaN: SPL is NaN, unless the goal was not reached.
        arrived: Whether the goal was reached.

    Raises:
        DataError: A length is negative.
    """
    if not arrived:
        return 0.0
    if shortest < 0.0 or done < 0.0:
        text = f"a path is not shorter than 0 m, but they are {shortest:g} m and {done:g} m"
        raise DataError(text)
    longer = max(shortest, done)
    return shortest / longer if longer > 0.0 else 1.0


def camera_off_centre(
    times: npt.ArrayLike,
    pan: npt.ArrayLike,
    linear: npt.ArrayLike,
    angular: npt.ArrayLike,
    until: float,
    limit: float = OFF_CENTRE,
) -> float:
    """Share of the driving time in which the camera looks to a side; NaN if it never drives.

    Args:
        times: Ascending [s], shape (n,); each sample holds up to the next one.
        pan: Of the camera against the robot [rad], shape (n,).
        linear: Forward speed [m/s], shape (n,).
        angular: Rate of turn [rad/s], shape (n,).
        until: End of the trial [s].
        limit: Farthest pan that is centred [rad].

    Raises:
        DataError: Lengths differ, or times do not ascend.
    """
    at, pans = floats(times, "times"), floats(pan, "pan")
    speeds, turns = floats(linear, "linear"), floats(angular, "angular")
    widths = np.diff(np.append(at, until))
    if not len(at) == len(pans) == len(speeds) == len(turns) or (widths < 0.0).any():
        text = "the camera needs one pan and two speeds for each ascending time before the end"
        raise DataError(text)
    drives = (np.abs(speeds) > MOVES_MPS) | (np.abs(turns) > TURNS_RADPS)
    drives &= np.isfinite(pans)
    total = float(widths[drives].sum())
    aside = drives & (np.abs(pans) > limit + 1e-9)
    return float(widths[aside].sum()) / total if total > 0.0 else math.nan


def stick_moves(times: npt.ArrayLike, values: npt.ArrayLike, least: float = STICK_MOVE) -> Floats:
    """Times at which a stick says a new intention: it left the last one by more than `least` [s].

    Args:
        times: Ascending [s], shape (n,).
        values: Of one axis, as shares of its travel from -1 to 1, shape (n,). Before, it is 0.
        least: Moves up to this are noise.
    """
    at, values_at = floats(times, "times"), floats(values, "values")
    moves, last = [], 0.0
    for time, value in zip(at.tolist(), values_at.tolist(), strict=True):
        if abs(value - last) > least + 1e-9:
            moves.append(time)
            last = value
    return np.array(moves)
