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
_MOST_TURNS: Final = 20
"""Most turns of the loop for inputs between two parts of a frame."""


class FrameClock:
    """Draws one frame at a time, from the newest state; inputs are handled between its parts."""

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
            inputs: Says whether inputs wait, and whether a held one needs answers of the terminal.
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
        self._due = asyncio.Event()

    async def run(self) -> None:
        """Draw until the console ends."""
        loop = asyncio.get_running_loop()
        next_tick = loop.time()
        while True:
            if (now := loop.time()) >= next_tick:
                next_tick = max(next_tick + FRAME_S, now)
            tick = loop.call_at(next_tick, self._due.set)
            await self._due.wait()
            tick.cancel()
            self._due.clear()
            await self._draw()

    def draw_now(self) -> None:
        """Draw at the next turn of the loop."""
        self._due.set()

    async def _draw(self) -> None:
        """Draw if the terminal is ready."""
        if not self._painter.ready(time.monotonic()):
            return
        state, view, keyboard = self._state(), self._current.view, self._inputs.keyboard
        if keyboard.needs_answers or self._current.dispatch.button_held:
            self._painter.ask(state.now, soon=keyboard.hurries)
        drawn, cells = view.draw(state), None
        size, arranged, slow = (view.columns, view.rows), view.arranged, view.times.slow
        if drawn is not None:
            await self._handle_inputs()
            cells = view.compose(drawn)
        if self._recorder.path:
            frame = DrawnFrame(
                columns=size[0], rows=size[1], arranged=arranged, cells=cells, slow=slow
            )
            self._recorder.note_frame(state, frame)
        await self._handle_inputs()
        painter = self._painter
        if painter.paint(state.now, cells, view.pictures, view.urgencies):
            self._recorder.note_handed(state.now, answers=painter.answers)
        for name, robot in state.robots.items():
            for camera, picture in robot.all_pictures.items():
                self._links[name].shown(picture.number, camera)

    async def _handle_inputs(self) -> None:
        """Let inputs that came meanwhile go first: a command must not wait for a whole frame."""
        for _ in range(_MOST_TURNS):
            await asyncio.sleep(0)
            if not self._inputs.waiting:
                return

    def answered(self, event: FrameAnswered) -> None:
        """Draw the next frame at once, as the terminal shows the last one."""
        waited = not self._painter.ready(event.when)
        asked = self._painter.answered(event.when, event.report)
        if asked is not None:
            self._recorder.note_answered(asked, event.when)
        self._inputs.answered(event.when, asked)
        if waited:
            self.draw_now()
