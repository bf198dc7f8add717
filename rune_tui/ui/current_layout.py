"""The layout that is open, what was made of it, and what the console itself is doing."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

from rune_tui.dispatch import Dispatch
from rune_tui.files.user_files import operator_name
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState, carried_over
from rune_tui.terminal.traits import Traits
from rune_tui.view import View


class CurrentLayout:
    """Holds what another layout replaces.

    Attributes:
        layout: The open layout.
        view: Draws it.
        dispatch: Knows what its inputs do.
        console: What the console itself is doing; `LiveState` adds what its parts know.
    """

    def __init__(self, layout: LayoutSpec, traits: Traits, operator: str) -> None:
        """Open the first layout.

        Args:
            layout: The layout.
            traits: What the terminal can do.
            operator: The operator's name; empty: that of the user.
        """
        self.layout = layout
        self.view = View(layout, fine=traits.glyphs.fine)
        self.dispatch = Dispatch(layout)
        start = ConsoleState.at_start(layout, time.monotonic(), operator or operator_name())
        self.console = dataclasses.replace(start, pixel_height=traits.aspect / 2.0)

    def open(self, layout: LayoutSpec, columns: int, rows: int) -> None:
        """Go on with another layout on a terminal of this size [cells]."""
        view, dispatch = View(layout, fine=self.view.fine), Dispatch(layout)
        view.resize(columns, rows)
        self.view, self.dispatch = view, dispatch
        self.console = carried_over(self.console, layout)
        self.layout = layout

    def change(self, **changes: Any) -> None:  # noqa: ANN401 - the fields have several types
        """Change fields of the console's own state."""
        self.console = dataclasses.replace(self.console, **changes)
