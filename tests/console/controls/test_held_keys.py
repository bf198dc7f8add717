"""After a stop nothing moves before all fingers that were down were seen up, whatever happens.

`finger_model` and `random_fingers` leave out what is undecidable; docs/safety.md says it by number.
"""

from __future__ import annotations

import itertools
import random

import pytest

from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.controls.release_guard import TABLE, GuardEvent, GuardState
from tests.console.controls.finger_model import Terminal, explore
from tests.console.controls.random_fingers import Play
from tests.support.cases import for_each

_FRESH_S = 0.35
"""So long after its press a key drives that was silent after a stop, on a fast line [s]."""


def test_the_table_has_an_answer_to_every_event_in_every_state() -> None:
    assert set(TABLE) == set(itertools.product(GuardState, GuardEvent))


@pytest.mark.parametrize("terminal", Terminal, ids=lambda each: each.value.replace(" ", "-"))
@pytest.mark.parametrize(
    "length", [4, pytest.param(8, marks=[pytest.mark.soak, pytest.mark.timeout(7200)])]
)
def test_every_interleaving_moves_nothing_before_fingers_went_up(
    terminal: Terminal, length: int
) -> None:
    assert explore(terminal, length) > 700


@pytest.mark.parametrize(
    "count", [80, pytest.param(100_000, marks=[pytest.mark.soak, pytest.mark.timeout(7200)])]
)
def test_whoever_types_on_whatever_line_moves_nothing_before_fingers_went_up(count: int) -> None:
    driven = 0
    for seed in range(count):
        play = Play(random.Random(seed))
        try:
            play.run()
        except AssertionError as error:
            error.add_note(f"seed {seed}")
            raise
        driven += play.driven > 0
    assert driven > count / 2, "hardly anything moves at all"


@for_each("silence", [0.8, 2.0])
@for_each("round_trip", [0.005, 0.05])
def test_after_a_stop_a_fresh_press_drives_after_a_moment(
    silence: float, round_trip: float
) -> None:
    keyboard = KeyboardHold()
    keyboard.answers = True
    now, pressed, last = 0.0, 0.0, 0.0
    for number in range(1, 200):
        now = number * 0.05
        keyboard.heard(now, now - round_trip)
        keyboard.expire(now)
        if now < 2.0:
            keyboard.press("w", now)
            last = now
        elif now < 2.05:
            keyboard.stop({"w"}, now)
        if not pressed and now > last + silence:
            pressed = now
            keyboard.press("w", now)
        if pressed and keyboard.held:
            break
    assert now - pressed <= _FRESH_S


def test_one_gap_in_the_repeats_of_a_key_that_is_held_through_a_stop_drives_nothing() -> None:
    for gap in (0.1, 0.16, 0.2, 0.3, 0.5, 0.69):
        keyboard, now = KeyboardHold(), 0.0
        keyboard.press("w", now)
        for number in range(30):
            keyboard.press("w", 0.25 + number * 0.033)
        now = 0.25 + 30 * 0.033
        keyboard.stop({"w"}, now)
        for number in range(40):
            keyboard.press("w", now + number * 0.033)
        now += 40 * 0.033 + gap
        keyboard.expire(now - 0.001)
        for number in range(40):
            keyboard.press("w", now + number * 0.033)
            assert keyboard.held == (), f"drives {gap} s after a gap"


def held(keyboard: KeyboardHold, since: float, until: float, delay: float) -> bool:
    """Hold a key, and leave it alone then; whether it drove in the end."""
    drove = False
    count = int((until - since - delay) / 0.03)
    for when in (since, *(since + delay + 0.03 * number for number in range(count))):
        keyboard.press("w", when, read=when)
        drove = bool(keyboard.held)
    return drove


def test_a_keyboard_that_repeats_before_a_press_is_proven_has_its_keys_tapped_first() -> None:
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    keyboard.stop({"w"}, 0.1)
    keyboard.expire(2.0)
    assert not held(keyboard, 2.0, 4.0, delay=0.25)
    assert keyboard.must_release == ("w",)
    assert keyboard.tap_first
    keyboard.expire(6.0)
    keyboard.press("w", 6.0)
    keyboard.expire(7.0)
    assert not keyboard.tap_first
    assert held(keyboard, 8.0, 9.0, delay=0.25)


def test_a_key_that_never_went_up_need_not_be_tapped() -> None:
    keyboard = KeyboardHold()
    keyboard.press("w", 0.0)
    keyboard.stop({"w"}, 0.1)
    assert not held(keyboard, 0.2, 4.0, delay=0.25)
    keyboard.expire(6.0)
    assert not held(keyboard, 6.0, 8.0, delay=0.03)
    assert not keyboard.tap_first
