"""The open layout, its view and widgets, and the console's own state."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

from hub.command_line import login_name
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState, carried_over
from rune_tui.view import View


class CurrentLayout:
    """Holds the objects that another layout replaces.

    Attributes:
        layout: The open layout.
        view: Draws it.
        dispatch: Runs its widgets.
        console: The console's own state; `LiveState` adds the state of its parts.
    """

    def __init__(
        self,
        layout: LayoutSpec,
        operator: str,
        *,
        pixels_per_cell: tuple[int, int],
        aspect: float,
    ) -> None:
        """Open the first layout.

        Args:
            layout: The layout.
            operator: The operator's name; empty: the user's name.
            pixels_per_cell: Pixels of a picture across and down a cell of the terminal.
            aspect: Height of the terminal's cells over their width.
        """
        self.layout = layout
        self._pixels_per_cell = pixels_per_cell
        self.view = View(layout, pixels_per_cell=pixels_per_cell)
        self.dispatch = Dispatch(layout)
        start = ConsoleState.at_start(layout, time.monotonic(), operator or login_name())
        self.console = dataclasses.replace(start, pixel_height=aspect / 2.0)

    def open(self, layout: LayoutSpec, columns: int, rows: int) -> None:
        """Open another layout on a terminal of this size [cells]."""
        view, dispatch = View(layout, pixels_per_cell=self._pixels_per_cell), Dispatch(layout)
        view.resize(columns, rows)
        self.view, self.dispatch = view, dispatch
        self.console = carried_over(self.console, layout)
        self.layout = layout

    def change(self, **changes: Any) -> None:  # noqa: ANN401 - the fields have several types
        """Change fields of the console's own state."""
        self.console = dataclasses.replace(self.console, **changes)
