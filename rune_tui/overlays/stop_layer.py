"""How to stop, in the lower left corner, where no viewport says it."""

from __future__ import annotations

from rune_tui.compositor.blend import Layer
from rune_tui.model.console_state import ConsoleState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.words.status_words import stop_words


class StopLayer:
    """Draws the words when they change.

    Attributes:
        layers: The words; empty if a viewport says them.
    """

    def __init__(self) -> None:
        self._look: tuple[object, ...] = ()
        self.layers: tuple[Layer, ...] = ()

    def refresh(
        self, columns: int, rows: int, zpos: int, state: ConsoleState, *, shown: bool
    ) -> bool:
        """Bring `layers` up to date.

        Args:
            columns: Width of the view [cells].
            rows: Height of the view [cells].
            zpos: Depth order of the layer.
            state: The console's state.
            shown: Whether a viewport says how to stop.

        Returns:
            Whether they changed.
        """
        words = "" if shown else stop_words(state.seen, state)[:columns]
        look = (columns, rows, zpos, state.theme.name, words)
        if look == self._look:
            return False
        before, self._look, self.layers = self.layers, look, ()
        if words:
            canvas = Canvas.blank(len(words), 2)
            canvas.fill(state.theme.panel)
            canvas.text(0, 0, words, state.theme.ink)
            self.layers = (
                Layer(canvas=canvas, x=0, y=2 * (rows - 1), zpos=zpos, urgency=Urgency.DRIVE),
            )
        return bool(before or self.layers)
