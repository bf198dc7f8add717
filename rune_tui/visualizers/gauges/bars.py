"""The common form of gauges: a name, a bar on its track, and the value in words at the right.

A gauge gives up first the length of its bar, then the bar, then its name; the value stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from hub.values import dataclass
from rune_tui.model.theme import Colour, Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.rows import fitting_form

NAME_COLUMNS: Final = 8
"""Width of a gauge's name, so that bars begin in one column [cells]."""

_LEAST_BAR: Final = 6
_LONGEST_BAR: Final = 60
_GAP: Final = 1
_VALUE_STEP: Final = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Bar:
    """The content of a bar, in shares of its length from its left end, 0 to 1.

    Attributes:
        low: Start of the filled part.
        high: Where it ends.
        origin: Place of the line for neutral; None: none.
        mark: Place of the sign for the wanted value; None: none.
        beyond: -1 where the value is past the left end, 1 where it is past the right one, else 0.
    """

    low: float
    high: float
    origin: float | None = None
    mark: float | None = None
    beyond: int = 0

    @classmethod
    def filled(cls, share: float) -> Bar:
        """A bar from the left end."""
        return cls(low=0.0, high=share)

    @classmethod
    def from_middle(cls, value: float, wanted: float | None = None) -> Bar:
        """A bar from the middle to a value of -1 to 1, with the wanted value."""
        low, high = sorted((0.5, _share(value)))
        mark = None if wanted is None or not math.isfinite(wanted) else _share(wanted)
        past = math.isfinite(value) and abs(value) > 1.0
        beyond = int(math.copysign(1.0, value)) if past else 0
        return cls(low=low, high=high, origin=0.5, mark=mark, beyond=beyond)


def write_gauge(
    canvas: Canvas,
    row: int,
    name: str,
    bar: Bar | None,
    values: Sequence[str],
    theme: Theme,
    *,
    ink: Colour | None = None,
) -> None:
    """Write a gauge into one row.

    Args:
        canvas: The canvas.
        row: Which row.
        name: Name of the value.
        bar: The content of the bar; None: there is no bar.
        values: Texts of the value, the fullest first.
        theme: The colours.
        ink: Ink of the value, and of the filled part if it needs attention; None: no problem.
    """
    width = canvas.width
    named = width >= NAME_COLUMNS + _GAP + len(values[-1])
    left = NAME_COLUMNS + _GAP if named else 0
    if named:
        canvas.text(0, row, name, theme.soft)
    shortest = width - left - (_LEAST_BAR + _GAP if bar is not None else 0)
    fitting = [form for form in values if len(form) <= shortest]
    words = fitting[0] if fitting else fitting_form(width - left, values[-1])
    canvas.text(width - len(words), row, words, ink or theme.ink)
    # In steps, so that a new digit does not change the length of the bar.
    room = -(-len(words) // _VALUE_STEP) * _VALUE_STEP
    end = min(width - room - _GAP, left + _LONGEST_BAR)
    if bar is not None and end - left >= _LEAST_BAR:
        draw_bar(canvas, row, left, end, bar, theme, fill=ink)


def draw_bar(
    canvas: Canvas,
    row: int,
    left: int,
    end: int,
    bar: Bar,
    theme: Theme,
    *,
    fill: Colour | None = None,
) -> None:
    """Draw a bar in the lower half of a row, so that bars below each other do not touch.

    Args:
        canvas: The canvas.
        row: Which row of cells.
        left: Its first column.
        end: One past its last column.
        bar: Its content.
        theme: The colours.
        fill: The colour of the filled part; None: the accent.
    """
    length = end - left
    line = canvas.pixels[2 * row + 1 : 2 * row + 2, left:end]
    line[...] = theme.track
    low, high = (round(max(0.0, min(1.0, share)) * length) for share in (bar.low, bar.high))
    line[:, low:high] = fill or theme.accent
    if bar.origin is not None:
        _tick(canvas, row, left, length, bar.origin, "│", theme.faint)
    if bar.mark is not None:
        _tick(canvas, row, left, length, bar.mark, "▼", theme.ink)
    if bar.beyond:
        at = 1.0 if bar.beyond > 0 else 0.0
        _tick(canvas, row, left, length, at, "▶" if bar.beyond > 0 else "◀", theme.warning)


def _tick(
    canvas: Canvas, row: int, left: int, length: int, share: float, sign: str, ink: Colour
) -> None:
    column = left + min(length - 1, int(max(0.0, min(1.0, share)) * length))
    canvas.text(column, row, sign, ink)


def _share(value: float) -> float:
    return 0.5 + max(-1.0, min(1.0, value)) / 2.0 if math.isfinite(value) else 0.5
