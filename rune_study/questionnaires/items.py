"""Items of questionnaires, as their files declare them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from typing import TypeGuard

from hub.nearest import did_you_mean
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
from rune_study.metrics.awareness import AnswerKind
from rune_study.questionnaires.ground import Place
from rune_study.questionnaires.truths import TRUTHS, NamedTruth, Value

Answer = str | float | bool | Place
MOST_ITEMS = 200
MOST_NUMBER = 1e6
"""The greatest number of an item that names none."""
_NAME = plain_name(64)
_WORDS = text(1000, any_character=True)
_LABEL = text(60)
_TURN = 360.0
_FARTHEST_M = 10_000.0


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
class ComparedItem(Item):
    """A question of a freeze may have a truth, with which its answer is compared.

    Attributes:
        truth: Its name in `TRUTHS`; empty: the answer is not compared.
        level: Level of awareness, 1 to 3; 0: that of the truth.
        tolerance: Largest error of a right answer; None: that of the truth.
        robot: Number of the robot in the layout, from 1.
    """

    truth: str = key(
        plain_name(40), "", "what is true: a name of the table below", without="nothing"
    )
    level: int = key(
        whole_number(1, 3), 0, "level of awareness, 1 to 3", without="that of the truth"
    )
    tolerance: float | None = key(
        number(0, 1e6), None, "largest error of a right answer", without="that of the truth"
    )
    robot: int = key(whole_number(1, 16), 1, "number of the robot in the layout, from 1")

    @property
    def answer_kind(self) -> AnswerKind:
        """How its answers are compared."""
        raise NotImplementedError

    def compared(self) -> NamedTruth | None:
        """The truth; None: the answer is not compared."""
        return TRUTHS.get(self.truth)

    def right_answer(self, value: Value) -> Value:
        """The answer that a value of the truth makes right."""
        return value

    def fault(self) -> tuple[str, str] | None:
        """Key and words of what does not fit together; None: all does."""
        truth = self.compared()
        if self.truth and truth is None:
            hint = did_you_mean(self.truth, TRUTHS) or f"; known are {', '.join(TRUTHS)}"
            return "truth", f"{self.truth!r} is no truth{hint}"
        if truth is not None and truth.kind is not self.answer_kind:
            fitting = [name for name, each in TRUTHS.items() if each.kind is self.answer_kind]
            return "truth", (
                f"{self.truth!r} is a {truth.kind}, and this item asks for a {self.answer_kind}; "
                f"such truths are {', '.join(fitting)}"
            )
        return None


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
class Choice(ComparedItem):
    """One of several options.

    Attributes:
        options: Their words.
        means: Of each option, the values of the truth that make it right.
    """

    options: tuple[str, ...] = key(several(_LABEL, 20), meaning="the options")
    means: tuple[str, ...] = key(
        several(_LABEL, 20),
        (),
        "of each option, the values of the truth that make it right, with blanks between",
        without="the options are the values",
    )

    def accepts(self, answer: object) -> bool:
        """Whether it is an option."""
        return answer in self.options

    @property
    def answer_kind(self) -> AnswerKind:
        """How its answers are compared."""
        return AnswerKind.CHOICE

    def right_answer(self, value: Value) -> Value:
        """The option that a value of the truth makes right."""
        meanings = zip(self.options, self.means or self.options, strict=True)
        return next((option for option, values in meanings if value in values.split()), None)

    def fault(self) -> tuple[str, str] | None:
        """Key and words of what does not fit together; None: all does."""
        if self.means and len(self.means) != len(self.options):
            return "means", f"{len(self.options)} options have {len(self.means)} meanings"
        truth = self.compared()
        wrong = ComparedItem.fault(self)  # slots make a new class, so there is no super()
        if wrong is not None or truth is None:
            return wrong
        given = [word for values in self.means or self.options for word in values.split()]
        if sorted(given) != sorted(truth.words):
            return "means", f"each of {', '.join(truth.words)} has to make one option right"
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberItem(ComparedItem):
    """A number that is typed.

    Attributes:
        least: The least that is accepted.
        most: The most that is accepted.
        unit: Its unit; empty: a count.
        whole: Whether it has to be a whole number.
    """

    least: float = key(number(-1e9, 1e9), 0.0, "least number")
    most: float = key(number(-1e9, 1e9), MOST_NUMBER, "greatest number", without="none")
    unit: str = key(_LABEL, "", "its unit")
    whole: bool = key(truth, default=False, meaning="it has to be a whole number")

    @property
    def bounds(self) -> str:
        """What it accepts, in words; empty: any number."""
        if self.most < MOST_NUMBER:
            return f"from {self.least:g} to {self.most:g}"
        return f"from {self.least:g} on" if self.least > -MOST_NUMBER else ""

    def accepts(self, answer: object) -> bool:
        """Whether it lies between the bounds."""
        if not _is_number(answer):
            return False
        fits = self.least <= answer <= self.most
        return fits and (not self.whole or float(answer).is_integer())

    @property
    def answer_kind(self) -> AnswerKind:
        """How its answers are compared."""
        return AnswerKind.NUMBER


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
class Bearing(ComparedItem):
    """A direction that is set on a dial, counter-clockwise [deg].

    It counts from the robot's front, or from the x axis of `map` if its truth does.

    Attributes:
        step: Degrees of a key press.
    """

    step: float = key(number(1, 90), 15.0, "degrees of a key press")

    def accepts(self, answer: object) -> bool:
        """Whether it is an angle from 0 to less than 360."""
        return _is_number(answer) and 0 <= answer < _TURN

    @property
    def answer_kind(self) -> AnswerKind:
        """How its answers are compared."""
        return AnswerKind.BEARING

    @property
    def in_map(self) -> bool:
        """Whether it counts from the x axis of `map`."""
        truth = self.compared()
        return truth is not None and truth.in_map


class GroundShown(StrEnum):
    """Which ground a question about a place shows.

    Attributes:
        ARENA: The true ground of the arena.
        ROBOT: The robot's own map of that moment.
    """

    ARENA = "arena"
    ROBOT = "robot"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceItem(ComparedItem):
    """A place that is set on the ground, in `map` [m].

    Attributes:
        ground: What is shown: the true ground, or the robot's own map.
    """

    ground: str = key(
        choice(tuple(GroundShown)),
        GroundShown.ARENA,
        "what is shown: the ground of the arena, or the robot's own map",
    )

    def accepts(self, answer: object) -> bool:
        """Whether it is a place: x and y."""
        return (
            isinstance(answer, tuple)
            and len(answer) == 2
            and all(_is_number(each) and abs(each) <= _FARTHEST_M for each in answer)
        )

    @property
    def answer_kind(self) -> AnswerKind:
        """How its answers are compared."""
        return AnswerKind.PLACE


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
    "place": PlaceItem,
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
