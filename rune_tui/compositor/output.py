"""Outputs of a view: each encodes cells and pictures as bytes.

Only an output knows how a pixel is shown: half blocks, quadrants, or pixels of a file.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol

from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.looks import Flags
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.raster.urgency import Urgencies


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Bytes to write, in this order; each part may be empty.

    Attributes:
        first: All except the camera's picture: stops and alarms, drive state, ranges, the rest.
        picture: The camera's picture, if an output writes it separately.
    """

    first: bytes = b""
    picture: bytes = b""

    @property
    def size(self) -> int:
        """Length of both parts [bytes]."""
        return len(self.first) + len(self.picture)


class Output(Protocol):
    """Shows a view."""

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture across and down a cell; the second number is even."""
        ...

    def draw(self, cells: Cells, pictures: Collection[SeenPicture], urgencies: Urgencies) -> Frame:
        """Bytes of a view.

        Args:
            cells: The view.
            pictures: Pictures in it with more pixels than the cells, from back to front.
            urgencies: Urgency of each cell, shape (rows, columns).
        """
        ...


class TerminalOutput(Output, Protocol):
    """An output that remembers the terminal's screen and writes only the changes."""

    @property
    def inexact(self) -> bool:
        """Whether the terminal may show less detail than the newest view."""
        ...

    @property
    def behind(self) -> bool:
        """Whether the last frame had no room for all cells around the picture."""
        ...

    def draw(
        self,
        cells: Cells,
        pictures: Collection[SeenPicture],
        urgencies: Urgencies,
        covered: Flags | None = None,
    ) -> Frame:
        """The next frame.

        Args:
            cells: The view, in the terminal's colours.
            pictures: Pictures in it with more pixels than the cells, from back to front.
            urgencies: Urgency of each cell, shape (rows, columns).
            covered: Cells under another screen, shape (rows, columns).
        """
        ...

    def refine(self, covered: Flags | None = None) -> Frame:
        """Bytes that make the picture more exact, up to the free room of the line."""
        ...

    def forget(self, where: Flags | None = None) -> None:
        """Forget the terminal's screen, in some cells of shape (rows, columns) or in all."""
        ...
