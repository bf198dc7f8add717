"""Marks that the operator set, and where the camera looked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.mapping import INTEREST_POINTS, InterestPoint
from hub.gcm.vision import CAMERA_STATE
from rune_study.trial_data.trial_log import TrialLog

_Floats = npt.NDArray[np.float64]


def marks_of(log: TrialLog, robot: str) -> list[tuple[float, InterestPoint]]:
    """The marks that are there at the end, each with its first time [s of the trial]."""
    first: dict[int, float] = {}
    last: dict[int, InterestPoint] = {}
    for time, points in log.values(robot, INTEREST_POINTS):
        last = {point.number: point for point in points.points}
        for number in last:
            first.setdefault(number, time)
    return [(first[number], point) for number, point in sorted(last.items())]


def pan_of(log: TrialLog, robot: str) -> tuple[_Floats, _Floats]:
    """Times (n,) [s of the trial] and pan angles (n,) [rad] of the main camera."""
    found = [(time, state.pan) for time, state in log.values(robot, CAMERA_STATE)]
    times, pans = np.array(found, float).reshape(-1, 2).T
    return times, pans
