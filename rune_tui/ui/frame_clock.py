"""Draws the view at each tick of the clock, and when the terminal shows the last frame."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Final

from rune_tui.files.frame_log import DrawnFrame
from rune_tui.files.recorder import Recorder
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.ui.current_layout import CurrentLayout
from rune_tui.ui.driver_reports import FrameAnswered
from rune_tui.ui.input_events import InputEvents
from rune_tui.ui.painter import Painter

FRAME_S: Final = 1.0 / 30.0
"""Period of the clock [s]."""


class FrameClock:
    """Draws one frame at a time, from the newest state."""

    def __init__(
        self,
        current: CurrentLayout,
        inputs: InputEvents,
        links: RobotLinks,
        painter: Painter,
        state: Callable[[], ConsoleState],
        recorder: Recorder,
    ) -> None:
        """Prepare.

        Args:
            current: The open layout with its view.
            inputs: Says whether a held input needs answers of the terminal.
            links: Get notes about the pictures on the screen.
            painter: Writes the frames.
            state: Returns the console's state now.
            recorder: Records the frames.
        """
        self._current = current
        self._inputs = inputs
        self._links = links
        self._painter = painter
        self._state = state
        self._recorder = recorder
        self._drawing = False

    async def draw(self) -> None:
        """Draw if the terminal is ready; inputs are handled between the two halves."""
        if self._drawing or not self._painter.ready(time.monotonic()):
            return
        state, view, keyboard = self._state(), self._current.view, self._inputs.keyboard
        if keyboard.needs_answers or self._current.dispatch.button_held:
            self._painter.ask(state.now, soon=keyboard.hurries)
        cells = view.render(state)
        if self._recorder.path:
            drawn = DrawnFrame(
                columns=view.columns,
                rows=view.rows,
                arranged=view.arranged,
                cells=cells,
                slow=view.times.slow,
            )
            self._recorder.note_frame(state, drawn)
        self._drawing = cells is not None
        try:
            await asyncio.sleep(0)
        finally:
            self._drawing = False
        painter = self._painter
        if painter.paint(state.now, cells, view.pictures, view.urgencies):
            self._recorder.note_handed(state.now, answers=painter.answers)
        for name, robot in state.robots.items():
            for camera, picture in robot.all_pictures.items():
                self._links[name].shown(picture.number, camera)

    async def answered(self, event: FrameAnswered) -> None:
        """Draw the next frame at once, as the terminal shows the last one."""
        waited = not self._painter.ready(event.when)
        asked = self._painter.answered(event.when, event.report)
        if asked is not None:
            self._recorder.note_answered(asked, event.when)
        self._inputs.answered(event.when, asked)
        if waited:
            await self.draw()
