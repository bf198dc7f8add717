"""Errors of the command line say what to do."""

from __future__ import annotations

import pytest

from hub.errors import CodecError
from hub.gcm.navigation import STOP
from hub.inspection import value_text
from tests.support.cases import for_each
from tests.support.command_line import rune, rune_hub


@for_each(
    ("command", "words"),
    [
        (("adopt", "robot.local"), "such as ws://HOST:8765"),
        (("keys", "make", "alice"), "--role is one of observe, operate"),
    ],
)
def test_a_missing_word_comes_with_those_that_are_allowed(command, words) -> None:
    done = rune_hub(*command)
    assert done.returncode == 2
    assert words in done.stderr


def test_an_unknown_demo_comes_with_the_arenas() -> None:
    done = rune("demo", "purple")
    assert done.returncode == 2
    assert "arenas are empty, hall, orange" in done.stderr


@for_each(
    ("field", "words"),
    [
        ("reasn", r"no field 'reasn'; did you mean 'reason'\?\Z"),
        ("speed", "no field 'speed'; it has reason"),
    ],
)
def test_a_wrong_field_comes_with_one_proposal(field: str, words: str) -> None:
    with pytest.raises(CodecError, match=words):
        value_text.value_from_text(STOP, [f"{field}=x"])
