"""The console's state now, from the states of its parts."""

from __future__ import annotations

import dataclasses
import time

from rune_tui.files.recorder import Recorder
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.ui.current_layout import CurrentLayout
from rune_tui.ui.input_events import InputEvents
from rune_tui.ui.painter import Painter


class LiveState:
    """Builds one immutable state on request."""

    def __init__(
        self,
        current: CurrentLayout,
        inputs: InputEvents,
        links: RobotLinks,
        painter: Painter,
        recorder: Recorder,
    ) -> None:
        """Prepare.

        Args:
            current: The open layout.
            inputs: Held inputs and joysticks.
            links: Links to the robots.
            painter: State of the terminal's picture.
            recorder: State of the recording.
        """
        self._current = current
        self._inputs = inputs
        self._links = links
        self._painter = painter
        self._recorder = recorder

    @property
    def now(self) -> ConsoleState:
        """The console's state now."""
        view, keyboard = self._current.view, self._inputs.keyboard
        return dataclasses.replace(
            self._current.console,
            now=time.monotonic(),
            places=view.places,
            attention=view.attention,
            rows=view.rows,
            clock=time.strftime("%H:%M:%S"),
            held=keyboard.held,
            must_release=keyboard.must_release,
            tap_first=keyboard.tap_first,
            hold_s=keyboard.hold_s,
            robots=self._links.states,
            display=self._painter.display(time.monotonic()),
            recording=self._recorder.path,
            joysticks=self._inputs.joysticks.states,
        )
