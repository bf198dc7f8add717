"""Cases of one test: each is tried, and all that fail are told."""

from __future__ import annotations

import inspect

import pytest

from tests.support.cases import for_each


def test_all_cases_that_fail_are_told_together() -> None:
    tried: list[tuple[int, str]] = []

    @for_each("number", [1, 2, 3])
    @for_each(("word", "length"), [("a", 1), ("bb", 2)])
    def no_two(number: int, word: str, length: int, fixture: str) -> None:
        assert fixture == "f"
        assert len(word) == length
        tried.append((number, word))
        assert number != 2

    assert list(inspect.signature(no_two).parameters) == ["fixture"]
    with pytest.raises(ExceptionGroup, match="1 of 3 cases") as raised:
        no_two(fixture="f")
    assert tried == [(number, word) for number in (1, 2, 3) for word in ("a", "bb")]
    (inner,) = raised.value.exceptions
    assert isinstance(inner, ExceptionGroup)
    assert [error.__notes__ for error in inner.exceptions] == [
        ["of {'word': 'a', 'length': 1}"],
        ["of {'word': 'bb', 'length': 2}"],
    ]
    assert inner.__notes__ == ["of {'number': 2}"]
