"""SAGAT: what the operator knows when the trial is frozen.

M. R. Endsley, Measurement of Situation Awareness in Dynamic Systems, Human Factors 37, 1995.
Level 1 is what he perceives, level 2 what it means, level 3 what he expects.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.estimate import LEVEL, Estimate, unknown
from rune_study.statistics.means import share

_EQUAL = 1e-9


class AnswerKind(StrEnum):
    """How an answer is compared with the truth."""

    BEARING = "bearing"
    PLACE = "place"
    NUMBER = "number"
    CHOICE = "choice"


@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    """A question of a freeze, and its answer.

    Attributes:
        level: 1, 2 or 3.
        kind: How to compare.
        answer: A bearing [deg], a place (x, y) [m], a number or a choice. None: there is no answer.
        truth: The same of the world.
        tolerance: Largest difference that is right, inclusive [deg, m or the number's unit].
    """

    level: int
    kind: AnswerKind
    answer: float | str | tuple[float, float] | None
    truth: float | str | tuple[float, float]
    tolerance: float = 0.0

    @property
    def right(self) -> bool:
        """Whether the answer is right; no answer is wrong.

        Raises:
            DataError: Answer or truth do not fit the kind.
        """
        if self.answer is None:
            return False
        match (self.kind, self.answer, self.truth):
            case (AnswerKind.CHOICE, str() as said, str() as true):
                return said == true
            case (AnswerKind.BEARING, float() | int() as said, float() | int() as true):
                return abs((said - true + 180.0) % 360.0 - 180.0) <= self.tolerance + _EQUAL
            case (AnswerKind.NUMBER, float() | int() as said, float() | int() as true):
                return abs(said - true) <= self.tolerance + _EQUAL
            case (
                AnswerKind.PLACE,
                (float() | int() as x, float() | int() as y),
                (float() | int() as true_x, float() | int() as true_y),
            ):
                return math.hypot(x - true_x, y - true_y) <= self.tolerance + _EQUAL
        text = f"the answer {self.answer!r} or the truth {self.truth!r} is no {self.kind}"
        raise DataError(text)


def awareness(queries: Sequence[Query], level: int, confidence: float = LEVEL) -> Estimate:
    """Share of right answers of a level, with Wilson's interval; no answer counts as wrong.

    Args:
        queries: All queries of the trial.
        level: 1, 2 or 3.
        confidence: Level of the interval.
    """
    asked = [each for each in queries if each.level == level]
    if not asked:
        return unknown(f"no query of level {level} was asked")
    silent = sum(each.answer is None for each in asked)
    found = share(sum(each.right for each in asked), len(asked), confidence)
    note = f"{silent} without an answer" if silent else ""
    return Estimate(value=found.value, low=found.low, high=found.high, n=found.n, note=note)
