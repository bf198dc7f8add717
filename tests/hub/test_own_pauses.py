"""A process notices that it paused, and what came meanwhile does not count."""

from __future__ import annotations

from hub.machine_sleep import MachineSleep
from hub.own_pauses import OwnPauses

LONGEST_S, STALE_S = 0.3, 0.2


def pauses() -> OwnPauses:
    return OwnPauses(LONGEST_S, stale_s=STALE_S)


def test_ordinary_ticks_are_no_pause() -> None:
    made = pauses()
    assert not any(made.look(tick * 0.05) or made.is_stale(tick * 0.05) for tick in range(100))


def test_the_first_look_finds_no_pause() -> None:
    assert pauses().look(1000.0) == 0.0


def test_after_a_pause_input_is_stale_for_a_while() -> None:
    made = pauses()
    made.look(0.0)
    woken = LONGEST_S + 5.0
    assert made.look(woken) == woken
    assert made.is_stale(woken)
    assert made.is_stale(woken + STALE_S - 0.001)
    assert not made.is_stale(woken + STALE_S)


def test_a_pause_is_reported_once() -> None:
    made = pauses()
    made.look(0.0)
    assert [made.look(now) > 0.0 for now in (5.0, 5.01, 5.06)] == [True, False, False]


def test_a_sleep_of_the_machine_is_a_pause_although_the_monotonic_clock_stood_still() -> None:
    slept = [0.0]
    sleep = MachineSleep(lambda: 5.0, lambda: 5.0 + slept[0])
    made = OwnPauses(LONGEST_S, stale_s=STALE_S, sleep=sleep)
    assert made.look(0.0) == made.look(0.05) == 0.0
    slept[0] += 60.0
    assert made.look(0.1) == 60.05
    assert made.is_stale(0.1)
    assert made.look(0.15) == 0.0
