"""Orders of conditions: rows of designs, their balance, and rules that an order keeps."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

from hub.values import dataclass
from rune_study.errors import StudyError
from rune_study.lots import shuffled

Row = tuple[int, ...]
"""Numbers of conditions, from 0, in their order."""
MOST_TRIES = 10_000
MOST_OF_ALL = 6
"""Most conditions of the design `all`: 720 rows."""


def latin(count: int) -> list[Row]:
    """Rows in which each condition is once at each position."""
    return [tuple((row + place) % count for place in range(count)) for row in range(count)]


def williams(count: int) -> list[Row]:
    """A Latin square in which each condition follows each other equally often (Williams 1949).

    It has `count` rows if that is even, else twice as many.
    """
    first = [(place + 1) // 2 if place % 2 else -place // 2 for place in range(count)]
    rows = [tuple((place + row) % count for place in first) for row in range(count)]
    return rows + [row[::-1] for row in rows] if count % 2 and count > 1 else rows


def permutations(count: int) -> list[Row]:
    """All orders."""
    return list(itertools.permutations(range(count)))


def fixed(count: int) -> list[Row]:
    """The one order of the file."""
    return [tuple(range(count))]


ROWS: dict[str, Callable[[int], list[Row]]] = {
    "williams": williams,
    "latin": latin,
    "all": permutations,
    "fixed": fixed,
}
"""Designs with rows, by name."""
BY_LOT = ("blocks", "random")
"""Designs that draw an order for each participant."""


def row_of(rows: Sequence[Row], place: int, seed: str) -> Row:
    """The row of the participant at a place, from 0.

    Each block of participants, as many as rows, has every row once, in an order by lot.
    """
    block, at = divmod(place, len(rows))
    return shuffled(rows, seed, "block", block)[at]


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """How often conditions were where, over some orders.

    Attributes:
        positions: Of each condition, by position.
        carry_over: Of each condition, by the one right before it.
    """

    positions: tuple[tuple[int, ...], ...]
    carry_over: tuple[tuple[int, ...], ...]


def balance(orders: Sequence[Row], count: int) -> Balance:
    """The balance of orders of `count` conditions."""
    longest = max(map(len, orders), default=0)
    positions = [[0] * longest for _ in range(count)]
    carry = [[0] * count for _ in range(count)]
    for order in orders:
        for place, condition in enumerate(order):
            positions[condition][place] += 1
        for before, after in itertools.pairwise(order):
            carry[after][before] += 1
    return Balance(positions=tuple(map(tuple, positions)), carry_over=tuple(map(tuple, carry)))


Rule = Callable[[Row], bool]


def no_run_above(longest: int, level: Callable[[int], object]) -> Rule:
    """The rule that a level comes at most `longest` times in a row."""

    def holds(order: Row) -> bool:
        return all(len(list(same)) <= longest for _, same in itertools.groupby(map(level, order)))

    return holds


def drawn(items: Row, in_blocks: int, rules: Sequence[Rule], seed: str, *words: object) -> Row:
    """The first of the seeded shuffles that keeps all rules.

    Args:
        items: Conditions, each as often as it comes in a block.
        in_blocks: Number of blocks; each is shuffled on its own.
        rules: What an order keeps.
        seed: Of the study.
        words: What the order is for.

    Raises:
        StudyError: None of `MOST_TRIES` orders keeps the rules.
    """
    for attempt in range(MOST_TRIES):
        order = one_try(items, in_blocks, seed, *words, attempt)
        if all(rule(order) for rule in rules):
            return order
    text = f"none of {MOST_TRIES} orders keeps the rules of [design]; allow more"
    raise StudyError(text)


def one_try(items: Row, in_blocks: int, seed: str, *words: object) -> Row:
    """One order by lot, whether or not it keeps any rule."""
    blocks = (shuffled(items, seed, *words, block) for block in range(in_blocks))
    return tuple(itertools.chain.from_iterable(blocks))


def counts_kept(
    items: Row, in_blocks: int, rules: Sequence[Rule], seed: str, tries: int
) -> tuple[int, list[int]]:
    """Number of orders by lot that keep all rules, and of those that keep each, of `tries`."""
    each = [0] * len(rules)
    together = 0
    for attempt in range(tries):
        order = one_try(items, in_blocks, seed, "check", attempt)
        kept = [rule(order) for rule in rules]
        each = [count + one for count, one in zip(each, kept, strict=True)]
        together += all(kept)
    return together, each
