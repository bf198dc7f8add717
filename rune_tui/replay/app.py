"""The review console on a terminal: draws a replay 30 times a second, and handles its keys."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import ClassVar

from textual import events
from textual.app import ComposeResult

from hub.plain_text import plain
from rune_tui.compositor.cells import Cells
from rune_tui.replay.clip_writer import ClipWriter
from rune_tui.replay.desk import Desk, no_urgencies
from rune_tui.replay.player import Knowledge, Player
from rune_tui.replay.review_keys import SHORT
from rune_tui.replay.review_notes import ReviewNotes
from rune_tui.replay.source import Overview, with_notes
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.terminal.traits import Traits
from rune_tui.ui.driver_reports import FrameAnswered, KeyMoved
from rune_tui.ui.ending import force_end_later, run_on_termination
from rune_tui.ui.frame_clock import FRAME_S
from rune_tui.ui.mouse import MouseApp
from rune_tui.ui.painter import Painter
from rune_tui.ui.terminal import terminal_driver
from rune_tui.ui.textual_inside import driver_of
from rune_tui.ui.view_pane import ViewPane, ViewScreen

_BUSY_S = 0.025
"""Longest time to take frames before the next one is drawn [s]."""
_LATER_S = 0.2 * FRAME_S
"""Time for frames that later jumps need, at each turn [s]: a fifth of a processor."""
_NOW_S = 0.6 * FRAME_S
"""Time for frames that the shown one needs to be exact, at each turn of a pause [s]."""


class ReplayApp(MouseApp, inherit_bindings=False):
    """Shows a recording; it reaches no robot.

    Attributes:
        desk: What the keys do.
    """

    ALLOW_SELECT = False
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = []
    CSS = "Screen { layers: view; overflow: hidden; }"

    def __init__(
        self,
        player: Player,
        traits: Traits,
        round_trip: float = 0.0,
        *,
        notes: ReviewNotes,
        clips: ClipWriter,
    ) -> None:
        """Prepare.

        Args:
            player: Plays the recording.
            notes: Keeps what the person notes.
            clips: Writes clips.
            traits: Abilities of the terminal.
            round_trip: Answer time of the terminal [s].
        """
        super().__init__(driver_class=terminal_driver())
        self.title = plain(f"RECORDING {player.source.title}")
        self._notes = notes
        self.desk = Desk(player, time.monotonic, notes, clips)
        self.desk.say(notes.fault or SHORT)
        self._pane = ViewPane(traits.glyphs.half)
        self._painter = Painter(self, self._pane, traits, round_trip)
        self._look: tuple[int, int, object, Cells | None] = (0, 0, None, None)
        self._found: Overview | None = None

    def get_default_screen(self) -> ViewScreen:
        """The screen below everything."""
        return ViewScreen(id="_default")

    def compose(self) -> ComposeResult:
        """One pane."""
        yield self._pane

    def on_mount(self) -> None:
        """Show the first frame, and start the clock."""
        run_on_termination(asyncio.get_running_loop(), self._leave)
        driver = driver_of(self)
        if driver is not None and not self.is_headless:
            driver.write(f"\x1b]2;{self.title}\x07")
        self.desk.fit(*self.size)
        self.set_interval(FRAME_S, self._turn)
        threading.Thread(target=self._survey, name="overview", daemon=True).start()

    def _survey(self) -> None:
        """Find what happened, in a thread of its own."""
        self._found = self.desk.player.survey()

    def on_resize(self, event: events.Resize) -> None:
        """Follow the terminal's size."""
        self.desk.fit(event.size.width, event.size.height)

    def on_key(self, event: events.Key) -> None:
        """Handle a key."""
        event.stop()
        event.prevent_default()
        self._press(event.key, event.character)

    def on_key_moved(self, event: KeyMoved) -> None:
        """Handle a key on a terminal that reports releases."""
        if event.move is not KeyMove.RELEASE:
            self._press(event.key, event.character)

    def mouse(
        self, event: events.MouseEvent, part: str, *, pressed: bool = True, value: float = 1.0
    ) -> None:
        """Handle a click on the timeline, and the wheel."""
        if part == "left" and pressed:
            self.desk.click(int(event.screen_x), int(event.screen_y), *self.size)
        elif part == "wheel":
            self.desk.go(value)

    def on_frame_answered(self, event: FrameAnswered) -> None:
        """Note that the terminal shows a frame."""
        self._painter.answered(event.when, event.report)

    async def action_quit(self) -> None:
        """End."""
        self._leave()

    def _press(self, key: str, character: str | None) -> None:
        self.desk.key(key, character)
        if self.desk.ended:
            self._leave()

    def _turn(self) -> None:
        now, player = time.monotonic(), self.desk.player
        if self._found is not None:
            self.desk.overview = with_notes(self._found, self._notes.events)
            self._found = None
        self.desk.settle()
        player.tick(now, time.monotonic, _BUSY_S)
        if self._painter.ready(now):
            self._paint(now)
        waits = player.knows is not Knowledge.ALL and not player.playing
        player.prepare(time.monotonic, _NOW_S if waits else _LATER_S)

    def _paint(self, now: float) -> None:
        columns, rows = self.size
        words = self.desk.helps, self.desk.words(columns)
        look = columns, rows, words, self.desk.player.drawer.cells
        cells = None
        if self._look[:3] != look[:3] or self._look[3] is not look[3]:
            self._look = look
            cells = self.desk.cells(columns, rows)
        self._painter.paint(now, cells, (), no_urgencies(columns, rows))

    def _leave(self) -> None:
        force_end_later()
        self.exit()
