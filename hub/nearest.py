"""The nearest known word to an unknown one, for messages about mistakes; pure."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_LONGEST = 64
"""Letters of a word that are compared."""


def nearest_word(word: str, known: Iterable[str]) -> str:
    """The nearest known word; empty where none is near."""
    near = difflib.get_close_matches(word[:_LONGEST], list(known), n=1)
    return near[0] if near else ""


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """The part of a message that names the nearest known word; empty where none is near."""
    near = nearest_word(word, known) if isinstance(word, str) else ""
    return f"; did you mean {near!r}?" if near else ""
