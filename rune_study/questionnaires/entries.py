"""How each kind of item is answered with keys, and what it shows; pure.

No item has an answer before the first key, so that none is suggested.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Protocol

from rich.cells import cell_len, chop_cells

from rune_study.errors import AnswersError
from rune_study.questionnaires.ground import Ground
from rune_study.questionnaires.items import (
    Agreement,
    Answer,
    Bearing,
    Choice,
    Item,
    NumberItem,
    Pair,
    PlaceItem,
    Scale,
    TextItem,
)
from rune_study.questionnaires.spatial_entries import BearingEntry, PlaceEntry

Grounds = Mapping[tuple[str, int], Ground]
WIDTH = 70
"""Columns of an item."""


class Entry(Protocol):
    """An item while it is answered."""

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key, by the terminal's name and its character; returns the final answer."""

    def lines(self) -> list[str]:
        """What is below the question."""


def entry_of(item: Item, grounds: Grounds | None = None) -> Entry:
    """A fresh entry for an item.

    Args:
        item: The item.
        grounds: What questions about places show, by what they ask for and the robot's number.

    Raises:
        AnswersError: It asks for a place, and there is no ground.
    """
    match item:
        case Scale():
            return ScaleEntry(item)
        case Choice():
            return ListEntry(item.options, item.options)
        case NumberItem() | TextItem():
            return TypedEntry(item)
        case Agreement():
            return AgreementEntry()
        case Bearing():
            return BearingEntry(item)
        case PlaceItem():
            ground = (grounds or {}).get((item.ground, item.robot))
            if ground is None:
                text = f"{item.id} asks for a place, and there is no ground to show"
                raise AnswersError(text)
            return PlaceEntry(ground)
        case Pair():
            return PairEntry(item)
    raise AssertionError(item)


def wrapped(words: str) -> list[str]:
    """Words in lines of at most `WIDTH` columns; line breaks stay."""
    lines = (line for part in words.splitlines() for line in textwrap.wrap(part, WIDTH) or [""])
    return [piece for line in lines for piece in chop_cells(line, WIDTH) or [""]]


class ScaleEntry:
    """A mark on a row; the first arrow sets it in the middle."""

    def __init__(self, item: Scale) -> None:
        self._item = item
        self._mark: int | None = None

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        last = self._item.marks - 1
        if key in ("left", "right", "home", "end"):
            self._mark = self._moved(key, last)
        elif self._few and character is not None and character.isdecimal():
            mark = int(character) - 1
            self._mark = mark if 0 <= mark <= last else self._mark
        elif key == "enter" and self._mark is not None:
            return self._item.value(self._mark)
        return None

    def lines(self) -> list[str]:
        """What is below the question."""
        gap = 2 if self._item.marks <= 24 else 0
        signs = ["│"] * self._item.marks
        if self._item.marks % 2:
            signs[self._item.marks // 2] = "┃"
        if self._mark is not None:
            signs[self._mark] = "█"
        if self._few:
            gap = 6
        row = ("─" * gap).join(signs)
        low, high = self._item.low, self._item.high
        words = low + " " * max(2, len(row) - cell_len(low) - cell_len(high)) + high
        keys = "← → set a mark" if self._mark is None else "← → move the mark   Enter: go on"
        digits = f"   1-{self._item.marks}: the same by number" if self._few else ""
        return [row, words, "", keys + digits]

    @property
    def _few(self) -> bool:
        """Whether the marks can be named by one digit."""
        return self._item.marks <= 9

    def _moved(self, key: str, last: int) -> int:
        if key in ("home", "end"):
            return 0 if key == "home" else last
        if self._mark is None:
            return last // 2
        return min(last, max(0, self._mark + (1 if key == "right" else -1)))


class ListEntry:
    """One of several lines."""

    def __init__(self, values: Sequence[Answer], words: Sequence[str]) -> None:
        self._values = values
        self._words = words
        self._chosen: int | None = None

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        last = len(self._values) - 1
        if key in ("up", "down"):
            step = 1 if key == "down" else -1
            first = 0 if key == "down" else last
            now = self._chosen
            self._chosen = first if now is None else min(last, max(0, now + step))
        elif character is not None and character.isdecimal() and 1 <= int(character) <= last + 1:
            self._chosen = int(character) - 1
        elif key == "enter" and self._chosen is not None:
            return self._values[self._chosen]
        return None

    def lines(self) -> list[str]:
        """What is below the question."""
        rows = [
            f"{'▶' if number == self._chosen else ' '} {number + 1}  {words}"
            for number, words in enumerate(self._words)
        ]
        keys = "↑ ↓ choose" if self._chosen is None else "↑ ↓ choose   Enter: go on"
        return [*rows, "", keys]


class AgreementEntry(ListEntry):
    """Yes or no; a no takes a second Enter, for it ends the session."""

    def __init__(self) -> None:
        super().__init__((True, False), ("Yes", "No"))
        self._asks_again = False

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        value = super().press(key, character)
        sure, self._asks_again = self._asks_again, value is False
        return None if value is False and not sure else value

    def lines(self) -> list[str]:
        """What is below the question."""
        again = ["No ends the session. Enter: end it   ↑: back to Yes"]
        return [*super().lines()[:-1], *again] if self._asks_again else super().lines()


class PairEntry:
    """One of two, by an arrow; the next question comes at once."""

    def __init__(self, item: Pair) -> None:
        self._item = item

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        del character
        sides = {"left": self._item.first, "right": self._item.second}
        return sides[key][0] if key in sides else None

    def lines(self) -> list[str]:
        """What is below the question."""
        left, right = self._item.first[1], self._item.second[1]
        between = max(2, WIDTH - cell_len(left) - cell_len(right) - 4)
        return [f"← {left}{' ' * between}{right} →"]


class TypedEntry:
    """Characters in a line."""

    def __init__(self, item: NumberItem | TextItem) -> None:
        self._item = item
        self._typed = ""
        self._fault = ""

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        self._fault = ""
        if key == "backspace":
            self._typed = self._typed[:-1]
        elif key == "enter":
            answer = self._answer()
            if answer is not None and self._item.accepts(answer):
                return answer
            self._fault = f"Please give {self._wanted()}."
        elif character is not None and character.isprintable() and len(self._typed) < self._most:
            self._typed += character
        return None

    def lines(self) -> list[str]:
        """What is below the question."""
        rows = chop_cells(self._typed, WIDTH - 3) or [""]
        unit = f" {self._item.unit}" if isinstance(self._item, NumberItem) else ""
        shown = [f"> {rows[0]}", *(f"  {row}" for row in rows[1:])]
        shown[-1] += "▁" + unit
        return [*shown, "", self._fault, f"Type {self._wanted()}   Enter: go on"]

    @property
    def _most(self) -> int:
        return self._item.longest if isinstance(self._item, TextItem) else 20

    def _answer(self) -> Answer | None:
        if isinstance(self._item, TextItem):
            return self._typed.strip()
        try:
            return float(self._typed.strip().replace(",", "."))
        except ValueError:
            return None

    def _wanted(self) -> str:
        if isinstance(self._item, TextItem):
            least = "nothing or " if self._item.optional else ""
            return f"{least}up to {self._item.longest} characters"
        whole = "a whole number" if self._item.whole else "a number"
        return f"{whole} {self._item.bounds}".strip()
