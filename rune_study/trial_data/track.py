"""Where a robot was and how it moved, as arrays."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.ground_truth import GROUND_TRUTH
from hub.gcm.navigation import ROBOT_STATE
from hub.values import dataclass
from rune_study.trial_data.trial_log import TrialLog

_Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Track:
    """A robot's motion, by time; n moments.

    Attributes:
        times: When [s of the trial] (n,).
        x: Position [m] (n,), in the arena's frame if `true`, else in `map`.
        y: Position [m] (n,).
        heading: [rad] (n,).
        linear: Forward velocity [m/s] (n,).
        angular: Turn rate [rad/s] (n,).
        bumpers: Bits of the pressed bumpers (n,).
        contacts: Number of collisions since the start (n,); all 0 if not `true`.
        true: Whether it is the truth of a simulator; else what the robot believes.
    """

    times: _Floats
    x: _Floats
    y: _Floats
    heading: _Floats
    linear: _Floats
    angular: _Floats
    bumpers: npt.NDArray[np.int64]
    contacts: npt.NDArray[np.int64]
    true: bool = False

    @property
    def travelled(self) -> float:
        """Length of the way [m]."""
        return float(np.hypot(np.diff(self.x), np.diff(self.y)).sum()) if len(self.x) > 1 else 0.0


def track_of(log: TrialLog, robot: str) -> Track:
    """A robot's track: the truth of its simulator if that was recorded, else its own pose."""
    states = [
        (time, state.x, state.y, state.theta, state.linear, state.angular, state.bumpers)
        for time, state in log.values(robot, ROBOT_STATE)
    ]
    own = np.array(states, float).reshape(-1, 7).T
    truths = [
        (time, truth.x, truth.y, truth.theta, truth.linear, truth.angular, truth.contacts)
        for time, truth in log.values(robot, GROUND_TRUTH)
    ]
    times, x, y, heading, linear, angular, last = (
        np.array(truths, float).reshape(-1, 7).T if truths else own
    )
    bumpers = _held(own[0], own[6], times)
    contacts = last.astype(np.int64) if truths else np.zeros_like(bumpers)
    return Track(times, x, y, heading, linear, angular, bumpers, contacts, true=bool(truths))


def _held(times: _Floats, values: _Floats, at: _Floats) -> npt.NDArray[np.int64]:
    """The last values at or before these times; 0 before the first."""
    if not len(times):
        return np.zeros(len(at), np.int64)
    index = np.searchsorted(times, at, "right") - 1
    return np.where(index >= 0, values[np.maximum(index, 0)], 0).astype(np.int64)
