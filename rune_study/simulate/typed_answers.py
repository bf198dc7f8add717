"""Keys that answer an item of a questionnaire; pure."""

from __future__ import annotations

from typing import Final

import numpy as np

from rune_study.questionnaires.items import (
    Agreement,
    Answer,
    Bearing,
    Choice,
    Item,
    NumberItem,
    Pair,
    Scale,
    TextItem,
)

ENTER: Final = "\r"
_UP, _DOWN, _RIGHT, _LEFT, _HOME = "\x1b[A", "\x1b[B", "\x1b[C", "\x1b[D", "\x1b[H"
_BACKSPACE: Final = "\x7f"
_TYPED: Final = "simulated"
_RANGE: Final = 50.0
"""Numbers are at most this far above the least one."""


def typed_answer(item: Item, random: np.random.Generator) -> tuple[Answer, str]:
    """An answer by lot and its keys, which give the same again if a part of them was lost.

    Agreement is always given. A direction is straight ahead, or north on a map.
    """
    match item:
        case Scale():
            mark = int(random.integers(item.marks))
            return item.value(mark), _HOME + _RIGHT * mark + ENTER
        case Choice():
            chosen = int(random.integers(len(item.options)))
            return item.options[chosen], _listed(chosen, len(item.options))
        case Agreement():
            return True, _listed(0, 2)
        case NumberItem():
            most = min(item.most, item.least + _RANGE)
            number = float(int(random.uniform(item.least, most)))
            number = min(max(number, item.least), item.most)
            return number, f"{_BACKSPACE * 20}{number:g}{ENTER}"
        case TextItem():
            typed = _TYPED[: item.longest]
            return typed, _BACKSPACE * item.longest + typed + ENTER
        case Bearing():
            return 90.0 if item.in_map else 0.0, _RIGHT + ENTER
        case Pair():
            first = bool(random.integers(2))
            return (item.first if first else item.second)[0], _LEFT if first else _RIGHT
    raise AssertionError(item)


def _listed(chosen: int, lines: int) -> str:
    """Keys that choose a line, from any line or none."""
    return _UP * lines + _DOWN * chosen + ENTER
