"""The layers of a picture of the view, and the cells that they make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rune_tui.compositor.blend import Layer, compose, tinted, urgencies_of
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.contrast import make_legible
from rune_tui.compositor.seen_pictures import SeenPicture, seen_pictures
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK
from rune_tui.raster.urgency import Urgencies


class ComposedLayers(NamedTuple):
    """What layers make.

    Attributes:
        cells: The cells.
        urgencies: Urgency of each cell, shape (rows, columns).
        pictures: Pictures in the cells that have more than one pixel per half cell.
    """

    cells: Cells
    urgencies: Urgencies
    pictures: tuple[SeenPicture, ...]


class DrawnLayers(NamedTuple):
    """The layers of a picture, before they are composed.

    Attributes:
        state: The state that they show.
        columns: Width of the view [cells].
        rows: Height of the view [cells].
        background: The layout's own red, green and blue behind all layers, for the dark theme.
        layers: The layers.
        fault: Whether they show that the picture cannot be made.
    """

    state: ConsoleState
    columns: int
    rows: int
    background: tuple[int, int, int] | None
    layers: Sequence[Layer]
    fault: bool = False

    def composed(self) -> ComposedLayers:
        """Blend the layers; text is legible over any picture."""
        theme = self.state.theme
        background = (self.background if theme is DARK else None) or theme.ground[:3]
        urgencies = urgencies_of(self.columns, self.rows, self.layers)
        cells = compose(self.columns, self.rows, background, self.layers)
        if self.fault:
            return ComposedLayers(cells, urgencies, ())
        tint = theme.tint
        make_legible(cells, tint)
        pictures = seen_pictures(cells, self.layers, tint)
        return ComposedLayers(tinted(cells, tint), urgencies, pictures)
