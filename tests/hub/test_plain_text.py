"""Text of others never commands a terminal."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hub.plain_text import bound_text, is_plain, markup, plain
from tests.support.cases import for_each

HOSTILE = "\x1b]0;PWNED\x07\x9b31m\u202e\u2066\u200b\u2028\ud800\x7f\r\x08"


@given(text=st.text())
def test_what_comes_out_is_plain_and_what_is_plain_stays(text: str) -> None:
    shown = plain(text)
    assert is_plain(shown)
    assert shown.isprintable() or "\xa0" in shown or not text.isprintable()
    assert (shown == text) == is_plain(text)
    assert is_plain(plain(text, lines=True), lines=True)


def test_what_commands_a_terminal_is_spelt_out() -> None:
    shown = plain(HOSTILE)
    assert shown.startswith("\\x1b]0;PWNED\\x07\\x9b31m\\u202e\\u2066\\u200b\\u2028\\ud800\\x7f")
    assert shown.isascii()


@for_each("text", ["", "Änne prüft", "10\xa0m", "地図", "3 °/s ½ ▀", "e\u0301"])
def test_what_people_write_stays(text: str) -> None:
    assert plain(text) == text


def test_a_limit_is_written_so_that_it_can_be_compared() -> None:
    numbers = (2**31 - 1, -(2.0**31), 0.25, 1e9, 6.283185307179586, math.inf, 1_000_000)
    texts = ["2147483647", "-2147483648", "0.25", "1e+09", "6.28319", "inf", "1e+06"]
    assert [bound_text(each) for each in numbers] == texts


def test_lines_stay_where_there_may_be_several() -> None:
    assert plain("one\n\ttwo\r\n", lines=True) == "one\n\ttwo\\r\n"
    assert plain("one\n\ttwo") == "one\\n\\ttwo"


@given(text=st.text())
def test_no_text_is_a_part_of_a_page(text: str) -> None:
    shown = markup(text)
    assert is_plain(shown, lines=True)
    assert not set("<>\"'") & set(shown)
    assert (
        markup("<b a='1'>&\x1b[31m\u202e\n") == "&lt;b a=&#x27;1&#x27;&gt;&amp;\\x1b[31m\\u202e\n"
    )
