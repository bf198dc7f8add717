"""Writes frames to the terminal past Textual, which would style each cell.

Textual still draws the screen at times, and the lists over it. The painter draws these rows again,
except the cells under a list.
"""

from __future__ import annotations

import contextlib
import math
from collections import deque
from collections.abc import Collection, Iterator
from typing import Final

import numpy as np
import numpy.typing as npt
from textual.app import App
from textual.widget import Widget

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.output import Frame, TerminalOutput
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.model.display_state import DisplayState
from rune_tui.raster.urgency import Urgencies
from rune_tui.terminal.block_output import BlockOutput
from rune_tui.terminal.input_stream import CursorReport
from rune_tui.terminal.pacing import FramePacer
from rune_tui.terminal.rate import RateController
from rune_tui.terminal.traits import Traits
from rune_tui.ui.terminal import output_is_pending, output_was_lost
from rune_tui.ui.textual_inside import driver_of, write_bytes
from rune_tui.ui.view_pane import ViewPane

Flags = npt.NDArray[np.bool_]

_BEGIN: Final = b"\x1b[?2026h"
_END: Final = b"\x1b[?2026l"
_KEPT_BYTES: Final = 6
"""Most bytes per cell for tmux, which drops waiting output beyond 8 bytes per cell."""
_SELDOM_S: Final = 1 / 15 - 0.005
"""Shortest time between two frames for tmux, which hides the speed of its terminal [s]."""
_MUCH_BYTES: Final = 8_000
"""Size of a frame's picture that means a moving camera [bytes]."""
_STILL_S: Final = 0.15
"""Time after such a frame until the picture is refined [s]."""
_SILENT_S: Final = 0.2
"""Time without a frame until the terminal gets a question, if an answer is needed [s]."""
_SOON_S: Final = 0.03
"""The same, if a held input waits for the answer [s]."""
_COUNTED_S: Final = 1.0
"""Time over which frames are counted [s]."""


class Painter:
    """Writes the newest cells when the terminal is ready for a frame."""

    def __init__(
        self,
        app: App[None],
        pane: ViewPane,
        traits: Traits,
        round_trip: float,
    ) -> None:
        """Prepare.

        Args:
            app: The console's app.
            pane: The widget that Textual draws.
            traits: Abilities of the terminal.
            round_trip: Answer time of the terminal [s].
        """
        self._app = app
        self._pane = pane
        self._traits = traits
        self._pacer = FramePacer(heard=traits.acknowledges)
        self.control = RateController(round_trip)
        self._output: TerminalOutput = BlockOutput(traits.glyphs, self.control)
        self.urgencies: Urgencies = np.zeros((0, 0), np.uint8)
        self._latency = math.nan
        self._rests = False
        self._asked = self._moved = -math.inf
        self._sent: deque[tuple[float, int]] = deque()
        self._sent_bytes = 0

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture across and down a cell of the terminal."""
        return self._output.pixels_per_cell

    @property
    def answers(self) -> bool:
        """Whether the terminal answers the question after a frame, so that silence means delay."""
        return self._pacer.answers

    @contextlib.contextmanager
    def rest(self) -> Iterator[None]:
        """Write nothing, while another program has the terminal."""
        with self._app.batch_update():
            self._rests = True
            try:
                yield
            finally:
                self._rests = False

    def ready(self, now: float) -> bool:
        """Whether the terminal can take a frame now."""
        if self._rests:
            return False
        if output_is_pending(self._app) or not self._pacer.may_send(now):
            return False
        if self._traits.discards and self._sent and now - self._sent[-1][0] < _SELDOM_S:
            return False
        return not self._pacer.answers or self.control.may_follow(now, self._pacer.under_way)

    def paint(
        self,
        now: float,
        cells: Cells | None,
        pictures: Collection[SeenPicture],
        urgencies: Urgencies,
    ) -> bool:
        """Write the newest view, or a part of it; returns whether the terminal got any of it.

        Args:
            now: The time [s].
            cells: The newest cells in truecolour; None if they did not change.
            pictures: Pictures in the view with more pixels than the cells.
            urgencies: Urgency of each cell, shape (rows, columns).
        """
        if not self._pane.is_attached:
            return False  # the console is ending
        if output_was_lost(self._app):
            self._output.forget()
            self._app.screen.refresh()
        if cells is not None:
            self._pane.show(at_depth(cells, self._traits.depth), pictures)
            self.urgencies = urgencies
        newest = self._pane.cells
        if newest is None:
            return False
        if self._traits.discards:
            self.control.most_bytes = _KEPT_BYTES * newest.rows * newest.columns
        rows = self._pane.drawn_rows()
        if rows.size:
            drawn = np.zeros((newest.rows, newest.columns), np.bool_)
            drawn[rows[rows < newest.rows]] = True
            self._output.forget(drawn)
        frame = self.frame(now, newest, changed=cells is not None or bool(rows.size))
        if frame.size:
            self._write(now, frame)
        return bool(frame.size)

    def frame(self, now: float, newest: Cells, *, changed: bool) -> Frame:
        """Bytes that lead the terminal towards the newest cells."""
        covered = self.covered(newest)
        frame = Frame()
        if changed or self._output.behind:
            frame = self._output.draw(newest, self._pane.pictures, self.urgencies, covered)
        if len(frame.picture) > _MUCH_BYTES:
            self._moved = now
        # Together with the cells around the picture it could exceed tmux's limit.
        alone = not (frame.first and self._traits.discards)
        still = not frame.picture and now - self._moved > _STILL_S
        if alone and still and self._output.inexact:
            finer = self._output.refine(covered)
            frame = Frame(first=frame.first, picture=finer.picture)
        return frame

    @property
    def answers_itself(self) -> bool:
        """Whether no multiplexer answers for the terminal."""
        return self._pacer.answers and not self._traits.discards

    def ask(self, now: float, *, soon: bool = False) -> None:
        """Send a question, unless a frame did so recently.

        Args:
            now: The time [s].
            soon: Whether a held input waits for the answer.
        """
        asked = max((frame.sent for frame in self._pacer.under_way), default=self._asked)
        driver = driver_of(self._app)
        if driver is not None and now - max(asked, self._asked) > (_SOON_S if soon else _SILENT_S):
            driver.write(f"{self._pacer.sent(now, 0)}{self._cursor_return}")
            self._asked = now

    def answered(self, now: float, report: CursorReport) -> float | None:
        """Note the terminal's answer; returns the time of its question [s], or None without one."""
        answer = self._pacer.answered(now, report)
        if answer is None:
            return None
        self._latency = answer.age
        self.control.acknowledged(now, answer)
        return answer.frame.sent

    def restart(self) -> None:
        """Start again after another program used the terminal, or on another terminal."""
        self._pacer.restart()
        self._output.forget()

    def display(self, now: float) -> DisplayState:
        """State of the terminal's picture: delay, rate and detail."""
        while self._sent and now - self._sent[0][0] > _COUNTED_S:
            self._sent_bytes -= self._sent.popleft()[1]
        return DisplayState(
            latency=self._latency if self._pacer.answers else math.nan,
            frames_per_s=len(self._sent) / _COUNTED_S,
            bytes_per_s=self._sent_bytes / _COUNTED_S,
            coarseness=self.control.level if self._output.inexact else 0,
        )

    def _write(self, now: float, frame: Frame) -> None:
        driver = driver_of(self._app)
        if driver is None or self._app.is_headless:
            return
        begin, end = (_BEGIN, _END) if self._traits.synchronized else (b"", b"")
        parts = [begin + part + end for part in (frame.first, frame.picture) if part]
        question = f"{self._pacer.sent(now, frame.size)}{self._cursor_return}".encode()
        write_bytes(driver, b"".join((*parts, question)))
        self._sent.append((now, frame.size))
        self._sent_bytes += frame.size
        self._asked = now

    @property
    def _cursor_return(self) -> str:
        """Code that returns the hidden cursor to its place, where input methods write."""
        return f"\x1b[{self._app.cursor_position.y + 1};{self._app.cursor_position.x + 1}H"

    def covered(self, cells: Cells) -> Flags | None:
        """Cells under a list or a question; None if none is open."""
        screen = self._app.screen
        if screen is self._pane.screen:
            return None
        covered = np.zeros((cells.rows, cells.columns), np.bool_)
        # All descendants: the visible parts of the palette are inside invisible boxes.
        for widget in screen.walk_children(Widget):
            region = widget.region
            top, left = max(0, region.y), max(0, region.x)
            covered[top : max(0, region.bottom), left : max(0, region.right)] = True
        return covered
