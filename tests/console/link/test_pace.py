"""How often is asked: nothing grows old in the link, and nothing more than one waits needlessly."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.link.pace import LEAST_S, MAX_OPEN, Pace


class Link:
    """A round trip and a server that takes its time for each answer, one after the other."""

    def __init__(self, round_trip: float, service: float) -> None:
        self.round_trip, self.service = round_trip, service
        self.free = 0.0

    def answer(self, asked: float) -> float:
        """When the answer to what is asked now comes [s]."""
        self.free = max(self.free, asked + self.round_trip) + self.service
        return self.free


def run(pace: Pace, link: Link, seconds: float) -> list[tuple[float, float]]:
    """Ask as `Requester` does; the times at which was asked and answered [s]."""
    done: list[tuple[float, float]] = []
    under_way: list[tuple[float, float]] = []
    now, due = 0.0, 0.0
    while now < seconds:
        while under_way and under_way[0][1] <= now:
            asked, came = under_way.pop(0)
            due += pace.answered(asked, came, link.round_trip)[1]
            done.append((asked, came))
        if now >= due and len(under_way) < pace.window:
            under_way.append((now, link.answer(now)))
            due = max(due, now - 0.02) + pace.spacing
        now += 0.001
    return done


@given(st.floats(0.0, 1.0), st.floats(0.001, 0.4), st.floats(0.0, 0.3))
def test_answers_do_not_wait_in_the_link_and_the_rate_is_what_it_carries(
    round_trip: float, service: float, interval: float
) -> None:
    pace = Pace()
    pace.interval = interval
    done = run(pace, Link(round_trip, service), 10.0)
    later = [came - asked for asked, came in done if asked > 5.0]
    assert max(later) < round_trip + 2.0 * service + 0.01
    period = max(interval, LEAST_S, 1.1 * service)
    if pace.window < MAX_OPEN:
        best = max(period, round_trip + service) if pace.window == 1 else period
        assert len(done) > 0.8 * (10.0 - round_trip) / (best + 0.002) - 2


def test_what_a_link_measured_too_little_of_runs_off() -> None:
    pace, link = Pace(), Link(0.04, 0.02)
    run(pace, link, 2.0)
    link.service, link.free = 0.2, 0.0
    done = run(pace, link, 10.0)
    assert done[-1][1] - done[-1][0] < 0.04 + 0.2 + 0.05


@pytest.mark.parametrize("round_trip", [math.nan, 0.0005, 0.005])
def test_near_the_robot_one_is_under_way(round_trip: float) -> None:
    pace = Pace()
    pace.interval = 0.066
    pace.answered(0.0, 0.05, round_trip)
    assert pace.window == 1


def test_over_a_long_round_trip_as_many_are_under_way_as_the_rate_needs() -> None:
    pace = Pace()
    pace.interval = 0.1
    pace.answered(0.0, 0.42, 0.4)
    assert pace.window == 6
    assert len(run(pace, Link(0.4, 0.02), 10.0)) > 90
    pace.interval = 1.0
    assert pace.window == 1


def test_what_did_not_come_is_waited_for_longer_the_next_time() -> None:
    pace = Pace()
    assert pace.timeout == 1.0
    for _ in range(9):
        pace.timed_out()
    assert pace.timeout == 8.0
    pace.answered(0.0, 0.5, 0.1)
    assert pace.timeout == 2.0
