"""Items of questionnaires, as their files declare them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeGuard

from hub.toml_reader import (
    Key,
    choice,
    key,
    keys_of,
    number,
    plain_name,
    several,
    text,
    truth,
    whole_number,
)
from hub.values import dataclass

Answer = str | float | bool
MOST_ITEMS = 200
_NAME = plain_name(64)
_WORDS = text(1000, any_character=True)
_LABEL = text(60)
_TURN = 360.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One question.

    Attributes:
        id: Its name in the data.
        text: The question.
        title: A heading; empty: none.
    """

    id: str = key(_NAME, meaning="its name in the data")
    text: str = key(_WORDS, meaning="the question")
    title: str = key(_LABEL, "", "a heading above it")

    def accepts(self, answer: object) -> bool:
        """Whether this is an answer to the item."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale(Item):
    """A row of marks between two words.

    Attributes:
        low: The words at the left end.
        high: The words at the right end.
        marks: Number of marks.
        least: The value of the first mark.
        step: The value of a mark less that of the mark before it.
    """

    low: str = key(_LABEL, meaning="words at the left end")
    high: str = key(_LABEL, meaning="words at the right end")
    marks: int = key(whole_number(2, 101), 21, "number of marks")
    least: float = key(number(-1000, 1000), 0.0, "value of the first mark")
    step: float = key(number(0.001, 1000), 1.0, "difference between two marks")

    def value(self, mark: int) -> float:
        """The value of a mark, counted from 0."""
        return self.least + mark * self.step

    def accepts(self, answer: object) -> bool:
        """Whether it is the value of a mark."""
        return _is_number(answer) and any(
            math.isclose(answer, self.value(mark)) for mark in range(self.marks)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice(Item):
    """One of several options.

    Attributes:
        options: Their words.
    """

    options: tuple[str, ...] = key(several(_LABEL, 20), meaning="the options")

    def accepts(self, answer: object) -> bool:
        """Whether it is an option."""
        return answer in self.options


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberItem(Item):
    """A number that is typed.

    Attributes:
        least: The least that is accepted.
        most: The most that is accepted.
        unit: Its unit; empty: a count.
        whole: Whether it has to be a whole number.
    """

    least: float = key(number(-1e9, 1e9), 0.0, "least number")
    most: float = key(number(-1e9, 1e9), 1e6, "greatest number")
    unit: str = key(_LABEL, "", "its unit")
    whole: bool = key(truth, default=False, meaning="it has to be a whole number")

    def accepts(self, answer: object) -> bool:
        """Whether it lies between the bounds."""
        if not _is_number(answer):
            return False
        fits = self.least <= answer <= self.most
        return fits and (not self.whole or float(answer).is_integer())


@dataclass(frozen=True, slots=True, kw_only=True)
class TextItem(Item):
    """Words that are typed.

    Attributes:
        longest: Their greatest number of characters.
        optional: Whether they may be left out.
    """

    longest: int = key(whole_number(1, 2000), 300, "greatest number of characters")
    optional: bool = key(truth, default=False, meaning="it may be left out")

    def accepts(self, answer: object) -> bool:
        """Whether it is a text of this length."""
        if not isinstance(answer, str) or len(answer) > self.longest:
            return False
        return bool(answer.strip()) or self.optional


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement(Item):
    """A question that must be answered with yes, or the session ends."""

    def accepts(self, answer: object) -> bool:
        """Whether it is yes or no."""
        return isinstance(answer, bool)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bearing(Item):
    """A direction that is set on a dial: 0 is ahead, 90 to the left [deg].

    Attributes:
        step: Degrees of a key press.
    """

    step: float = key(number(1, 90), 15.0, "degrees of a key press")

    def accepts(self, answer: object) -> bool:
        """Whether it is an angle from 0 to less than 360."""
        return _is_number(answer) and 0 <= answer < _TURN


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair(Item):
    """Which of two items counts more.

    Attributes:
        first: The id and the words of one.
        second: Those of the other.
    """

    first: tuple[str, str]
    second: tuple[str, str]

    def accepts(self, answer: object) -> bool:
        """Whether it is one of the two ids."""
        return answer in (self.first[0], self.second[0])


KINDS: dict[str, type[Item]] = {
    "scale": Scale,
    "choice": Choice,
    "number": NumberItem,
    "text": TextItem,
    "agreement": Agreement,
    "bearing": Bearing,
}
"""Kinds of items by their names in files."""


def keys_of_item(kind: str) -> dict[str, Key]:
    """The keys of an item of this kind."""
    return {"kind": Key(choice(KINDS), meaning="the kind of item"), **keys_of(KINDS[kind])}


def pairs_of(items: Sequence[Item], question: str) -> list[Pair]:
    """All pairs of these items, in their order."""
    named = [(item.id, item.title or item.text) for item in items]
    return [
        Pair(id=f"{first[0]}-{second[0]}", text=question, first=first, second=second)
        for number, first in enumerate(named)
        for second in named[number + 1 :]
    ]


def _is_number(answer: object) -> TypeGuard[float]:
    whole = isinstance(answer, int) and not isinstance(answer, bool)
    return whole or (isinstance(answer, float) and math.isfinite(answer))
