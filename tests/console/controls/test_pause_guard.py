"""Keys typed while the console was stopped do not count."""

from __future__ import annotations

from rune_tui.controls.pause_guard import PAUSE_S, STALE_S, PauseGuard


def test_ordinary_ticks_are_no_stall() -> None:
    guard = PauseGuard()
    assert not any(guard.paused(tick * 0.05) or guard.is_stale(tick * 0.05) for tick in range(100))


def test_the_first_look_is_no_stall() -> None:
    assert not PauseGuard().paused(1000.0)


def test_after_a_pause_keys_are_old_for_a_while() -> None:
    guard = PauseGuard()
    guard.paused(0.0)
    woken = PAUSE_S + 5.0
    assert guard.paused(woken)
    assert guard.is_stale(woken)
    assert guard.is_stale(woken + STALE_S - 0.001)
    assert not guard.is_stale(woken + STALE_S)


def test_a_pause_is_reported_once() -> None:
    guard = PauseGuard()
    guard.paused(0.0)
    assert [guard.paused(now) for now in (5.0, 5.01, 5.06)] == [True, False, False]
