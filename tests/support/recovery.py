"""Whether metrics find the truth of a model: trials of it, measured like any other trial."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from hub.values import dataclass
from rune_study.estimate import Estimate
from rune_study.metrics.registry import measure
from rune_study.metrics.trial import MeasureSpec
from rune_study.simulate.model_data import trial_data
from rune_study.simulate.operator_model import OperatorModel, run


@dataclass(frozen=True, slots=True, kw_only=True)
class Recovery:
    """How well a metric found the truth.

    Attributes:
        metric: The metric.
        truth: What is true of the model.
        trials: Trials that were played.
        known: Trials with a number.
        covered: Trials with an interval that has the truth.
        intervals: Trials with an interval.
        mean: Mean of the numbers; NaN without any.
    """

    metric: str
    truth: float
    trials: int
    known: int
    covered: int
    intervals: int
    mean: float

    @property
    def coverage(self) -> float:
        """Share of the intervals that have the truth; NaN without intervals."""
        return self.covered / self.intervals if self.intervals else float("nan")


def truths(model: OperatorModel) -> dict[str, float]:
    """What is true of a model, by the metric that has to find it."""
    return {"ie_mean": model.interaction_mean, "nt_median": model.tolerance_median}


def measured(
    model: OperatorModel, seeds: Iterable[int], spec: MeasureSpec | None = None
) -> Iterator[dict[str, Estimate]]:
    """All metrics of one trial after another."""
    for seed in seeds:
        yield measure(trial_data(model, run(model, seed)), spec)


def recovery(model: OperatorModel, seeds: Iterable[int]) -> list[Recovery]:
    """How well metrics find the truth of a model, over trials with these seeds."""
    found = list(measured(model, seeds))
    return [
        _recovery(metric, truth, [each[metric] for each in found])
        for metric, truth in truths(model).items()
    ]


def _recovery(metric: str, truth: float, found: list[Estimate]) -> Recovery:
    known = [each for each in found if each.known]
    intervals = [each for each in known if each.has_interval]
    return Recovery(
        metric=metric,
        truth=truth,
        trials=len(found),
        known=len(known),
        covered=sum(each.low <= truth <= each.high for each in intervals),
        intervals=len(intervals),
        mean=float(np.mean([each.value for each in known])) if known else float("nan"),
    )
