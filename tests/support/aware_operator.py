"""Answers to the questions of a freeze, right or wrong as wanted; pure."""

from __future__ import annotations

import math

import numpy as np

from rune_study.errors import StudyError
from rune_study.questionnaires.items import (
    Answer,
    Bearing,
    Choice,
    ComparedItem,
    NumberItem,
    PlaceItem,
)
from rune_study.session.freezing import AskedQuery

_NEAR = 0.9
"""Right answers are wrong by up to this share of the tolerance."""
_FAR = 1.2
"""Wrong answers are wrong by this share of the tolerance, at least."""
_TURN = 360.0


def answer_of(
    item: ComparedItem, asked: AskedQuery, random: np.random.Generator, *, knows: bool
) -> Answer:
    """An answer that is right or wrong.

    Args:
        item: The question.
        asked: Its truth.
        random: Draws by how much the answer is wrong.
        knows: Whether the answer is right.

    Raises:
        StudyError: The truth is not of the item's kind, or each answer to the item is right.
    """
    off = float(random.uniform(0.0, _NEAR) if knows else random.uniform(_FAR, 2.0 * _FAR))
    off *= asked.tolerance
    answer: Answer | None = None
    match item, asked.right:
        case Choice(), str() as right:
            others = [option for option in item.options if option != right]
            answer = right if knows else others[int(random.integers(len(others)))]
        case Bearing(), float() | int() as right:
            off = off if knows else min(max(off, asked.tolerance + 1.0), _TURN / 2.0)
            answer = (right + off) % _TURN
        case PlaceItem(), (x, y):
            angle = float(random.uniform(0.0, math.tau))
            answer = x + off * math.cos(angle), y + off * math.sin(angle)
        case NumberItem(), float() | int() as right:
            answer = _number(item, right, off, knows=knows)
    if answer is None or not item.accepts(answer):
        text = f"{item.id}: there is no such answer to the truth {asked.right!r}"
        raise StudyError(text)
    return answer


def _number(item: NumberItem, right: float, off: float, *, knows: bool) -> float:
    if item.whole:
        off = float(math.floor(off)) if knows else float(math.floor(off) + 1)
    elif not knows:
        off = max(off, 1e-3)
    above, below = right + off, right - off
    return float(above if above <= item.most else below)
