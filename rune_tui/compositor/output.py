"""Where a view goes: an output makes bytes of cells and of the pictures in them.

Only an output knows what stands for a pixel: half blocks, quadrants, or what a file has.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.looks import Flags
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.raster.urgency import Urgencies


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """The bytes to write, in this order; either may be empty.

    Attributes:
        first: What is around the camera's picture: stops and alarms, drive state, ranges, all else.
        picture: The camera's picture, where an output writes it apart.
    """

    first: bytes = b""
    picture: bytes = b""

    @property
    def size(self) -> int:
        """Length of both [bytes]."""
        return len(self.first) + len(self.picture)


class Output(Protocol):
    """Something that shows a view."""

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture that it shows across and down a cell, the latter an even number."""
        ...

    def draw(self, cells: Cells, pictures: Collection[SeenPicture], urgencies: Urgencies) -> Frame:
        """What to write for a view.

        Args:
            cells: The view.
            pictures: Those in it that have more pixels than the cells, from back to front.
            urgencies: What each cell shows, shape (rows, columns).
        """
        ...


class TerminalOutput(Output, Protocol):
    """An output that knows what a terminal shows, and writes only what it does not show yet."""

    @property
    def inexact(self) -> bool:
        """Whether the terminal may show less than the newest view says."""
        ...

    @property
    def behind(self) -> bool:
        """Whether the last frame had no room for all that is around the picture."""
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
            pictures: Those in it that have more pixels than the cells, from back to front.
            urgencies: What each cell shows, shape (rows, columns).
            covered: Cells that something else covers, shape (rows, columns).
        """
        ...

    def refine(self, covered: Flags | None = None) -> Frame:
        """What makes the picture more exact, no longer than there is room for."""
        ...

    def forget(self, where: Flags | None = None) -> None:
        """Forget what the terminal shows.

        Args:
            where: In which cells, shape (rows, columns); None for all.
        """
        ...
