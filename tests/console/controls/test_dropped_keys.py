"""After a dropped key, keys that come before a time of quiet."""

from __future__ import annotations

from rune_tui.controls.keyboard import KeyboardHold
from tests.support.cases import for_each


@for_each("answers", [False, True])
@for_each("reported", [False, True])
def test_after_a_dropped_key_all_are_dropped_until_none_came_for_a_while(
    *, reported: bool, answers: bool
):
    keyboard = KeyboardHold(lambda key: key == "w")
    keyboard.answers = answers

    def typed(key: str, now: float) -> bool:
        """Whether a key counts, on a line that answers at once."""
        keyboard.heard(now - 0.021, now - 0.021)
        events = keyboard.down(key, now, repeat=False) if reported else keyboard.press(key, now)
        if reported:
            keyboard.up(key, now + 0.01)
        return not events[-1].stale

    keyboard.drop(0.0)
    assert keyboard.needs_answers
    for number, key in enumerate("explore w"):
        assert not typed(key, 0.1 + number * 0.25)
    assert "w" not in keyboard.held
    assert not typed("t", 2.1 + 0.29)
    assert typed("m", 2.39 + 0.4)
    keyboard.heard(4.9, 4.8)
    keyboard.expire(5.0)
    assert keyboard.must_release == ()


def test_a_line_that_pauses_does_not_end_the_time_in_which_keys_are_dropped():
    keyboard = KeyboardHold(lambda _: False)
    keyboard.answers = True
    keyboard.drop(0.0)
    keyboard.heard(0.1, 0.05)
    keyboard.expire(5.0)
    (event,) = keyboard.press("e", 5.0)
    assert event.stale, "it may have been typed at once, and come late"
    keyboard.heard(5.5, 5.4)
    keyboard.expire(5.6)
    assert not keyboard.press("t", 5.7)[-1].stale
