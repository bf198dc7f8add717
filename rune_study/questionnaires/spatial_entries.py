"""How directions and places are answered, with keys or the mouse; pure.

No item has an answer before the first key, so that none is suggested.
"""

from __future__ import annotations

from typing import Final

from rune_study.questionnaires.ground import Ground, Place, picture_of
from rune_study.questionnaires.items import Answer, Bearing

_ARROWS: Final = ("↑", "↖", "←", "↙", "↓", "↘", "→", "↗")
_NORTH: Final = 90.0
_LONG_STEP: Final = 5
_LEAST_LINES: Final = 4
"""Least number of lines of the ground."""
_CURSOR: Final = ((0, -1, "┃"), (-1, 0, "━"), (0, 0, "╋"), (1, 0, "━"), (0, 1, "┃"))
"""Columns and lines from the cursor, and what is drawn there."""


class BearingEntry:
    """A dial; the first arrow sets it ahead, or to the north of the map."""

    def __init__(self, item: Bearing) -> None:
        self._step = item.step
        self._up = _NORTH if item.in_map else 0.0
        self._angle: float | None = None

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        del character
        turns = {"left": self._step, "right": -self._step, "up": 1.0, "down": -1.0}
        if key in turns:
            now = self._angle
            self._angle = self._up if now is None else (now + turns[key]) % 360.0
        elif key == "enter":
            return self._angle
        return None

    def lines(self) -> list[str]:
        """What is below the question."""
        if self._angle is None:
            return ["        ·", "", "← → set a direction"]
        arrow = _ARROWS[round((self._angle - self._up) % 360.0 / 45.0) % 8]
        words = self._by_compass(self._angle) if self._up else self._by_robot(self._angle)
        return [
            f"        {arrow}   {words}",
            "",
            "← → turn   ↑ ↓ turn by a degree   Enter: go on",
        ]

    @staticmethod
    def _by_compass(angle: float) -> str:
        return f"{(_NORTH - angle) % 360.0:g}° by the compass; north is up on the map"

    @staticmethod
    def _by_robot(angle: float) -> str:
        side = angle if angle <= 180 else angle - 360
        where = "left" if side > 0 else "right"
        return {0.0: "ahead", 180.0: "behind"}.get(abs(side), f"{abs(side):g}° to the {where}")


class PlaceEntry:
    """A cursor on the ground; the first arrow sets it in the middle, a click where it points."""

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self._picture = picture_of(ground, 70, 12)
        self._place: Place | None = None

    def fit(self, columns: int, lines: int) -> None:
        """Draw on a part of the screen of this size."""
        self._picture = picture_of(self._ground, columns, max(_LEAST_LINES, lines - 2))

    def click(self, column: int, line: int) -> None:
        """Take a click on a character of `lines`; beside the ground it has no effect."""
        self._place = self._picture.place(column, line) or self._place

    def press(self, key: str, character: str | None) -> Answer | None:
        """Take a key; returns the final answer."""
        del character
        direction = key.removeprefix("shift+")
        steps = {"left": (-1, 0), "right": (1, 0), "up": (0, 1), "down": (0, -1)}
        if direction in steps:
            self._move(*steps[direction], 1 if key == direction else _LONG_STEP)
        elif key == "enter" and self._place is not None:
            return round(self._place[0], 3), round(self._place[1], 3)
        return None

    def lines(self) -> list[str]:
        """What is below the question."""
        shown = [list(line) for line in self._picture.lines]
        if self._place is not None:
            column, line = self._picture.character(self._place)
            for right, down, drawn in _CURSOR:
                at, row = column + right, line + down
                if 0 <= row < len(shown) and 0 <= at < len(shown[row]):
                    shown[row][at] = drawn
        keys = (
            "click, or arrows: set the place"
            if self._place is None
            else "click, or arrows: move (Shift: faster)   Enter: go on"
        )
        return [*map("".join, shown), "", f"north is up   {keys}"]

    def _move(self, right: int, up: int, steps: int) -> None:
        left, low, across, top = self._ground.bounds
        if self._place is None:
            self._place = (left + across) / 2.0, (low + top) / 2.0
            return
        far = steps * self._picture.scale
        x, y = self._place[0] + right * far, self._place[1] + up * far
        self._place = min(max(x, left), across), min(max(y, low), top)
