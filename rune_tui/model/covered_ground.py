"""Ground that an obstacle hides from the camera; pure."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from rune_tui.model.robot_ranges import RobotRanges
from rune_tui.model.sightings import Floats

COVERS_M: Final = 1.2
"""Largest range used of a wide beam; a farther echo may come from beside the line [m]."""

_SLACK_M: Final = 0.1
"""Depth of the ground that is shown behind a measured obstacle [m]."""
_STEP_M: Final = 0.2
"""Distance between points of a line, which gives the precision of its end [m]."""
_MOST_STEPS: Final = 256
"""Most points of a line; a longer line has longer steps."""
_GRAIN_M: Final = 0.05
_DIRECTIONS: Final = 120
"""Number of directions around the robot."""
_TURN: Final = math.tau / _DIRECTIONS


def covers_of(ranges: RobotRanges | None) -> tuple[float, ...]:
    """Distance of the visible ground in each direction [m]; inf: no obstacle hides it.

    The directions are equally far apart, and begin straight ahead, counter-clockwise. Empty if
    no obstacle hides any ground. Rounded, so that noise of the sensors is not visible.
    """
    if ranges is None:
        return ()
    of = ranges.of
    hides = np.flatnonzero(np.isfinite(ranges.room) & (~of.wide | (ranges.ranges < COVERS_M)))
    if not len(hides):
        return ()
    covers = np.full(_DIRECTIONS, np.inf)
    away = np.round(np.hypot(ranges.x[hides], ranges.y[hides]) / _GRAIN_M) * _GRAIN_M
    first, last = (_edges(ranges, hides, side) for side in (-1.0, 1.0))
    count = np.clip(last - first + 1, 1, _DIRECTIONS)
    # One row for each direction of each beam.
    rows = np.repeat(np.arange(len(hides)), count)
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    np.minimum.at(covers, (first[rows] + number) % _DIRECTIONS, away[rows])
    return tuple(covers.tolist())


def _edges(ranges: RobotRanges, hides: npt.NDArray[np.intp], side: float) -> npt.NDArray[np.intp]:
    """The direction of an edge of each beam's cone at its end, seen from the robot's origin."""
    of, beams = ranges.of, ranges.of.beams
    turned = beams.bearing[hides] + side * of.half[hides]
    reach = ranges.ranges[hides] * np.cos(beams.elevation[hides])
    x = beams.x[hides] + reach * np.cos(turned)
    y = beams.y[hides] + reach * np.sin(turned)
    middle = np.arctan2(ranges.y[hides], ranges.x[hides])
    # Counted from the middle, so that no edge is a turn away from it.
    aside = (np.arctan2(y, x) - middle + np.pi) % math.tau - np.pi
    directions: npt.NDArray[np.intp] = np.round((middle + aside) / _TURN).astype(np.intp)
    return directions


def covered(points: Floats, covers: tuple[float, ...]) -> npt.NDArray[np.bool_]:
    """Which points of the robot's frame [m] are covered; points of shape (n, 2)."""
    if not covers:
        return np.zeros(len(points), np.bool_)
    away = np.hypot(points[:, 0], points[:, 1])
    turn = 2.0 * np.pi / len(covers)
    bearing = np.nan_to_num(np.arctan2(points[:, 1], points[:, 0]))
    sensor = np.round(bearing / turn).astype(np.intp) % len(covers)
    hidden: npt.NDArray[np.bool_] = away > np.array(covers)[sensor] + _SLACK_M
    return hidden


def uncovered(lines: Floats, covers: tuple[float, ...]) -> Floats:
    """Lines on the ground, broken where they are covered.

    Args:
        lines: Corners in the robot's frame [m], shape (n, 2), a row of NaN between two lines.
        covers: Result of `covers_of`.
    """
    if not covers or len(lines) < 2:
        return lines
    steps = np.diff(lines, axis=0)
    length = np.nan_to_num(np.hypot(steps[:, 0], steps[:, 1]))
    count = np.clip(np.ceil(length / _STEP_M), 1, _MOST_STEPS).astype(np.intp)
    first = np.repeat(np.arange(len(steps)), count)
    share = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    dense = lines[first] + steps[first] * (share / count[first])[:, None]
    # A step into a break or out of it has no length, and begins at its own corner.
    dense[share == 0] = lines[:-1][first[share == 0]]
    dense = np.concatenate((dense, lines[-1:]))
    dense[covered(dense, covers)] = np.nan
    return dense
