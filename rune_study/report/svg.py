"""Pictures of data as SVG: axes, points, lines, intervals; pure text, without scripts."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence

from hub.plain_text import markup
from hub.values import dataclass

COLOURS = ("#1464aa", "#c8641e", "#2a8a50", "#8a3c96", "#b4960a", "#555b63")
"""Colours of conditions, readable on white and different in grey."""
_MARGIN_LEFT, _MARGIN_RIGHT, _MARGIN_TOP, _MARGIN_BOTTOM = 58, 12, 12, 40
_LETTER = 6.2
"""Width of a letter of a name [px]."""
_TICKS = 6


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a picture.

    Attributes:
        label: Its quantity and unit.
        least: The value at its begin.
        most: The value at its end.
        names: Names at 0, 1, 2, ... in place of numbers.
    """

    label: str
    least: float
    most: float
    names: tuple[str, ...] = ()

    @classmethod
    def around(cls, label: str, values: Iterable[float]) -> Axis:
        """An axis with room around these values; values that are no number do not count."""
        finite = [value for value in values if math.isfinite(value)] or [0.0]
        least, most = min(finite), max(finite)
        room = 0.06 * (most - least) or 0.5 * abs(most) or 1.0
        return cls(label, least - room, most + room)

    @classmethod
    def of_names(cls, label: str, names: Sequence[str]) -> Axis:
        """An axis with a place for each name."""
        return cls(label, -0.5, len(names) - 0.5, tuple(names))

    def ticks(self) -> list[tuple[float, str]]:
        """Values and words of its marks."""
        if self.names:
            return [(float(number), name) for number, name in enumerate(self.names)]
        step = _step((self.most - self.least) / _TICKS)
        first = math.ceil(self.least / step - 1e-9)
        last = math.floor(self.most / step + 1e-9)
        digits = max(0, -math.floor(math.log10(step) + 1e-9))
        return [(number * step, f"{number * step:.{digits}f}") for number in range(first, last + 1)]


def _step(least: float) -> float:
    """The round number (1, 2 or 5 times a power of ten) at or above a positive one."""
    power = 10.0 ** math.floor(math.log10(least)) if least > 0 else 1.0
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor >= least * (1 - 1e-9))


class Chart:
    """A picture with two axes, to which shapes are added in the units of the axes."""

    def __init__(self, x: Axis, y: Axis, *, width: int = 480, height: int = 280) -> None:
        """Begin.

        Args:
            x: The axis from left to right.
            y: The axis from bottom to top.
            width: Of the picture [px].
            height: Of the picture [px].
        """
        self._x = x
        self._y = y
        self._size = width, height
        longest = max(map(len, y.names), default=0)
        self._left = max(_MARGIN_LEFT, min(round(12 + _LETTER * longest), width // 2 + 40))
        self._parts: list[str] = []

    def line(
        self, points: Iterable[tuple[float, float]], colour: str, *, wide: float = 1.5
    ) -> None:
        """Join points; a point that is no number interrupts the line."""
        run: list[str] = []
        for x, y in [*points, (math.nan, math.nan)]:
            if math.isfinite(x) and math.isfinite(y):
                run.append(f"{self._across(x):.1f},{self._down(y):.1f}")
                continue
            if len(run) > 1:
                self._parts.append(
                    f'<polyline class="data" points="{" ".join(run)}" fill="none" '
                    f'stroke="{colour}" stroke-width="{wide}"/>'
                )
            run = []

    def steps(self, points: Sequence[tuple[float, float]], colour: str) -> None:
        """Join points by steps, as the survival function is drawn."""
        corners = list(points[:1])
        for (_, before), (x, y) in itertools.pairwise(points):
            corners += [(x, before), (x, y)]
        self.line(corners, colour, wide=2.0)

    def dot(self, x: float, y: float, colour: str, *, size: float = 4.0, title: str = "") -> None:
        """A point, with words that appear under a pointer."""
        if math.isfinite(x) and math.isfinite(y):
            inner = f"<title>{markup(title)}</title>" if title else ""
            self._parts.append(
                f'<circle class="data" cx="{self._across(x):.1f}" cy="{self._down(y):.1f}" '
                f'r="{size}" fill="{colour}">{inner}</circle>'
            )

    def upright(self, x: float, colour: str) -> None:
        """A dashed line over the whole height, such as one at no effect."""
        self._dashed((x, self._y.least), (x, self._y.most), colour)

    def interval_across(self, low: float, high: float, y: float, colour: str) -> None:
        """An interval on the axis from left to right; an open end reaches to the edge."""
        if not math.isnan(low) and not math.isnan(high):
            ends = max(low, self._x.least), min(high, self._x.most)
            self.line([(ends[0], y), (ends[1], y)], colour, wide=3.0)

    def interval_up(self, x: float, low: float, high: float, colour: str) -> None:
        """An interval on the axis from bottom to top; an open end reaches to the edge."""
        if not math.isnan(low) and not math.isnan(high):
            ends = max(low, self._y.least), min(high, self._y.most)
            self.line([(x, ends[0]), (x, ends[1])], colour, wide=3.0)

    def block(self, begin: float, end: float, y: float, high: float, colour: str) -> None:
        """A bar between two values of the axis from left to right, around a value of the other."""
        left, right = self._across(begin), self._across(end)
        top, bottom = self._down(y + high / 2), self._down(y - high / 2)
        self._parts.append(
            f'<rect class="data" x="{left:.1f}" y="{top:.1f}" width="{max(1.0, right - left):.1f}" '
            f'height="{bottom - top:.1f}" fill="{colour}"/>'
        )

    def text(self, x: float, y: float, words: str, *, anchor: str = "start") -> None:
        """Words at a point."""
        self._parts.append(
            f'<text x="{self._across(x):.1f}" y="{self._down(y) + 4:.1f}" '
            f'text-anchor="{anchor}">{markup(words)}</text>'
        )

    def svg(self, title: str) -> str:
        """The picture.

        Args:
            title: What it shows, for those who do not see it.
        """
        width, height = self._size
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'role="img" font-size="11" font-family="sans-serif" style="max-width:{width}px">'
            f"<title>{markup(title)}</title>"
            f'<rect width="{width}" height="{height}" fill="#fff" class="paper"/>'
            f"{self._frame()}{''.join(self._parts)}</svg>"
        )

    def _across(self, x: float) -> float:
        room = self._size[0] - self._left - _MARGIN_RIGHT
        return self._left + (x - self._x.least) / (self._x.most - self._x.least) * room

    def _down(self, y: float) -> float:
        room = self._size[1] - _MARGIN_TOP - _MARGIN_BOTTOM
        return _MARGIN_TOP + (self._y.most - y) / (self._y.most - self._y.least) * room

    def _dashed(self, first: tuple[float, float], last: tuple[float, float], colour: str) -> None:
        (x1, y1), (x2, y2) = first, last
        self._parts.append(
            f'<line class="axis" x1="{self._across(x1):.1f}" y1="{self._down(y1):.1f}" '
            f'x2="{self._across(x2):.1f}" y2="{self._down(y2):.1f}" '
            f'stroke="{colour}" stroke-dasharray="4 3"/>'
        )

    def _frame(self) -> str:
        """The axes with their marks and labels."""
        width, height = self._size
        left, right = self._left, width - _MARGIN_RIGHT
        top, bottom = _MARGIN_TOP, height - _MARGIN_BOTTOM
        parts = [
            f'<path class="axis" d="M{left} {top}V{bottom}H{right}" fill="none" stroke="#555b63"/>',
            f'<text x="{(left + right) / 2}" y="{height - 6}" text-anchor="middle">'
            f"{markup(self._x.label)}</text>",
            f'<text x="12" y="{(top + bottom) / 2}" text-anchor="middle" '
            f'transform="rotate(-90 12 {(top + bottom) / 2})">{markup(self._y.label)}</text>',
        ]
        for value, words in self._x.ticks():
            x = self._across(value)
            parts.append(
                f'<path class="axis" d="M{x:.1f} {bottom}v4" stroke="#555b63"/>'
                f'<text x="{x:.1f}" y="{bottom + 16}" text-anchor="middle">{markup(words)}</text>'
            )
        for value, words in self._y.ticks():
            y = self._down(value)
            parts.append(
                f'<path class="axis" d="M{left} {y:.1f}h-4" stroke="#555b63"/>'
                f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{markup(words)}</text>'
            )
        return "".join(parts)
