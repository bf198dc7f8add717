"""Restarts: at once at first, then ever later, then no more; over random histories."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hub.robomon.policy import FIRST_DELAY_S, LONGEST_DELAY_S, RestartPolicy


def test_first_restart_is_soon_and_the_next_ones_are_later() -> None:
    policy = RestartPolicy(4, 60.0)
    delays = []
    for end in range(4):
        start = policy.ended(float(end))
        assert start is not None
        delays.append(start - end)
    assert delays[0] == FIRST_DELAY_S
    assert delays == sorted(delays)
    assert delays[0] < delays[-1]


def test_gives_up_after_the_limit() -> None:
    policy = RestartPolicy(2, 60.0)
    assert [policy.ended(now) is None for now in (0.0, 1.0, 2.0)] == [False, False, True]


def test_old_crashes_are_forgotten() -> None:
    policy = RestartPolicy(2, 60.0)
    assert all(policy.ended(now) == now + FIRST_DELAY_S for now in (0.0, 61.0, 122.0, 183.0))


@given(st.lists(st.floats(0.0, 30.0), max_size=100), st.integers(0, 10), st.floats(1.0, 100.0))
def test_never_restarts_more_often_than_allowed(
    pauses: list[float], limit: int, window: float
) -> None:
    policy = RestartPolicy(limit, window)
    now, restarts = 0.0, []
    for pause in pauses:
        now += pause
        start = policy.ended(now)
        if start is not None:
            assert now < start <= now + LONGEST_DELAY_S
            restarts.append(now)
        recent = [time for time in restarts if time > now - window]
        assert len(recent) <= limit
