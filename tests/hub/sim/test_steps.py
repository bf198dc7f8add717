"""Time in whole steps."""

from __future__ import annotations

import math

from hub.sim.steps import LONGEST_ADVANCE, WholeSteps
from tests.support.cases import for_each


def test_time_that_is_left_over_counts_in_the_next_call() -> None:
    time = WholeSteps(0.01)
    assert sum(time.due(0.0033) for _ in range(1000)) == 330
    assert [time.due(0.005) for _ in range(4)] == [0, 1, 0, 1]


@for_each(
    ("seconds", "steps"),
    [(math.nan, 0), (-1.0, 0), (0.0, 0), (math.inf, round(LONGEST_ADVANCE / 0.01))],
)
def test_times_that_are_no_numbers_do_no_harm(seconds: float, steps: int) -> None:
    time = WholeSteps(0.01)
    assert time.due(seconds) == steps
    assert time.due(0.01) == 1
