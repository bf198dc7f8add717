"""Executes effects: on the console's state, its screen, robots and files."""

from __future__ import annotations

import asyncio
import dataclasses
import sys
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from hub.command_line import ExitCode
from hub.plain_text import plain
from rune_tui.files.file_writer import FileWriter
from rune_tui.files.user_files import Outcome, undelivered
from rune_tui.layout.actions import Action, actions_of
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.change_notifier import ChangeNotifier
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    AskEffect,
    AskToLeave,
    CalibrateEffect,
    ControlEffect,
    Effect,
    ExportEffect,
    LocalEffect,
    MissionEffect,
    NextLayoutEffect,
    Notify,
    OrderEffect,
    PaletteEffect,
    QuitEffect,
    RecordEffect,
    ReleaseFirst,
    ScreenshotEffect,
    SendEffect,
    StateEffect,
    SuspendEffect,
    TurnPage,
)
from rune_tui.model.leaving import ordered, reasons_to_stay
from rune_tui.model.limited_effects import confirms, within
from rune_tui.model.operating_limits import NO_LIMITS
from rune_tui.model.state_changes import changed
from rune_tui.model.team_events import TeamEvent, TeamWatch
from rune_tui.startup.following import LayoutFollower
from rune_tui.ui.covered import CoveredApp
from rune_tui.ui.current_layout import CurrentLayout
from rune_tui.ui.fault_guard import FaultGuard
from rune_tui.ui.input_events import InputEvents
from rune_tui.ui.palette import palette_of
from rune_tui.ui.question import Question
from rune_tui.ui.terminal import suspend
from rune_tui.ui.view_pane import ViewPane


class EffectRunner:
    """Executes effects in order; an effect that fails does not stop the next.

    Attributes:
        guard: Logs a fault and continues.
        file_writer: Writes files.
        layouts: Opens other layouts.
    """

    def __init__(
        self,
        app: CoveredApp,
        source: LayoutSource,
        current: CurrentLayout,
        inputs: InputEvents,
        links: RobotLinks,
        pane: ViewPane,
        state: Callable[[], ConsoleState],
        leave: Callable[[], None],
    ) -> None:
        """Prepare.

        Args:
            app: Shows lists and questions.
            source: The layouts on the command line.
            current: The open layout and the console's own state.
            inputs: Keys, mouse and joysticks; some effects release them.
            links: Links to the robots.
            pane: The newest picture.
            state: Returns the console's state now.
            leave: Ends the console.
        """
        self._app = app
        self._current = current
        self._inputs = inputs
        self._links = links
        self._pane = pane
        self._state = state
        self._leave = leave
        self._changes = ChangeNotifier()
        self._team = TeamWatch()
        self.guard = FaultGuard(self.notify)
        self.file_writer = FileWriter(
            links, partial(app.run_worker, exit_on_error=False), self.notify
        )
        self.layouts = LayoutFollower(
            source,
            self.open_layout,
            self.report_trouble,
            lambda news: self.notify(Outcome(text=news)),
        )

    def run(self, effects: Iterable[Effect]) -> None:
        """Execute some effects; the limits of a study's condition hold for all of them.

        After an order that does not reach its robot, the reason stays: later notices of that robot
        are dropped, as they confirm the order; alarms are not.
        """
        unreached: set[str] = set()
        if self._current.console.limits is not NO_LIMITS:
            effects = within(effects, self._state())
        for effect in effects:
            with self.guard(effect):  # the next effect may be a stop
                if isinstance(effect, OrderEffect):
                    self._send(effect)
                    if outcome := undelivered(effect, self._links[effect.robot].state):
                        self.notify(outcome)
                        unreached.add(effect.robot)
                elif not isinstance(effect, StateEffect):
                    self._do(effect)
                elif not confirms(effect, unreached):
                    self._change(effect)

    def notify(self, outcome: Outcome) -> None:
        """Show the operator a notice."""
        self._change(Notify.now(self._state(), **dataclasses.asdict(outcome)))

    def report_trouble(self, text: str) -> None:
        """Show the operator a trouble that stays."""
        self._current.change(trouble=text)
        self.notify(Outcome(text=text, alarm=True))

    async def open_layout(self, layout: LayoutSpec) -> None:
        """Open another layout; links of robots in both layouts stay open."""
        self._inputs.release_all()
        self._current.open(layout, *self._app.size)
        gone = self._links.follow(layout)
        self._app.title = f"Rune {layout.path}"
        self._inputs.follow()
        self.file_writer.recorder.follow(layout)
        self.notify(Outcome(text=f"opened {layout.path}"))
        self._inputs.name_unreported_keys()
        self.ask_for_pictures()
        for link in gone:
            await asyncio.to_thread(link.close)

    def record_into(self, folder: Path) -> None:
        """Record from now on, into a file in a folder."""
        self.file_writer.recorder.folder = folder
        self.run((RecordEffect(),))

    def end_recording(self) -> int:
        """End a running recording, and wait for its file.

        The view has ended, so standard error has the reason if the file lacks something.

        Returns:
            The console's exit code: `NOT_KEPT` if this or an earlier recording lacks something.
        """
        if not self.file_writer.recorder.path:
            return ExitCode.NOT_KEPT if self.file_writer.broken else ExitCode.OK
        outcome = self.file_writer.recorder.end()()
        if outcome.alarm:
            sys.stderr.write(f"rune: {plain(outcome.text)}\n")
        lacks = outcome.alarm or self.file_writer.broken
        return ExitCode.NOT_KEPT if lacks else ExitCode.OK

    def tick(self, now: float) -> None:
        """Record, report changes and tick the widgets; runs 20 times a second."""
        self._save_calibrations()
        self.file_writer.look()
        state = self._state()
        if state.display is not None:
            self.file_writer.recorder.note(now, state.display)
        self._record_team(self._team.look(state), now)
        self.run(Notify(notice=notice) for notice in self._changes.look(state))
        self.run(self._current.dispatch.tick(state))

    def leave_or_ask(self) -> None:
        """End, or ask once if a recording or a mission would be lost; the second call ends."""
        reasons = reasons_to_stay(self._state())
        if reasons and not self._current.console.leaving:
            self._change(AskToLeave(reasons=reasons))
        else:
            self._leave()

    def ask_for_pictures(self) -> None:
        """Request pictures of the shown size, rate and kind from each robot."""
        needs = self._current.view.picture_needs(self._state())
        wishes = self._current.console.wishes
        for name, link in self._links.items():
            link.want_pictures(needs.get(name, {}), wishes.get(name))

    def _change(self, effect: StateEffect) -> None:
        current = self._current
        if effect.ends_holds or (effect.moves_view and current.dispatch.button_held):
            self._inputs.release_all()
        current.console = changed(self._state(), effect)
        if isinstance(effect, TurnPage):
            current.console = current.view.within_page(current.console)
        self.ask_for_pictures()

    def _do(self, effect: LocalEffect) -> None:
        """Execute an effect on files, joysticks, the layout or the console itself."""
        match effect:
            case SuspendEffect():
                self._suspend()
            case PaletteEffect():
                self._inputs.release_all()
                self._app.push_screen(palette_of(actions_of(self._current.layout), self._act))
            case AskEffect():
                self._ask(effect)
            case ReleaseFirst(keys=keys):
                self._inputs.keyboard.stop(keys, time.monotonic())
            case QuitEffect():
                self.leave_or_ask()
            case ScreenshotEffect() | RecordEffect() | ExportEffect():
                state, cells, pictures = self._state(), self._pane.cells, self._pane.pictures
                self.file_writer.do(effect, self._current.layout, state, cells, pictures)
            case CalibrateEffect(joystick=name, control=control):
                self._inputs.joysticks.calibrate(name, control, time.monotonic())
            case NextLayoutEffect():
                if not self.layouts.next():
                    self.notify(Outcome(text="the console was started with no other layout"))

    def _suspend(self) -> None:
        self._inputs.release_all()
        if not suspend():
            self.notify(Outcome(text="Ctrl-Z does nothing here: no shell can resume the console"))

    def _ask(self, effect: AskEffect) -> None:
        self._inputs.release_all()

        def answered(text: str) -> None:
            with self.guard(effect):
                self.run(effect.answer(text, self._state()))

        stop = self._current.console.input_of(Purpose.STOP, effect.robot)
        self._app.push_screen(Question(effect.asked, effect.text, answered, stop))

    def _act(self, action: Action) -> None:
        self.run(self._current.dispatch.act(action, self._state()))

    def _save_calibrations(self) -> None:
        joysticks = self._inputs.joysticks
        if joysticks.unsaved:
            joysticks.unsaved = False
            self.file_writer.write_calibrations(joysticks.store)

    def _record_team(self, events: Iterable[TeamEvent], now: float) -> None:
        for event in events:
            self.file_writer.recorder.note_team(now, event)

    def _send(self, effect: OrderEffect) -> None:
        link = self._links[effect.robot]
        if isinstance(effect, SendEffect):
            link.send(effect.definition, effect.value)
            self._current.console = ordered(self._current.console, effect, time.monotonic())
            if effect.controlled and self._team.awaits_command(self._current.console.chosen):
                state = self._state()
                self._record_team(self._team.command(effect.robot, state), state.now)
        elif isinstance(effect, ControlEffect):
            link.control(effect.action, by_driving=effect.by_driving)
        elif isinstance(effect, MissionEffect):
            link.mission(effect.action, effect.name)
        elif link.recorder is not None:
            link.recorder.order(effect.command)
