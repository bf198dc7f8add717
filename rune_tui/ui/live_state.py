"""The state of the console now: what it is doing, and what each of its parts knows."""

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
    """Puts together one immutable state whenever a part of the console asks."""

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
            inputs: Knows what is held and the joysticks.
            links: Know the robots.
            painter: Knows how the picture reaches the terminal.
            recorder: Knows what is recorded.
        """
        self._current = current
        self._inputs = inputs
        self._links = links
        self._painter = painter
        self._recorder = recorder

    @property
    def now(self) -> ConsoleState:
        """What the console is doing and what it knows now."""
        view, keyboard = self._current.view, self._inputs.keyboard
        return dataclasses.replace(
            self._current.console,
            now=time.monotonic(),
            places=view.places,
            rows=view.rows,
            clock=time.strftime("%H:%M:%S"),
            held=keyboard.held,
            must_release=keyboard.must_release,
            tap_first=keyboard.tap_first,
            hold_s=keyboard.hold_s,
            robots={name: link.state for name, link in self._links.items()},
            display=self._painter.display(time.monotonic()),
            recording=self._recorder.path,
            joysticks=self._inputs.joysticks.states,
        )
