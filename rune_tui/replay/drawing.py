"""Draws the frames of a recording with the console's own view."""

from __future__ import annotations

import copy
import dataclasses
import enum

from rune_tui.compositor.cells import Cells
from rune_tui.model.console_state import ConsoleState
from rune_tui.replay.source import ReplayFrame
from rune_tui.view import View


class FrameCheck(enum.Enum):
    """Whether a frame is the one that the console drew; the value says it in words.

    Attributes:
        SAME: It is, by its checksum.
        OTHER: It is not.
        OTHER_SIZE: It is drawn at another size, so it cannot be.
        UNKNOWN: The recording does not say.
    """

    SAME = "same as then"
    OTHER = "not as then"
    OTHER_SIZE = "not compared: other size"
    UNKNOWN = ""


USUAL = (120, 40)
"""Columns and rows where neither a terminal nor the recording has a size [cells]."""


class FrameDrawer:
    """Draws frames in the order of time.

    Attributes:
        cells: What is shown; None before the first frame.
        view: The view; None before the first frame.
    """

    def __init__(self, size: tuple[int, int] | None = None) -> None:
        """Draw at a size [cells]; None: at the size of the console that was recorded."""
        self.cells: Cells | None = None
        self.view: View | None = None
        self._size = size
        self._opened: tuple[object, int] = None, 0
        self._arranged = 0
        self._checksum: int | None = None
        self._recorded_size: tuple[int, int] | None = None

    @property
    def check(self) -> FrameCheck:
        """Whether what is shown is what the console drew."""
        if self._recorded_size is None or self.cells is None:
            return FrameCheck.UNKNOWN
        if (self.cells.columns, self.cells.rows) != self._recorded_size:
            return FrameCheck.OTHER_SIZE
        if self._checksum is None:
            return FrameCheck.UNKNOWN
        return FrameCheck.SAME if self.cells.checksum == self._checksum else FrameCheck.OTHER

    @property
    def memory_s(self) -> float:
        """How long ago what the viewports show may have been [s]."""
        shown = [pane.visualizer for pane in self.view.panes] if self.view is not None else []
        return max((getattr(each, "memory_s", 0.0) for each in shown), default=0.0)

    def draw(self, frame: ReplayFrame) -> Cells | None:
        """The cells of a frame; None if they did not change."""
        view, state = self._prepared(frame)
        cells = view.render(state)
        self.cells = cells or self.cells
        return cells

    def feed(self, frame: ReplayFrame) -> None:
        """Take a frame into the memories of the view, without drawing it."""
        view, state = self._prepared(frame)
        view.feed(state)

    def copied(self) -> FrameDrawer:
        """A drawer with the same memories, which goes on by itself."""
        twin = copy.copy(self)
        twin.view = self.view.copied() if self.view is not None else None
        return twin

    def _prepared(self, frame: ReplayFrame) -> tuple[View, ConsoleState]:
        self._recorded_size = frame.size
        if frame.checksum is not None:
            self._checksum = frame.checksum
        view, opened = self.view, (frame.layout, frame.opened)
        size = self._size or frame.size or USUAL
        if view is None or opened != self._opened:
            # Its own time does not count, but the recorded one.
            view = View(frame.layout, lambda: 0.0, pixels_per_cell=frame.pixels_per_cell)
            self.view = view
            self._opened, self._arranged = opened, frame.arranged
        if (view.columns, view.rows) != size or frame.arranged != self._arranged:
            view.resize(*size)
        self._arranged = frame.arranged
        view.times.given = frame.slow
        state = dataclasses.replace(
            frame.state, places=view.places, attention=view.attention, rows=view.rows
        )
        return view, state
