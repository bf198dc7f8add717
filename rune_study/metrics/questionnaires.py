"""Scores of questionnaires: NASA-TLX, SUS and SART."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rune_study.errors import DataError

TLX_SCALES = ("mental", "physical", "temporal", "performance", "effort", "frustration")
"""Scales of NASA-TLX in the order of its form; performance runs from perfect to failure."""
TLX_PAIRS = 15
SUS_ITEMS = 10
SUS_MOST_MISSING = 3
SART_ITEMS = 10


def raw_tlx(ratings: Mapping[str, float]) -> float:
    """Raw NASA-TLX: the mean of six ratings, 0 to 100 (S. G. Hart, L. E. Staveland, 1988).

    Args:
        ratings: Of each scale, from 0 to 100 in steps of 5.

    Raises:
        DataError: A scale is missing or unknown, or a rating is none of the 21 marks. Other ranges
            are refused, since their scores cannot be compared.
    """
    return sum(_ratings(ratings)) / len(TLX_SCALES)


def weighted_tlx(ratings: Mapping[str, float], choices: Sequence[str]) -> float:
    """Weighted NASA-TLX: each rating counts as often as its scale was chosen.

    Args:
        ratings: Of each scale, from 0 to 100 in steps of 5.
        choices: Of each of the 15 pairs of scales, the one that counts more for the workload.

    Raises:
        DataError: As `raw_tlx`, or the choices are not one of each pair.
    """
    rated = _ratings(ratings)
    weights = [list(choices).count(scale) for scale in TLX_SCALES]
    if len(choices) != TLX_PAIRS or sum(weights) != TLX_PAIRS or not _possible(weights):
        text = f"the {TLX_PAIRS} choices of NASA-TLX must be one of each pair of its scales"
        raise DataError(text)
    return sum(weight * rating for weight, rating in zip(weights, rated, strict=True)) / TLX_PAIRS


def sus(answers: Sequence[int | None]) -> float:
    """System Usability Scale, 0 to 100 (J. Brooke, 1996).

    Args:
        answers: Ten, from 1 to 5; odd items are positive, even ones negative. None is a missing
            answer and counts as 3.

    Returns:
        NaN if more than 3 are missing.

    Raises:
        DataError: There are not ten, or one is not a whole number from 1 to 5.
    """
    _check(answers, SUS_ITEMS, 5, "SUS")
    if sum(each is None for each in answers) > SUS_MOST_MISSING:
        return math.nan
    given = [3 if each is None else each for each in answers]
    return 2.5 * sum(each - 1 if place % 2 == 0 else 5 - each for place, each in enumerate(given))


def sart(ratings: Sequence[int | None]) -> float:
    """Situation Awareness Rating Technique: U - (D - S), -14 to 46 (R. M. Taylor, 1990).

    Args:
        ratings: Ten, from 1 to 7: three of demand, four of supply, three of understanding.

    Returns:
        NaN if one is missing.

    Raises:
        DataError: There are not ten, or one is not a whole number from 1 to 7.
    """
    _check(ratings, SART_ITEMS, 7, "SART")
    given = [each for each in ratings if each is not None]
    if len(given) < SART_ITEMS:
        return math.nan
    demand, supply, understanding = sum(given[:3]), sum(given[3:7]), sum(given[7:])
    return float(understanding - (demand - supply))


def _ratings(ratings: Mapping[str, float]) -> list[float]:
    if set(ratings) != set(TLX_SCALES):
        text = f"NASA-TLX has the scales {', '.join(TLX_SCALES)}, not {', '.join(sorted(ratings))}"
        raise DataError(text)
    for scale, rating in ratings.items():
        if not (0 <= rating <= 100 and rating % 5 == 0):
            text = f"the rating {rating:g} of {scale} is not from 0 to 100 in steps of 5"
            raise DataError(text)
    return [float(ratings[scale]) for scale in TLX_SCALES]


def _possible(weights: list[int]) -> bool:
    """Whether six scales can have won so often if each met each other one once (H. G. Landau)."""
    ordered = sorted(weights)
    return all(sum(ordered[:count]) >= count * (count - 1) // 2 for count in range(1, 7))


def _check(answers: Sequence[int | None], items: int, most: int, name: str) -> None:
    if len(answers) != items:
        text = f"{name} has {items} items, but there are {len(answers)} answers"
        raise DataError(text)
    for number, each in enumerate(answers, start=1):
        if each is not None and each not in range(1, most + 1):
            text = f"answer {each!r} to item {number} of {name} is not from 1 to {most}"
            raise DataError(text)
