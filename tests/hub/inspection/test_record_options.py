"""`rune-hub record` refuses marks that nobody can read."""

from __future__ import annotations

import pytest

from tests.support.command_line import rune_hub


@pytest.mark.parametrize(
    ("order", "text", "why"),
    [
        ("--mark", "", "a mark needs words"),
        ("--mark", "  ", "a mark needs words"),
        ("--mark", "x" * 100_000, "the text has 100000 letters; 1000 are the most"),
        ("--snapshot", "x" * 1001, "the text has 1001 letters; 1000 are the most"),
    ],
)
def test_texts_without_words_and_long_ones_are_refused(order: str, text: str, why: str) -> None:
    done = rune_hub("record", order, text)
    assert done.returncode == 2
    assert why in done.stderr
