"""Frames under way to a terminal, and its answers."""

from __future__ import annotations

import math
import re

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.terminal.input_stream import CursorReport
from rune_tui.terminal.pacing import TIMEOUT_S, WINDOW, FramePacer


def place(question: str) -> CursorReport:
    """Where a terminal's cursor is when it is asked."""
    found = re.fullmatch(r"\x1b\[(\d+);(\d+)H\x1b\[6n", question)
    assert found
    return CursorReport(row=int(found[1]), column=int(found[2]))


def test_no_more_than_the_window_is_under_way() -> None:
    pacer = FramePacer(heard=True)
    asked = [place(pacer.sent(0.0, 100)) for _ in range(WINDOW)]
    assert not pacer.may_send(0.5)
    assert pacer.answered(0.5, asked[0]) is not None
    assert pacer.may_send(0.5)


def test_an_answer_says_how_long_the_way_was_and_what_went_over_it() -> None:
    pacer = FramePacer(heard=True)
    first, second = place(pacer.sent(1.0, 5000)), place(pacer.sent(1.1, 3000))
    one = pacer.answered(1.2, first)
    two = pacer.answered(1.3, second)
    assert one is not None
    assert two is not None
    assert math.isclose(one.age, 0.2)
    assert math.isnan(one.gap)
    assert math.isclose(two.gap, 0.1)
    assert (one.size, two.size) == (5000, 3000)


def test_an_answer_stands_for_all_frames_before_it() -> None:
    pacer = FramePacer(heard=True)
    pacer.sent(0.0, 10)
    second = place(pacer.sent(0.0, 20))
    answer = pacer.answered(0.1, second)
    assert answer is not None
    assert answer.size == 30
    assert not pacer.under_way


def test_what_is_no_answer_changes_nothing() -> None:
    pacer = FramePacer(heard=True)
    asked = place(pacer.sent(0.0, 10))
    assert pacer.answered(0.1, CursorReport(row=9, column=asked.column)) is None
    assert pacer.answered(0.1, CursorReport(row=asked.row, column=asked.column + 1)) is None
    assert pacer.under_way
    assert pacer.answered(0.1, asked) is not None
    assert pacer.answered(0.1, asked) is None


def test_a_terminal_that_never_answers_is_not_waited_for_until_it_does() -> None:
    pacer = FramePacer()
    for step in range(50):
        assert pacer.may_send(step * 0.01)
        asked = place(pacer.sent(step * 0.01, 10))
    assert not pacer.answers
    assert pacer.answered(1.0, asked) is not None
    assert pacer.answers
    pacer.sent(1.0, 10)
    pacer.sent(1.0, 10)
    assert not pacer.may_send(1.1)


def test_a_terminal_that_falls_silent_gets_few_frames_until_it_is_not_waited_for() -> None:
    pacer = FramePacer(heard=True)
    pacer.answered(0.0, place(pacer.sent(0.0, 10)))
    sent, now = 0, 0.0
    while pacer.answers:
        if pacer.may_send(now):
            pacer.sent(now, 10)
            sent += 1
        now += 0.1
    assert sent <= 10
    assert 10.0 < now < 30.0


def test_a_terminal_that_answers_no_frame_at_all_is_waited_for_once() -> None:
    pacer = FramePacer(heard=True)
    pacer.sent(0.0, 10)
    pacer.sent(0.0, 10)
    assert not pacer.may_send(TIMEOUT_S - 0.01)
    assert pacer.may_send(TIMEOUT_S + 0.01)
    assert not pacer.answers


def test_a_terminal_that_answers_wrongly_is_not_waited_for() -> None:
    pacer = FramePacer(heard=True)
    pacer.answered(0.0, place(pacer.sent(0.0, 10)))
    for number in range(4):
        pacer.sent(float(number) / 10, 10)
        assert pacer.answered(number / 10, CursorReport(row=9, column=40)) is None
    assert not pacer.answers


def test_a_long_frame_is_waited_for_longer_and_a_restart_forgets_it() -> None:
    pacer = FramePacer(heard=True)
    pacer.sent(0.0, 40_000)
    pacer.sent(0.0, 40_000)
    assert not pacer.may_send(TIMEOUT_S + 5.0)
    pacer.restart()
    assert pacer.may_send(TIMEOUT_S + 5.0)


@given(st.lists(st.tuples(st.sampled_from("sad"), st.floats(0.0, 3.0)), max_size=60))
def test_the_account_never_grows_and_frames_can_always_go_on(
    steps: list[tuple[str, float]],
) -> None:
    pacer, now = FramePacer(heard=True), 0.0
    asked: list[CursorReport] = []
    for what, wait in steps:
        now += wait
        if what == "s" and pacer.may_send(now):
            asked.append(place(pacer.sent(now, 10)))
        elif what == "a" and asked:
            answer = pacer.answered(now, asked.pop(0))
            assert answer is None or answer.age >= 0.0
        elif asked:
            asked.pop(0)
        assert len(pacer.under_way) <= WINDOW
    assert pacer.may_send(now + 10.0)
