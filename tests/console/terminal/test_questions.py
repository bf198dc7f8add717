"""What terminals say of themselves."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.terminal.questions import Answers, read_answers

MODERN = (
    b"\x1b[?2026;2$y\x1bP1$r0;48:2::1:2:3m\x1b\\\x1bP1+r524742=382F382F38\x1b\\"
    b"\x1b[6;20;10t\x1b[4;960;1600t\x1b[?1u\x1b[2;1R\x1b[?62;4c"
)
PLAIN = b"\x1b[2;1R\x1b[?1;2c"


def test_a_modern_terminal_says_all() -> None:
    assert read_answers(MODERN) == Answers(
        complete=True,
        synchronized=True,
        truecolour=True,
        cell=(10, 20),
        area=(1600, 960),
        keyboard=1,
        reports_cursor=True,
    )


def test_a_plain_terminal_says_little_and_nothing_is_made_up() -> None:
    assert read_answers(PLAIN) == Answers(complete=True, reports_cursor=True)


def test_keys_pressed_meanwhile_do_no_harm() -> None:
    noisy = b"w\x1b[A" + MODERN.replace(b"\x1b\\\x1b[6", b"\x1b\\www\x1b[6") + b"q"
    assert read_answers(noisy) == read_answers(MODERN)


def test_a_terminal_that_makes_another_colour_of_it_has_no_truecolour() -> None:
    assert read_answers(b"\x1bP1$r0;48;5;16m\x1b\\").truecolour is False
    assert read_answers(b"\x1bP0$r\x1b\\\x1bP0+r524742\x1b\\").truecolour is None


def test_a_mode_that_is_not_recognized_cannot_be_used() -> None:
    assert read_answers(b"\x1b[?2026;0$y").synchronized is False
    assert read_answers(b"\x1b[?2026;4$y").synchronized is False


def test_the_shape_of_a_cell_follows_from_either_size() -> None:
    assert Answers(cell=(10, 20)).aspect(80, 24) == 2.0
    assert Answers(area=(800, 480)).aspect(80, 24) == 2.0
    assert Answers(cell=(0, 20), area=(800, 0)).aspect(80, 24) is None
    assert Answers().aspect(80, 24) is None


@given(st.binary(max_size=200))
def test_whatever_comes_is_no_fault(data: bytes) -> None:
    read_answers(data)
    read_answers(MODERN[: len(data)] + data)
