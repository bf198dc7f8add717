"""Draws that depend on words alone: the same on every machine, with every version of Python."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")
_BITS = 56
_BETWEEN = "\x1f"


def draw(seed: str, *words: object) -> float:
    """A number in [0, 1), uniform: 7 bytes of the SHA-256 of the words."""
    digest = hashlib.sha256(_BETWEEN.join(map(str, (seed, *words))).encode()).digest()
    return int.from_bytes(digest[: _BITS // 8], "big") / (1 << _BITS)


def shuffled(items: Sequence[T], seed: str, *words: object) -> list[T]:
    """The items in an order by lot."""
    order = sorted(range(len(items)), key=lambda index: (draw(seed, *words, index), index))
    return [items[index] for index in order]


def spread(
    count: int, first: float, last: float, apart: float, seed: str, *words: object
) -> tuple[float, ...]:
    """Moments by lot that keep a gap: sorted uniforms on the room that the gaps leave.

    Args:
        count: Number of moments.
        first: Earliest moment [s].
        last: Latest moment [s].
        apart: Least time between two [s].
        seed: Of the study.
        words: What the moments are for.

    Returns:
        Moments in their order [s]; there is room for them if `room_left` is not negative.
    """
    room = room_left(count, first, last, apart)
    places = sorted(draw(seed, *words, index) * room for index in range(count))
    return tuple(first + place + index * apart for index, place in enumerate(places))


def room_left(count: int, first: float, last: float, apart: float) -> float:
    """Time that the gaps between moments leave [s]; negative: they do not fit."""
    return last - first - max(0, count - 1) * apart
