"""A row of the picture as Textual knows rows: encoded once for the terminal, segments on demand.

Textual styles and encodes every cell of a row by itself, which takes 200 ms a frame of video. A
`PixelStrip` brings its bytes along; segments are only made when something asks for them, such as a
screenshot or a pane that covers part of the row.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from rich.color import Color as RichColor
from rich.console import Console
from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.filter import LineFilter
from textual.strip import Strip

from rune_tui.compositor.ansi import encoded_rows
from rune_tui.compositor.blend import mean
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.glyph_set import LOWER_HALF, UPPER_HALF
from rune_tui.compositor.looks import Looks
from rune_tui.ui.textual_inside import LazyStrip


class PixelStrip(LazyStrip):
    """Columns `start` to `end` of one row of cells."""

    __slots__ = ["_cells", "_end", "_half", "_looks", "_row", "_start"]

    def __init__(
        self, cells: Cells, looks: Looks, row: int, start: int, end: int, half: str = UPPER_HALF
    ) -> None:
        """Prepare; the bytes are encoded on request.

        Args:
            cells: The frame, for segments.
            looks: Its looks, for the terminal.
            row: Number of the row.
            start: The first column.
            end: The column after the last.
            half: The half block to draw with.
        """
        super().__init__(end - start)
        self._cells, self._looks, self._half = cells, looks, half
        self._row, self._start, self._end = row, start, end

    def segments(self) -> list[Segment]:
        """A segment for each cell."""
        return segments(self._cells, self._row, self._start, self._end, self._half)

    def __bool__(self) -> bool:
        return True

    def __len__(self) -> int:
        return self._end - self._start

    def render(self, console: Console) -> str:
        """The row's bytes for the terminal."""
        del console
        rendered = self.kept
        if rendered is None:
            part = self._looks.part(self._row, self._start, self._end)
            self.kept = rendered = encoded_rows(part, self._half)[0]
        return rendered

    def crop(self, start: int, end: int | None = None) -> Strip:
        """Part of the row."""
        width = self._end - self._start
        first = max(0, start)
        last = width if end is None else min(end, width)
        if first == 0 and last == width:
            return self
        if last <= first:
            return Strip([], 0)
        start, end = self._start + first, self._start + last
        return PixelStrip(self._cells, self._looks, self._row, start, end, self._half)

    def divide(self, cuts: Iterable[int]) -> Sequence[Strip]:
        """The row in pieces that end at the cuts."""
        pieces, first = [], 0
        for cut in cuts:
            pieces.append(self.crop(first, cut))
            first = cut
        return pieces

    def apply_filter(self, filter: LineFilter, background: Color) -> Strip:  # noqa: A002
        """Return the row unchanged: filters are for styles, not for a camera's colours."""
        del filter, background
        return self


def segments(cells: Cells, row: int, start: int, end: int, half: str = UPPER_HALF) -> list[Segment]:
    """Rich segments, one for each cell; slow, for screenshots."""
    made = []
    for column in range(start, end):
        upper, lower = cells.pixels[2 * row : 2 * row + 2, column, :3]
        glyph = int(cells.glyphs[row, column])
        ink, ground = (lower, upper) if half == LOWER_HALF else (upper, lower)
        if glyph:
            ink, ground = cells.ink[row, column, :3], mean(upper, lower)
        style = Style(color=_colour(ink), bgcolor=_colour(ground))
        made.append(Segment(chr(glyph) if glyph else half, style))
    return made


def _colour(channels: npt.NDArray[np.uint8]) -> RichColor:
    red, green, blue = channels.tolist()
    return RichColor.from_rgb(red, green, blue)
