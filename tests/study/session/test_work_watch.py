"""When a robot works, seen while it happens."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from rune_study.session.work_watch import WorkWatch

PERIOD_S = 0.05


def watched(*parts: tuple[float, float], share: float = 0.5) -> float:
    """How long a robot has been low after parts of a duration [s] and a speed [m/s] each."""
    watch, time, way = WorkWatch(share), 0.0, 0.0
    for seconds, speed in parts:
        for _ in range(round(seconds / PERIOD_S)):
            time += PERIOD_S
            way += speed * PERIOD_S
            watch.follow(time, way)
    return watch.low_for(time)


@pytest.mark.parametrize(
    ("parts", "low"),
    [
        ([(20.0, 0.4)], 0.0),
        ([(20.0, 0.4), (5.0, 0.0)], 4.5),  # half of the window is still fast
        ([(20.0, 0.4), (5.0, 0.1)], 4.4),  # it creeps, and does not stand
        ([(20.0, 0.4), (5.0, 0.3)], 0.0),
        ([(20.0, 0.4), (5.0, 0.0), (2.0, 0.4)], 0.0),
        ([(5.0, 0.0)], 5.0),  # it never moved
    ],
)
def test_a_robot_is_low_while_it_is_slower_than_a_share_of_its_usual_speed(
    parts: Sequence[tuple[float, float]], low: float
) -> None:
    assert watched(*parts) == pytest.approx(low, abs=0.2)


def test_the_share_decides() -> None:
    assert watched((20.0, 0.4), (5.0, 0.1), share=0.2) == 0.0
