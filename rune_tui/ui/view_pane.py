"""The Textual widget that shows the view."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import numpy.typing as npt
from rich.style import Style
from textual.geometry import Region
from textual.screen import Screen
from textual.strip import Strip
from textual.widget import Widget

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.glyph_set import UPPER_HALF
from rune_tui.compositor.looks import Looks, looks_of
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.ui.pixel_strip import PixelStrip


class ViewScreen(Screen[None]):
    """The screen of the pane."""

    def get_style_at(self, x: int, y: int) -> Style:
        """No style: a style would divide a row at each move of the mouse."""
        del x, y
        return Style.null()


class ViewPane(Widget, can_focus=False):
    """Holds the newest cells for Textual's own drawing, and notes the rows that it draws.

    Textual draws at the start, at a new size, and when a list or a question opens or closes. The
    painter draws the rest.

    Attributes:
        cells: The newest cells, in the terminal's colours; None before the first.
        pictures: Pictures in the newest view with more pixels than the cells.
    """

    DEFAULT_CSS = "ViewPane { width: 100%; height: 100%; background: black; }"

    def __init__(self, half: str = UPPER_HALF) -> None:
        """Prepare; `half` is the half block to draw with."""
        super().__init__()
        self._half = half
        self.cells: Cells | None = None
        self.pictures: Collection[SeenPicture] = ()
        self._looks: Looks | None = None
        self._drawn: set[int] = set()

    def show(self, cells: Cells, pictures: Collection[SeenPicture]) -> None:
        """Keep the newest view, with cells in the terminal's colours."""
        self.cells, self.pictures, self._looks = cells, pictures, None

    def drawn_rows(self) -> npt.NDArray[np.intp]:
        """Rows that Textual has drawn since the last call."""
        rows, self._drawn = sorted(self._drawn), set()
        return np.array(rows, np.intp)

    def render_lines(self, crop: Region) -> list[Strip]:
        """The rows of `crop`; cells outside the newest frame are blank."""
        self._drawn.update(range(crop.y, crop.bottom))
        return [self._row(number).crop(crop.x, crop.right) for number in range(crop.y, crop.bottom)]

    def _row(self, number: int) -> Strip:
        cells = self.cells
        if cells is None or number >= cells.rows or cells.columns < self.size.width:
            # The terminal has grown, and the next frame is not drawn yet.
            return Strip.blank(self.size.width)
        if self._looks is None:
            self._looks = looks_of(cells, self.pictures)
        return PixelStrip(cells, self._looks, number, 0, cells.columns, self._half)
