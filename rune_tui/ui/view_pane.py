"""The Textual widget that shows the view."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from rich.style import Style
from textual.geometry import Region
from textual.screen import Screen
from textual.strip import Strip
from textual.widget import Widget

from rune_tui.compositor.ansi import RowEncoder, changed_rows
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.ui.pixel_strip import PixelStrip


class ViewScreen(Screen[None]):
    """The screen on which the pane lies."""

    def get_style_at(self, x: int, y: int) -> Style:
        """No style: Textual asks at each move of the mouse, which would take a row apart."""
        del x, y
        return Style.null()


class ViewPane(Widget, can_focus=False):
    """Shows cells; only rows that changed go to the terminal."""

    DEFAULT_CSS = "ViewPane { width: 100%; height: 100%; background: black; }"

    def __init__(self, depth: ColourDepth = ColourDepth.TRUECOLOUR) -> None:
        """Prepare to show cells in colours of that depth."""
        super().__init__()
        self._depth = depth
        self._cells: Cells | None = None
        self._strips: list[Strip] = []
        self._encoder = RowEncoder()

    @property
    def cells(self) -> Cells | None:
        """The newest frame."""
        return self._cells

    def show(self, cells: Cells) -> None:
        """Show a frame in truecolour as well as the terminal can."""
        cells = at_depth(cells, self._depth)
        rows = changed_rows(self._cells, cells)
        if self._cells is None or len(self._strips) != cells.rows:
            self._strips = [Strip.blank(cells.columns)] * cells.rows
        self._cells = cells
        for row, encoded in zip(rows.tolist(), self._encoder.encode_text(cells, rows), strict=True):
            self._strips[row] = PixelStrip(cells, row, 0, cells.columns, encoded)
        self.refresh(*(Region(0, top, cells.columns, count) for top, count in _spans(rows)))

    def render_lines(self, crop: Region) -> list[Strip]:
        """The rows of `crop`; what lies outside of the newest frame is blank."""
        lines = []
        for row in range(crop.y, crop.bottom):
            strip = self._strips[row] if row < len(self._strips) else Strip.blank(0)
            if strip.cell_length < crop.right:
                # The terminal has grown and the frame that fits it is still to come.
                strip = Strip.blank(crop.right)
            lines.append(strip.crop(crop.x, crop.right))
        return lines


def _spans(rows: npt.NDArray[np.intp]) -> Iterator[tuple[int, int]]:
    """First row and number of rows of each run of neighbouring rows."""
    for run in np.split(rows, np.flatnonzero(np.diff(rows) != 1) + 1):
        if len(run):
            yield int(run[0]), len(run)
