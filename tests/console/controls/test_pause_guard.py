"""Keys typed while the console was stopped do not count."""

from __future__ import annotations

from rune_tui.controls.pause_guard import DEAF_S, STALL_S, StallGuard


def test_ordinary_ticks_are_no_stall() -> None:
    guard = StallGuard()
    assert not any(guard.stalled(tick * 0.05) or guard.deaf(tick * 0.05) for tick in range(100))


def test_the_first_look_is_no_stall() -> None:
    assert not StallGuard().stalled(1000.0)


def test_after_a_pause_keys_are_old_for_a_while() -> None:
    guard = StallGuard()
    guard.stalled(0.0)
    woken = STALL_S + 5.0
    assert guard.stalled(woken)
    assert guard.deaf(woken)
    assert guard.deaf(woken + DEAF_S - 0.001)
    assert not guard.deaf(woken + DEAF_S)


def test_a_pause_is_reported_once() -> None:
    guard = StallGuard()
    guard.stalled(0.0)
    assert [guard.stalled(now) for now in (5.0, 5.01, 5.06)] == [True, False, False]
