"""A model of one operator and N robots, with known interaction times and neglect tolerances.

A robot that was served works for a time of a Weibull distribution, its neglect tolerance; then it
stands until the operator serves it again. The operator serves one robot at a time: selects it,
looks, and presses keys until the end of the service, whose length is log-normal.

| what makes him return | field | what it does to the data |
| --- | --- | --- |
| the robot stands | `notice_s` | the end of its tolerance is seen |
| chance | `check_s` | it is censored, without regard to the robot |
| he foresees the stand | `foresight` | it is censored just before the end: metrics are biased |
| the console kept him away until the stand | `probe_share` | it is seen, also when he foresees it |
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass

_Floats = npt.NDArray[np.float64]
_LEAST_KEYS_S = 0.5
_KEY_PERIOD_S = (0.2, 0.6)
"""Time between two keys of a service, uniform [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatorModel:
    """What is true of an operator and his robots.

    Attributes:
        tolerance_mean: Mean neglect tolerance [s].
        tolerance_shape: Shape of its Weibull distribution.
        interaction_mean: Mean interaction time [s].
        interaction_deviation: Standard deviation of it [s].
        look_s: Time between the selection of a robot and the first key [s].
        notice_s: Time until the operator sees that a robot stands [s].
        check_s: Mean time after which he looks in, independent of the robot [s]; 0 is never.
        foresight: Share of stands that he foresees, to come just before them.
        probe_share: Share of neglects in which the console keeps him away until the stand.
        robots: Number of robots.
        seconds: Length of the trial [s].
    """

    tolerance_mean: float = 25.0
    tolerance_shape: float = 1.5
    interaction_mean: float = 6.0
    interaction_deviation: float = 2.0
    look_s: float = 1.0
    notice_s: float = 2.0
    check_s: float = 0.0
    foresight: float = 0.0
    probe_share: float = 0.0
    robots: int = 1
    seconds: float = 1800.0

    @property
    def tolerance_scale(self) -> float:
        """Scale of the Weibull distribution [s]."""
        return self.tolerance_mean / math.gamma(1.0 + 1.0 / self.tolerance_shape)

    @property
    def tolerance_median(self) -> float:
        """Median neglect tolerance [s]."""
        return float(self.tolerance_scale * math.log(2.0) ** (1.0 / self.tolerance_shape))

    @property
    def attention_demand(self) -> float:
        """Robot attention demand: interaction over interaction and tolerance."""
        return self.interaction_mean / (self.interaction_mean + self.tolerance_mean)

    @property
    def fan_out(self) -> float:
        """Number of robots that one operator can keep at work."""
        return 1.0 / self.attention_demand

    def interaction(self, random: np.random.Generator) -> float:
        """A log-normal interaction time [s]."""
        variance = math.log(1.0 + (self.interaction_deviation / self.interaction_mean) ** 2)
        mean = math.log(self.interaction_mean) - variance / 2.0
        return float(np.exp(random.normal(mean, math.sqrt(variance))))

    def tolerance(self, random: np.random.Generator) -> float:
        """A neglect tolerance of the Weibull distribution [s]."""
        return float(self.tolerance_scale * random.weibull(self.tolerance_shape))


@dataclass(frozen=True, slots=True)
class ServedRobot:
    """What a trial leaves of one robot.

    Attributes:
        inputs: When keys were pressed for it (n,) [s].
        selections: When it was selected (m,) [s].
        working: Begin and end of each time at work (k, 2) [s].
    """

    inputs: _Floats
    selections: _Floats
    working: _Floats

    def rate(self, times: _Floats) -> _Floats:
        """Rate of progress at these times (n,): 1 at work, else 0."""
        rate = np.zeros(len(times))
        for begin, end in self.working:
            rate[(times >= begin) & (times < end)] = 1.0
        return rate


@dataclass(frozen=True, slots=True)
class ModelTrial:
    """What a trial of the model leaves.

    Attributes:
        robots: Each robot's part.
        tolerances: The drawn neglect tolerances, one for each service (n,) [s].
        interactions: The drawn interaction times (n,) [s].
    """

    robots: tuple[ServedRobot, ...]
    tolerances: _Floats
    interactions: _Floats


def run(model: OperatorModel, seed: int) -> ModelTrial:
    """Play a trial; the same seed gives the same trial."""
    return _Play(model, np.random.default_rng(seed)).play()


class _Play:
    """One trial."""

    def __init__(self, model: OperatorModel, random: np.random.Generator) -> None:
        self._model = model
        self._random = random
        self._works_until = np.zeros(model.robots)
        self._inputs: list[list[float]] = [[] for _ in range(model.robots)]
        self._selections: list[list[float]] = [[] for _ in range(model.robots)]
        self._working: list[list[tuple[float, float]]] = [[] for _ in range(model.robots)]
        self._tolerances: list[float] = []
        self._interactions: list[float] = []
        self._away = False  # the console keeps the operator away until the next stand

    def play(self) -> ModelTrial:
        now = 0.0
        while now < self._model.seconds:
            begin, robot = self._next_service(now)
            if robot is None:
                self._away = False
                now = begin
            elif begin >= self._model.seconds:
                break
            else:
                now = self._serve(robot, begin)
        return ModelTrial(
            tuple(
                ServedRobot(
                    np.array(inputs), np.array(selections), np.array(working).reshape(-1, 2)
                )
                for inputs, selections, working in zip(
                    self._inputs, self._selections, self._working, strict=True
                )
            ),
            np.array(self._tolerances),
            np.array(self._interactions),
        )

    def _next_service(self, now: float) -> tuple[float, int | None]:
        """When the next service begins, and its robot; None: nothing to do until then."""
        model = self._model
        standing = np.flatnonzero(self._works_until + model.notice_s <= now)
        if len(standing):
            return now, int(standing[np.argmin(self._works_until[standing])])
        first = int(np.argmin(self._works_until))
        seen = float(self._works_until[first]) + model.notice_s
        if self._away:
            return seen, None
        if self._random.random() < model.foresight:
            ahead = max(0.0, float(self._works_until[first]) - now)
            return now + self._random.uniform(0.0, 1.0) * ahead, first
        if model.check_s:
            back = now + self._random.exponential(model.check_s)
            if back < seen:
                return back, first
        return seen, None

    def _serve(self, robot: int, begin: float) -> float:
        """Serve a robot; returns the end of the service."""
        model = self._model
        took = max(model.interaction(self._random), model.look_s + _LEAST_KEYS_S)
        end = begin + took
        self._selections[robot].append(begin)
        working = self._working[robot]
        if working and working[-1][1] > begin:
            working[-1] = (working[-1][0], begin)
        key = begin + model.look_s
        while key < end:
            self._inputs[robot].append(key)
            key += self._random.uniform(*_KEY_PERIOD_S)
        self._inputs[robot].append(end)
        tolerance = model.tolerance(self._random)
        working.append((begin, end + tolerance))
        self._works_until[robot] = end + tolerance
        self._tolerances.append(tolerance)
        self._interactions.append(took)
        self._away = self._random.random() < model.probe_share
        return end
