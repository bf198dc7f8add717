"""Which keys count as held on a terminal that reports no release."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual.keys import _character_to_key

from rune_tui.controls.events import ControlEvent
from rune_tui.controls.keyboard import KeyboardHold, name_of_key
from tests.support.cases import for_each

DELAY = 0.5


RATE = 0.033


def press(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True, timed=True)


def repeat(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True, repeat=True, timed=True)


def reported_press(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True)


def release(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=False)


def hold_down(keyboard: KeyboardHold, key: str, start: float, repeats: int, rate: float) -> float:
    """Press a key and let it repeat as a keyboard does; returns the time of the last repeat."""
    assert keyboard.press(key, start) == (press(key),)
    for number in range(repeats):
        assert keyboard.press(key, start + DELAY + number * rate) == (repeat(key),)
    return start + DELAY + (repeats - 1) * rate


def assert_drives_when_proven(keyboard: KeyboardHold, key: str, moment: float) -> None:
    """A press after a stop drives when no repeat followed it for long enough."""
    (event,) = keyboard.press(key, moment)
    assert (event.must_release_first, event.repeat) == (True, False)
    assert keyboard.expire(moment + 0.46) == ()
    proven = ControlEvent(name=key, pressed=True, timed=True, proven=True)
    assert keyboard.expire(moment + 0.48) == (proven,)
    assert keyboard.held == (key,)


def assert_held_until(keyboard: KeyboardHold, moment: float, key: str) -> None:
    assert keyboard.expire(moment - 1e-6) == ()
    assert keyboard.expire(moment + 1e-6) == (release(key),)


def test_a_tap_is_released_after_the_first_hold_and_not_before():
    keyboard = KeyboardHold()
    assert keyboard.press("w", 10.0) == (press("w"),)
    assert keyboard.held == ("w",)
    assert_held_until(keyboard, 10.6, "w")
    assert keyboard.held == ()
    assert keyboard.expire(99.0) == ()


def test_the_first_hold_bridges_the_delay_of_the_keyboard():
    keyboard = KeyboardHold()
    hold_down(keyboard, "w", 0.0, 1, RATE)
    assert keyboard.held == ("w",)


@for_each(("rate", "hold"), [(0.033, 0.15), (0.06, 0.15), (0.1, 0.25), (0.2, 0.5), (0.25, 0.6)])
def test_a_repeating_key_holds_for_two_and_a_half_intervals_within_bounds(rate: float, hold: float):
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 4, rate)
    assert_held_until(keyboard, last + hold, "w")


def test_the_first_repeat_alone_measures_nothing():
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 1, RATE)
    assert_held_until(keyboard, last + 0.6, "w")


def test_the_rate_of_one_key_serves_the_next():
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 5, RATE)
    assert keyboard.expire(last + 1.0) == (release("w"),)
    last = hold_down(keyboard, "a", 10.0, 1, RATE)
    assert_held_until(keyboard, last + 0.15, "a")


def test_repeats_that_come_in_bursts_do_not_release_the_key():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    for burst in range(20):
        for number in range(4):
            events = keyboard.press("w", DELAY + burst * 0.16 + number * 0.002)
            assert events == (repeat("w"),)


def driven(keyboard: KeyboardHold, presses: list[float]) -> float:
    """How long a key drives that is typed at these times, looked at every millisecond [s]."""
    moments = {round(moment * 1000) for moment in presses}
    assert keyboard.held == ()
    looks = 0
    for look in range(3000):
        if look in moments:
            for _ in range(presses.count(look / 1000)):
                keyboard.press("w", look / 1000)
        keyboard.expire(look / 1000)
        looks += "w" in keyboard.held
    return looks / 1000


@pytest.mark.parametrize("apart_ms", [0, 1, 5])
@pytest.mark.parametrize("measured", [False, True])
def test_repeats_that_were_held_back_on_the_way_drive_for_two_of_them(
    apart_ms: int, *, measured: bool
):
    keyboard = KeyboardHold()
    if measured:
        hold_down(keyboard, "w", -9.0, 6, RATE)
        keyboard.expire(-1.0)
    burst = [number * apart_ms / 1000 for number in range(60)]
    assert driven(keyboard, burst) == 2 * apart_ms / 1000


def test_a_key_that_was_held_back_on_the_way_drives_when_it_is_pressed_anew():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    assert keyboard.press("w", 0.0) == (repeat("w"),)
    late = dataclasses.replace(repeat("w"), must_release_first=True)
    assert keyboard.press("w", 0.0) == (release("w"), late)
    # It is still down, and repeats at its own rate.
    for number in range(40):
        assert keyboard.press("w", 0.03 + number * RATE) == (late,)
    keyboard.expire(8.0)
    assert_drives_when_proven(keyboard, "w", 9.0)


def test_when_a_key_was_read_counts_and_not_when_the_console_had_time_for_it():
    keyboard = KeyboardHold()
    for number in range(9):
        keyboard.press("w", 1.0, read=number * 0.1)
    assert keyboard.held == ("w",)
    assert_held_until(keyboard, 1.25, "w")


def test_of_uneven_repeats_the_longest_interval_counts():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    for moment in (0.5, 0.6, 0.63, 0.73, 0.76):
        keyboard.press("w", moment)
    assert_held_until(keyboard, 0.76 + 0.25, "w")


def test_a_slow_line_is_forgotten_after_a_few_quick_repeats():
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 3, 0.2)
    for number in range(1, 8):
        keyboard.press("w", last + number * RATE)
    assert_held_until(keyboard, last + 7 * RATE + 0.15, "w")


def test_another_key_leaves_the_held_ones_alone():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    assert keyboard.press("d", 0.1) == (press("d"),)
    assert keyboard.held == ("w", "d")
    assert keyboard.expire(0.65) == (release("w"),)


def test_releases_come_in_the_order_they_were_due():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    keyboard.press("a", 0.01)
    keyboard.press("w", 0.5)
    assert keyboard.expire(9.0) == (release("a"), release("w"))


def test_a_press_after_the_deadline_is_a_release_and_a_new_press():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    keyboard.press("a", 0.0)
    assert keyboard.press("w", 5.0) == (release("a"), release("w"), press("w"))


def test_losing_the_focus_releases_everything_in_the_order_pressed():
    keyboard = KeyboardHold()
    for key in ("w", "d", "up"):
        keyboard.press(key, 0.0)
    assert keyboard.release_all(0.1) == (release("w"), release("d"), release("up"))
    assert (keyboard.held, keyboard.expire(9.0), keyboard.release_all(9.0)) == ((), (), ())


def test_a_key_that_stays_down_when_all_are_let_go_says_so_until_it_was_silent():
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 10, RATE)
    keyboard.release_all(last)
    for number in range(40):
        (event,) = keyboard.press("w", last + 0.3 + number * RATE)
        assert (event.must_release_first, event.repeat) == (True, number > 0)
        assert keyboard.held == ()
    keyboard.expire(last + 0.3 + 39 * RATE + 0.73)
    assert_drives_when_proven(keyboard, "w", last + 0.3 + 39 * RATE + 0.73)


def test_a_key_that_may_have_been_typed_long_ago_says_so_until_it_was_silent():
    keyboard = KeyboardHold()
    for number in range(40):
        (event,) = keyboard.press("w", number * RATE, stale=number < 6)
        assert (event.must_release_first, event.repeat) == (True, number > 0)
        assert event.stale, "it has not been quiet since"
        assert keyboard.held == ()
    keyboard.expire(39 * RATE + 0.73)
    assert_drives_when_proven(keyboard, "w", 39 * RATE + 0.73)


def test_a_key_that_may_have_been_pressed_long_ago_drives_when_it_is_pressed_anew():
    keyboard = KeyboardHold()
    (event,) = keyboard.down("w", 0.0, repeat=False, stale=True)
    assert (event.must_release_first, event.stale) == (True, True)
    (event,) = keyboard.down("w", 0.5, repeat=True)
    assert (event.must_release_first, event.stale) == (True, False)
    assert keyboard.held == ()
    keyboard.up("w", 0.6)
    assert keyboard.down("w", 1.0, repeat=False) == (reported_press("w"),)


def test_no_key_drives_before_the_one_that_may_be_down_was_silent():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    keyboard.release_all(0.1)
    (event,) = keyboard.press("d", 0.2)
    assert event.must_release_first
    assert keyboard.must_release == ("d", "w")
    keyboard.expire(1.31)
    assert keyboard.must_release == ("d", "w")
    keyboard.expire(1.33)
    assert keyboard.must_release == ()
    assert_drives_when_proven(keyboard, "d", 1.4)


def test_the_names_of_a_key_are_one_key():
    keyboard = KeyboardHold()
    assert keyboard.press("plus", 0.0) == (press("+"),)
    assert keyboard.press("+", 0.1) == (repeat("+"),)


@for_each(
    ("key", "character", "name"),
    [
        ("w", "w", "w"),
        ("W", "W", "w"),
        ("plus", "+", "+"),
        ("space", " ", "space"),
        ("enter", "\r", "enter"),
        ("up", None, "up"),
        ("ctrl+c", "\x03", "ctrl+c"),
        ("alt+w", "w", "alt+w"),
        ("shift+w", "W", "w"),
        ("é", "é", "é"),
    ],
)
def test_a_key_of_textual_has_the_name_layouts_use(key: str, character: str | None, name: str):
    assert name_of_key(key, character) == name


def test_every_character_has_one_name_with_or_without_its_text():
    for character in map(chr, range(0x20, 0x7F)):
        textual = _character_to_key(character)
        assert name_of_key(textual, character) == name_of_key(textual, None)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(["press", "expire", "focus"]),
        st.sampled_from("wasd"),
        st.floats(min_value=0.0, max_value=1.0),
    ),
    max_size=60,
)


@given(steps=STEPS)
def test_what_drives_is_what_was_pressed_and_not_released_and_everything_ends_released(
    steps: list[tuple[str, str, float]],
):
    keyboard = KeyboardHold()
    now = 0.0
    down: set[str] = set()
    for action, key, pause in steps:
        now += pause
        if action == "press":
            events = keyboard.press(key, now)
        elif action == "expire":
            events = keyboard.expire(now)
        else:
            events = keyboard.release_all(now)
        for event in events:
            if not event.pressed:
                down.discard(event.name)
            elif not event.must_release_first:
                assert (event.name in down) == event.repeat
                down.add(event.name)
        assert down == set(keyboard.held)
    for event in keyboard.expire(now + 0.6):
        down.discard(event.name)
    assert down == set()
    assert keyboard.held == ()


def test_a_key_that_came_as_text_is_timed_whatever_the_terminal_tells_of_others():
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    keyboard.heard(0.5)
    assert not keyboard.needs_answers
    assert_held_until(keyboard, 0.6, "w")


def test_a_key_that_comes_late_and_all_at_once_is_waited_for_to_go_up():
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 5, RATE)
    keyboard.expire(last + 0.3)
    for number in range(8):
        keyboard.press("w", last + 0.3 + number * 1e-3)
    assert keyboard.held == ()
    assert keyboard.must_release == (), "it is up already, or its next repeats let it drive on"
    keyboard.expire(last + 2.0)
    assert_drives_when_proven(keyboard, "w", last + 3.0)


def after_a_pause(
    pause: float, *, lifted: bool = False, apart: float = 1e-3, meanwhile: str = ""
) -> KeyboardHold:
    """A key was held, and its line paused; what came late, and then, unless it was lifted, live."""
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 30, RATE)
    came = last
    for number in range(1, 60):
        sent = last + number * RATE
        if lifted and sent > last + pause:
            break
        came = max(sent, last + pause, came + apart)
        if number == 1:
            assert keyboard.expire(came) == (release("w"),)
        if number == 1 and meanwhile == "stopped":
            keyboard.stop({"w"}, came)
        if number == 1 and meanwhile == "let go":
            keyboard.release_all(came)
        keyboard.press("w", came)
        if lifted:
            assert number < 3 or keyboard.held == ()
    return keyboard


@for_each("pause", [0.2, 0.3, 0.5, 0.9])
def test_a_key_that_is_down_drives_on_after_its_line_paused(pause: float):
    assert after_a_pause(pause).held == ("w",)


@for_each("apart", [1e-3, 5e-3, 0.011, 0.018])
@for_each("pause", [0.2, 0.5, 0.9])
def test_a_key_that_went_up_while_its_line_paused_does_not_however_slowly_the_rest_comes(
    pause: float, apart: float
):
    assert after_a_pause(pause, lifted=True, apart=apart).held == ()


@pytest.mark.parametrize(("pause", "meanwhile"), [(1.2, ""), (0.5, "stopped"), (0.5, "let go")])
def test_a_key_that_is_down_has_to_go_up_after_a_long_pause_or_when_its_robot_was_stopped(
    pause: float, meanwhile: str
):
    keyboard = after_a_pause(pause, meanwhile=meanwhile)
    assert keyboard.held == ()
    assert keyboard.must_release == ("w",)


def test_of_a_late_key_the_operator_learns_when_its_repeats_do_not_let_it_drive_on():
    keyboard = KeyboardHold()
    last = hold_down(keyboard, "w", 0.0, 5, RATE)
    keyboard.expire(last + 1.3)
    for number in range(8):
        keyboard.press("w", last + 1.3 + number * 1e-3)
    waited_for = []
    for number in range(1, 12):
        keyboard.press("w", last + 1.31 + number * RATE)
        waited_for.append(keyboard.must_release)
    assert keyboard.held == ()
    assert waited_for[:5] == 5 * [()]
    assert waited_for[-1] == ("w",), "the pause was too long for it"


def silent(_key: str) -> bool:
    """No key drives."""
    return False


def second(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True, timed=True, second=True)


@for_each("gap", [0.05, 0.3, 0.59, 0.61, 1.09])
def test_two_quick_presses_of_a_key_that_does_not_drive_are_two(gap: float):
    keyboard = KeyboardHold(silent)
    assert keyboard.press("f8", 0.0) == (press("f8"),)
    assert keyboard.press("f8", gap) == (repeat("f8"),)
    assert keyboard.needs_answers
    assert keyboard.expire(gap + 0.46) == ()
    assert keyboard.expire(gap + 0.48) == (second("f8"), release("f8"))
    assert keyboard.expire(9.0) == ()
    assert keyboard.press("f8", 9.0) == (press("f8"),)


@for_each("delay", [0.2, 0.5, 0.66, 1.0])
def test_a_held_key_that_does_not_drive_is_pressed_once(delay: float):
    keyboard = KeyboardHold(silent)
    assert keyboard.press("f8", 0.0) == (press("f8"),)
    for number in range(60):
        assert keyboard.press("f8", delay + number * 0.125) == (repeat("f8"),)
    last = delay + 59 * 0.125
    assert keyboard.expire(last + 0.71) == ()
    assert keyboard.expire(last + 0.73) == (release("f8"),)


def test_a_terminal_that_answers_proves_a_second_press_sooner():
    keyboard = KeyboardHold(silent)
    keyboard.answers = True
    keyboard.press("f8", 0.0)
    keyboard.press("f8", 0.1)
    keyboard.heard(0.3, 0.24)
    assert keyboard.expire(0.33) == (), "a report may still be on the line"
    keyboard.heard(0.34, 0.26)
    assert keyboard.expire(0.37) == (second("f8"), release("f8"))


@for_each("stale", [False, True])
def test_a_key_that_does_not_drive_is_down_until_the_terminal_answers(*, stale: bool):
    keyboard = KeyboardHold(silent)
    keyboard.answers = True
    keyboard.press("t", 0.0, stale=stale)
    assert keyboard.needs_answers
    assert not keyboard.hurries
    keyboard.heard(1.25, 1.2)
    keyboard.expire(1.28)
    assert keyboard.held == ()
    assert not keyboard.needs_answers
    assert keyboard.press("t", 1.3) == (press("t"),)


@for_each("gap", [0.33, 0.6, 1.09])
def test_a_press_soon_after_one_from_a_pause_counts(gap: float):
    keyboard = KeyboardHold(silent)
    (ignored,) = keyboard.press("t", 0.0, stale=True)
    assert ignored.stale
    assert keyboard.press("t", gap) == (repeat("t"),)
    assert keyboard.expire(gap + 0.48) == (second("t"), release("t"))


def test_a_key_held_since_a_pause_never_counts():
    keyboard = KeyboardHold(silent)
    keyboard.press("t", 0.0, stale=True)
    for number in range(1, 9):
        (event,) = keyboard.press("t", number * RATE)
        assert (event.repeat, event.stale) == (True, True)
    assert keyboard.expire(5.0) == ()


def test_a_pause_of_the_console_or_of_the_focus_takes_the_second_press():
    keyboard = KeyboardHold(silent)
    keyboard.press("f8", 0.0)
    (event,) = keyboard.press("f8", 0.3, stale=True)
    assert event.stale
    assert keyboard.expire(5.0) == ()
    keyboard.press("f8", 10.0)
    keyboard.press("f8", 10.3)
    assert keyboard.release_all(10.4) == (release("f8"),)
    assert keyboard.expire(20.0) == ()
