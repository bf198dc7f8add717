"""Views as half blocks and quadrants: urgent cells first, then the picture as it fits."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from typing import Final

import numpy as np

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.compositor.looks import Flags, Looks, looks_of
from rune_tui.compositor.output import Frame, TerminalOutput
from rune_tui.compositor.quality import EXACT, Quality
from rune_tui.compositor.screen_encoder import ScreenEncoder
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.raster.urgency import Urgencies, Urgency
from rune_tui.terminal.rate import RateController

_CELL_BYTES: Final = 52
"""Largest size of a cell, with the move to it [bytes]."""


class BlockOutput(TerminalOutput):
    """Draws the newest view, the camera's picture only as exactly as there is room for."""

    def __init__(self, glyphs: GlyphSet, control: RateController) -> None:
        """Start with an unknown terminal content.

        Args:
            glyphs: The characters for pixels.
            control: Measures the line to the terminal.
        """
        self._glyphs = glyphs
        self._encoder = ScreenEncoder(half=glyphs.half)
        self._control = control
        self._newest: tuple[Looks, Flags] | None = None
        self._inexact = False
        self._behind = False
        self._row = 0

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture across and down a cell."""
        return self._glyphs.pixels_per_cell

    @property
    def inexact(self) -> bool:
        """Whether the terminal may show less than the newest view."""
        return self._inexact

    @property
    def behind(self) -> bool:
        """Whether the last frame had no room for all cells around the picture."""
        return self._behind

    def draw(
        self,
        cells: Cells,
        pictures: Collection[SeenPicture],
        urgencies: Urgencies,
        covered: Flags | None = None,
    ) -> Frame:
        """The next frame; see `TerminalOutput.draw`."""
        looks, video = looks_of(cells, pictures), urgencies == Urgency.VIDEO
        self._newest = looks, video
        before = self._encoder.remembered
        around = {"only": ~video, "urgencies": urgencies}
        first = self._encoder.encode(looks, EXACT, covered, **around)
        self._behind = len(first) > self._control.most_bytes
        if self._behind:
            self._encoder.return_to(before)
            most = max(1, int(self._control.room() / _CELL_BYTES))
            first = self._encoder.encode(looks, EXACT, covered, **around, most=most)
            return Frame(first=first)
        return Frame(first=first, picture=self._picture(cells, looks, video, covered))

    def refine(self, covered: Flags | None = None) -> Frame:
        """Bytes that make some rows of the picture more exact, within the room."""
        if self._newest is None or not self._inexact:
            return Frame()
        picture = self._some_rows(*self._newest, covered)
        self._inexact = bool(picture)
        return Frame(picture=picture)

    def forget(self, where: Flags | None = None) -> None:
        """Forget the terminal's content.

        Args:
            where: In which cells, shape (rows, columns); None for all.
        """
        self._encoder.forget(where)

    def _some_rows(self, looks: Looks, video: Flags, covered: Flags | None) -> bytes:
        """Exact bytes for wrong rows of the picture, within the room."""
        height, columns = video.shape
        rows = max(1, int(min(height, self._control.room() / (_CELL_BYTES * columns))))
        for _ in range(-(-height // rows) + 1):  # the first of them may begin between two
            only = video.copy()
            only[: self._row] = False
            only[self._row + rows :] = False
            written = self._encoder.encode(looks, EXACT, covered, only=only)
            self._row = self._row + rows if self._row + rows < height else 0
            if written:
                return written
        return b""

    def _picture(self, cells: Cells, looks: Looks, video: Flags, covered: Flags | None) -> bytes:
        before = self._encoder.remembered
        while True:
            way = self._control.way
            quality = Quality(tolerance=way.tolerance, threshold=way.threshold)
            drawn, only = looks, video
            if way.grain > 1:
                # A good cell must not become coarser again.
                only = video & self._encoder.wrong(looks, way.threshold)
                drawn = looks_of(coarsened(cells, way.grain))
            picture = self._encoder.encode(drawn, quality, covered, only=only)
            if not self._control.too_long(len(picture)):
                break
            self._encoder.return_to(before)
        if picture:
            self._control.drawn(len(picture))
        self._inexact = quality != EXACT or way.grain > 1
        return picture


def coarsened(cells: Cells, grain: int) -> Cells:
    """The cells with pixels in squares of this size, each with its mean colour.

    The last square of a row or column may be smaller.
    """
    pixels = cells.pixels
    height, width = pixels.shape[:2]
    tops, lefts = np.arange(0, height, grain), np.arange(0, width, grain)
    sums = np.add.reduceat(np.add.reduceat(pixels, tops, axis=0, dtype=np.uint32), lefts, axis=1)
    heights, widths = np.diff([*tops, height]), np.diff([*lefts, width])
    counts = (heights[:, None] * widths[None, :])[..., None]
    means = ((sums + counts // 2) // counts).astype(np.uint8)
    spread = np.repeat(np.repeat(means, heights, axis=0), widths, axis=1)
    return dataclasses.replace(cells, pixels=spread)
