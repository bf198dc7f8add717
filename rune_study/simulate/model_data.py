"""The data of a model's trial, as metrics take them."""

from __future__ import annotations

import numpy as np

from rune_study.metrics.effectiveness import Signal
from rune_study.metrics.trial import RobotData, TrialData
from rune_study.simulate.operator_model import ModelTrial, OperatorModel, ServedRobot

_SAMPLES_HZ = 10.0


def trial_data(model: OperatorModel, trial: ModelTrial) -> TrialData:
    """A trial of a model as the data that metrics take."""
    robots = tuple(
        RobotData(
            name=f"robot {number}",
            inputs=_until(robot.inputs, model.seconds),
            selections=_until(robot.selections, model.seconds),
            progress=_progress(robot, model.seconds),
        )
        for number, robot in enumerate(trial.robots, 1)
    )
    return TrialData(length=model.seconds, robots=robots)


def _until(times: np.typing.NDArray[np.float64], end: float) -> np.typing.NDArray[np.float64]:
    return times[times <= end]


def _progress(robot: ServedRobot, end: float) -> Signal:
    """Seconds at work so far."""
    times = np.arange(0.0, end + 0.5 / _SAMPLES_HZ, 1.0 / _SAMPLES_HZ)
    done = np.zeros(len(times))
    for begin, stop in robot.working:
        done += np.clip(times - begin, 0.0, stop - begin)
    return Signal(times=times, values=done)
