"""The running console: connects its parts, starts and ends them.

`ui/input_events` handles inputs, `effect_runner` executes effects, `ui/frame_clock` draws,
`ui/current_layout` holds the open layout.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Iterable
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding

from rune_tui.effect_runner import EffectRunner
from rune_tui.layout.names import WAY_OUT
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify
from rune_tui.terminal.traits import Traits
from rune_tui.ui.covered import CoveredApp
from rune_tui.ui.current_layout import CurrentLayout
from rune_tui.ui.driver_reports import FrameAnswered, KeyMoved, KeysDropped, ReleasesReported
from rune_tui.ui.ending import force_end_later, run_on_termination
from rune_tui.ui.frame_clock import FrameClock
from rune_tui.ui.input_events import InputEvents
from rune_tui.ui.live_state import LiveState
from rune_tui.ui.painter import Painter
from rune_tui.ui.terminal import terminal_driver, terminal_record
from rune_tui.ui.view_pane import ViewPane, ViewScreen

_TICK_S = 0.05
_SETTLED_S = 4.0
"""Longest time from the start to the terminal's last answer [s]."""
_SWITCH_S = 0.5e-3
"""Python's thread switch interval; short, so that reports and commands do not wait [s]."""


class Console(CoveredApp, inherit_bindings=False):
    """The console on a terminal.

    Attributes:
        current: The open layout with its view and widgets.
        inputs: Keys, mouse and joysticks.
        effects: Executes the effects of inputs.
        leaving: Whether the console is ending.
    """

    ALLOW_SELECT = False  # the mouse drives and marks
    ENABLE_COMMAND_PALETTE = False  # Rune has its own
    BINDINGS: ClassVar = [Binding(WAY_OUT, "quit", priority=True, show=False)]
    """This key ends the console, with any layout and any open screen."""
    CSS = "Screen { layers: view; overflow: hidden; }"

    def __init__(
        self,
        source: LayoutSource,
        links: RobotLinks,
        traits: Traits,
        round_trip: float = 0.0,
        trouble: str = "",
    ) -> None:
        """Prepare.

        Args:
            source: The layouts on the command line.
            links: A link for each robot of the layout, not yet started.
            traits: Abilities of the terminal.
            round_trip: Answer time of the terminal [s].
            trouble: A fault at the start, for the operator; else empty.
        """
        super().__init__(driver_class=terminal_driver())
        self.title = f"Rune {source.layout.path}"
        self.leaving = False
        self._cancel_forced_end: Callable[[], None] = lambda: None
        self._trouble = trouble
        self._links = links
        self._pane = ViewPane(traits.glyphs.half)
        self._painter = painter = Painter(self, self._pane, traits, round_trip)
        self.current = current = CurrentLayout(
            source.layout,
            links.operator,
            pixels_per_cell=painter.pixels_per_cell,
            aspect=traits.aspect,
        )
        self.inputs = InputEvents(self, current, painter, links, self._state, self._execute)
        self.effects = EffectRunner(
            self, source, current, self.inputs, links, self._pane, self._state, self._leave
        )
        recorder = self.effects.file_writer.recorder
        recorder.terminal = terminal_record(traits, painter.pixels_per_cell)
        self.inputs.recorder = recorder
        self._live = LiveState(current, self.inputs, links, painter, recorder)
        self._frames = FrameClock(current, self.inputs, links, painter, self._state, recorder)

    @property
    def state(self) -> ConsoleState:
        """The console's state now."""
        return self._live.now

    def _state(self) -> ConsoleState:
        return self._live.now

    def _execute(self, effects: Iterable[Effect]) -> None:
        self.effects.run(effects)

    def get_default_screen(self) -> ViewScreen:
        """The screen below everything."""
        return ViewScreen(id="_default")

    def compose(self) -> ComposeResult:
        """One pane, which shows all viewports of the layout."""
        yield self._pane

    def run_to_end(self) -> int:
        """Run; stop the robots and close the links at every kind of end.

        Returns:
            The exit code: 1 after a fault; else 4 if a recording lacks something, else 0.
        """
        sys.setswitchinterval(_SWITCH_S)
        for link in self._links.values():
            link.start()
        try:
            self.run()
        finally:
            # It is for the terminal only: files and hubs may take longer to end.
            self._cancel_forced_end()
            self.inputs.release_all()
            self.inputs.joysticks.close()
            for link in self._links.values():
                link.close()
            kept = self.effects.end_recording()
        return kept if self.leaving and not self.return_code else 1

    def on_mount(self) -> None:
        """Start the clocks, and handle the system's signals to end."""
        loop = asyncio.get_running_loop()
        run_on_termination(loop, self._leave)
        self.app_resume_signal.subscribe(self, self._come_back)
        self.inputs.start(loop)
        self.run_worker(self._frames.run())
        self.set_interval(_TICK_S, self._tick)
        self.run_worker(self.effects.layouts.run())
        if self._trouble:
            self._execute((Notify.now(self.state, self._trouble, alarm=True),))
        self.set_timer(_SETTLED_S, self.inputs.name_unreported_keys)

    def _come_back(self, _: App[None]) -> None:
        """Restart drawing after another program used the terminal."""
        self.inputs.release_all()
        self._painter.restart()
        self.screen.refresh()

    def _tick(self) -> None:
        now = self.inputs.time_now()
        for link in self._links.values():
            link.attend()
        for part in (self.inputs, self.effects):
            with self.effects.guard(f"the tick of {type(part).__name__}"):
                part.tick(now)

    def on_resize(self, event: events.Resize) -> None:
        """Follow the terminal's size; request pictures no larger than it shows."""
        moved = self.current.view.resize(event.size.width, event.size.height)
        if moved and self.current.dispatch.button_held:
            self.inputs.release_all()  # the viewport moved away from the mouse
        self.effects.ask_for_pictures()
        self._frames.draw_now()

    def on_key(self, event: events.Key) -> None:
        """Handle a press or repeat of a key."""
        if not self.covered:
            event.stop()
            event.prevent_default()
            self.inputs.key(event)

    def acts_at_once(self, key: events.Key) -> bool:
        """Whether the driver must not hold a key back to see whether it is pasted."""
        return self.inputs.names.acts_at_once(key)

    def stop_key(self, event: events.Key) -> str:
        """The name of a key that stops a robot; empty if it stops none."""
        return self.inputs.names.stops(event)

    def stop_below(self, name: str) -> None:
        """Stop the robots that the key of this name stops."""
        self.inputs.stop(name)

    def on_key_moved(self, event: KeyMoved) -> None:
        """Handle a key's move, on a terminal that reports releases."""
        self.inputs.key_moved(event)

    def on_releases_reported(self, event: ReleasesReported) -> None:
        """Note whether the terminal reports releases of keys."""
        if not event.reported:
            self.inputs.release_all()  # else held keys would stay down
        self.current.change(releases_reported=event.reported)

    def mouse(
        self, event: events.MouseEvent, part: str, *, pressed: bool = True, value: float = 1.0
    ) -> None:
        """Handle a move of a part of the mouse."""
        self.inputs.mouse(event, part, pressed=pressed, value=value)

    def on_frame_answered(self, event: FrameAnswered) -> None:
        """Note that the terminal shows a frame."""
        self._frames.answered(event)

    def on_paste(self, event: events.Paste) -> None:
        """Pasted text does not drive: release all inputs."""
        if not self.covered:
            self.inputs.pasted(event.time)

    def on_keys_dropped(self, event: KeysDropped) -> None:
        """Keys that were not typed do not drive; a line over the view takes their text."""
        self.inputs.keys_dropped(event)
        if self.covered and event.text:
            self.post_message(events.Paste(event.text))

    def on_app_focus(self) -> None:
        """Note that the terminal has the focus again."""
        self.inputs.focus()

    def on_app_blur(self) -> None:
        """Release all inputs: without the focus, releases of keys do not arrive."""
        self.inputs.blur()

    async def action_quit(self) -> None:
        """Ctrl-C: close open screens and ask to end, as the quit key does; the second time, end."""
        while self.covered:
            self.pop_screen()
        self.effects.leave_or_ask()

    def _leave(self) -> None:
        """End in order, or by force if the terminal blocks."""
        if self.leaving:
            return
        self.leaving = True
        self.inputs.release_all()
        self._cancel_forced_end = force_end_later()
        self.exit()
