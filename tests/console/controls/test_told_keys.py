"""Which keys count as held on a terminal that reports releases."""

from __future__ import annotations

from rune_tui.controls.events import ControlEvent
from rune_tui.controls.keyboard import KeyboardHold
from tests.console.controls.test_keyboard import (
    DELAY,
    RATE,
    release,
    reported_press,
)
from tests.support.cases import for_each


def repeating(key: str) -> tuple[ControlEvent, ...]:
    return (ControlEvent(name=key, pressed=True, repeat=True),)


def answering(keyboard: KeyboardHold, start: float, end: float) -> tuple[ControlEvent, ...]:
    """What ends while the terminal answers and tells of no key; looked at 100 times a second."""
    ended: tuple[ControlEvent, ...] = ()
    for number in range(round((end - start) * 100) + 1):
        keyboard.heard(start + number / 100)
        ended += keyboard.expire(start + number / 100)
    return ended


def told_down(keyboard: KeyboardHold, key: str, start: float, end: float, rate: float) -> float:
    """A key goes down and repeats; returns when it did last."""
    keyboard.down(key, start, repeat=False)
    last = start
    for number in range(round((end - start - DELAY) / rate) + 1):
        last = start + DELAY + number * rate
        assert answering(keyboard, last - 0.01, last - 0.01) == ()
        assert keyboard.down(key, last, repeat=True) == repeating(key)
    return last


@for_each(("rate", "silence"), [(0.033, 0.6), (0.2, 0.6), (0.4, 1.0), (1.8, 4.5), (2.5, 5.0)])
def test_a_key_that_repeated_and_falls_silent_is_up_though_no_release_was_told(
    rate: float, silence: float
):
    keyboard = KeyboardHold()
    last = told_down(keyboard, "w", 0.0, 6.0, rate)
    assert answering(keyboard, last, last + silence - 0.02) == ()
    assert answering(keyboard, last + silence - 0.01, last + silence + 0.02) == (release("w"),)
    assert not keyboard.needs_answers
    (event,) = keyboard.down("w", 20.0, repeat=True)
    assert event.must_release_first


def test_a_key_whose_repeats_another_one_took_is_held_with_it_and_after_it():
    keyboard = KeyboardHold()
    last = told_down(keyboard, "w", 0.0, 2.0, RATE)
    last = told_down(keyboard, "a", last, 12.0, RATE)
    assert keyboard.held == ("w", "a")
    assert keyboard.up("a", last) == (release("a"),)
    assert answering(keyboard, last, last + 4.9) == ()
    assert keyboard.held == ("w",)
    assert answering(keyboard, last + 4.9, last + 5.1) == (release("w"),)


def test_a_key_that_repeats_on_after_another_one_moved_ends_with_its_repeats():
    keyboard = KeyboardHold()
    keyboard.down("a", 0.0, repeat=False)
    last = told_down(keyboard, "w", 0.1, 2.0, RATE)
    keyboard.up("a", last)
    keyboard.down("w", last + RATE, repeat=True)
    assert answering(keyboard, last, last + 0.6) == ()
    assert answering(keyboard, last + 0.6, last + 0.7) == (release("w"),)


def test_a_key_that_never_repeats_is_held_for_as_long_as_keys_move():
    keyboard = KeyboardHold()
    keyboard.down("w", 0.0, repeat=False)
    for number in range(5):
        assert answering(keyboard, number * 4.0, number * 4.0 + 4.0) == ()
        keyboard.down("j", number * 4.0 + 4.0, repeat=False)
        keyboard.up("j", number * 4.0 + 4.0)
    assert keyboard.held == ("w",)
    assert answering(keyboard, 20.0, 24.9) == ()
    assert answering(keyboard, 24.9, 25.1) == (release("w"),)


@for_each("key", ["left_super", "right_super", "super+w", "super+tab"])
def test_what_window_managers_take_ends_what_is_held(key: str):
    keyboard = KeyboardHold()
    keyboard.down("w", 0.0, repeat=False)
    assert keyboard.down(key, 0.1, repeat=False) == (release("w"), reported_press(key))
    (event,) = keyboard.down("w", 0.2, repeat=True)
    assert event.must_release_first


def test_a_key_whose_release_is_told_is_held_until_then():
    keyboard = KeyboardHold()
    assert keyboard.down("w", 0.0, repeat=False) == (reported_press("w"),)
    answering(keyboard, 0.0, 0.5)
    for number in range(300):
        moment = 0.5 + number * RATE
        assert keyboard.down("w", moment, repeat=True) == repeating("w")
        keyboard.heard(moment)
    assert keyboard.needs_answers
    assert keyboard.up("w", 10.5) == (release("w"),)
    assert keyboard.up("w", 10.5) == ()
    assert not keyboard.needs_answers
    assert keyboard.held == ()


def test_a_repeat_of_another_key_keeps_the_first_one_held():
    keyboard = KeyboardHold()
    keyboard.down("w", 0.0, repeat=False)
    keyboard.down("a", 0.1, repeat=False)
    for number in range(60):
        assert keyboard.down("a", 0.6 + number * RATE, repeat=True) == repeating("a")
    assert keyboard.held == ("w", "a")


def test_a_terminal_that_falls_silent_holds_nothing_and_drives_only_when_pressed_anew():
    keyboard = KeyboardHold()
    keyboard.down("w", 0.0, repeat=False)
    keyboard.heard(1.0)
    assert keyboard.expire(1.59) == ()
    assert keyboard.expire(1.61) == (release("w"),)
    keyboard.heard(5.0)
    (event,) = keyboard.down("w", 5.0, repeat=True)
    assert (event.must_release_first, event.repeat) == (True, True)
    assert keyboard.held == ()
    assert keyboard.up("w", 5.1) == ()
    assert keyboard.down("w", 6.0, repeat=False) == (reported_press("w"),)


def test_what_stayed_down_when_all_was_let_go_drives_again_only_when_pressed_anew():
    keyboard = KeyboardHold()
    keyboard.down("w", 0.0, repeat=False)
    assert keyboard.release_all(0.1) == (release("w"),)
    (event,) = keyboard.down("w", 9.0, repeat=True)
    assert (event.must_release_first, event.repeat) == (True, True)
    # Its release went to another window, so the next that is heard of it is a press.
    assert keyboard.down("w", 20.0, repeat=False)[-1] == reported_press("w")


def test_a_press_without_the_release_before_it_releases_first():
    keyboard = KeyboardHold()
    keyboard.down("w", 0.0, repeat=False)
    assert keyboard.down("w", 0.2, repeat=False) == (release("w"), reported_press("w"))
