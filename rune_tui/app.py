"""The running console: starts the links, and connects the way up and the way down.

Nothing here decides anything: what is drawn is up to `view`, what keys mean is up to `dispatch`.
"""

from __future__ import annotations

import asyncio
import dataclasses
import logging
import math
import sys
import time
from collections.abc import Iterable
from functools import partial
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding

from rune_tui.controls.devices import local_devices
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick_set import Joysticks
from rune_tui.controls.joystick_sources import Sources
from rune_tui.controls.keyboard import KeyboardHold, name_of_key, without_shift
from rune_tui.controls.pause_guard import StallGuard
from rune_tui.dispatch import Dispatch
from rune_tui.effect_runner import Deeds
from rune_tui.files import user_files
from rune_tui.files.file_writer import Filing
from rune_tui.layout.actions import Action, actions_of
from rune_tui.layout.key_notes import untold_keys
from rune_tui.layout.names import MOUSE, WAY_OUT
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.change_notifier import ChangeNotifier
from rune_tui.model.console_state import ConsoleState, carried_over
from rune_tui.model.effects import (
    AskEffect,
    AskToLeave,
    ChooseRobot,
    DeedEffect,
    Effect,
    FillView,
    PaletteEffect,
    QuitEffect,
    ReleaseFirst,
    ShowViewport,
    StateEffect,
    SuspendEffect,
    Tell,
    ToggleHelp,
    ToggleLog,
    TurnPage,
    changed,
)
from rune_tui.model.leaving import ordered, reasons_to_stay
from rune_tui.startup.following import LayoutFollower
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.terminal.traits import Traits
from rune_tui.ui.covered import CoveredApp
from rune_tui.ui.driver_reports import FrameAnswered, KeyMoved, ReleasesTold
from rune_tui.ui.ending import at_the_systems_end, end_anyway
from rune_tui.ui.painter import Painter
from rune_tui.ui.palette import palette_of
from rune_tui.ui.question import Question
from rune_tui.ui.sparing import Sparing
from rune_tui.ui.terminal import suspend, terminal_driver
from rune_tui.ui.view_pane import ViewPane, ViewScreen
from rune_tui.ui.waking import waker
from rune_tui.view import View

_logger = logging.getLogger(__name__)

_FRAME_S = 1.0 / 30.0
_TICK_S = 0.05
_SETTLED_S = 4.0
"""So long after the start the terminal has answered, and less is told of [s]."""
_UNHEARD_S = 1.0
"""So long a button of the mouse is held while nothing is heard of a terminal that answers [s]."""
_SWITCH_S = 0.5e-3
"""How long one thread may compute while another has a stick's report or a command to send [s]."""
_FOCUSING_S = 0.3
"""A click that comes no later than this after the terminal got the focus was to give it [s]."""


class Console(CoveredApp, inherit_bindings=False):
    """The console on a terminal."""

    ALLOW_SELECT = False  # the mouse drives and marks
    ENABLE_COMMAND_PALETTE = False  # ours opens where the layout does not want its key
    BINDINGS: ClassVar = [Binding(WAY_OUT, "quit", priority=True, show=False)]
    """Whatever the layout says and whatever is open, there is a way out."""
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
            source: What is shown, what keys do, and what may come instead of it.
            links: A connection for each robot of the layout, not yet started.
            traits: What the terminal can do.
            round_trip: How long it takes to answer [s].
            trouble: What does not work from the start, for the operator; empty if all does.
        """
        super().__init__(driver_class=terminal_driver())
        layout = source.layout
        self.title = f"Rune {layout.path}"
        self._trouble = trouble
        self._layouts = LayoutFollower(source, self._open, self._complain)
        self._shown_layout = layout
        self._links = links
        self._view = View(layout, fine=traits.glyphs.fine)
        self._dispatch = Dispatch(layout)
        operator = links.operator or user_files.operator_name()
        start = ConsoleState.at_start(layout, time.monotonic(), operator)
        self._console = dataclasses.replace(start, pixel_height=traits.aspect / 2.0)
        self._actions = actions_of(layout)
        self._watch = ChangeNotifier()
        self._keyboard = KeyboardHold(self._dispatch.waits_for_hold)
        self._joysticks = Joysticks(
            layout.joysticks, Sources(local_devices.reader(), links.pads), CalibrationStore()
        )
        self._stalls = StallGuard()
        self._sparing = Sparing(self._tell)
        self._leaving = self._drawing = False
        self._heard = 0.0
        self._focused = -math.inf
        beside = partial(self.run_worker, exit_on_error=False)
        self._filing = Filing(links, beside, self._tell)
        self._deeds = Deeds(links, self._filing, self._joysticks, self._layouts, self._tell)
        self._pane = ViewPane(traits.glyphs.half)
        self._painter = Painter(self, self._pane, traits, round_trip)

    def get_default_screen(self) -> ViewScreen:
        """The screen below everything."""
        return ViewScreen(id="_default")

    def compose(self) -> ComposeResult:
        """One pane for everything: the layout says what is in it."""
        yield self._pane

    def run_to_end(self) -> int:
        """Run; the robots are told to stand and the links are closed however it ends.

        Returns:
            The exit code: 0 if somebody ended it, 1 if it ended by a fault.
        """
        sys.setswitchinterval(_SWITCH_S)
        for link in self._links.values():
            link.start()
        try:
            self.run()
        finally:
            self._let_go()
            self._joysticks.close()
            for link in self._links.values():
                link.close()
            if self._filing.recorder.path:
                self._filing.recorder.end()()
        return 0 if self._leaving and not self.return_code else 1

    def on_mount(self) -> None:
        """Start the clocks, and end in order when the system asks."""
        loop = asyncio.get_running_loop()
        at_the_systems_end(loop, self._leave)
        self.app_resume_signal.subscribe(self, self._come_back)
        self._joysticks.start(waker(loop, self._joysticks_moved))
        self.set_interval(_FRAME_S, self._draw)
        self.set_interval(_TICK_S, self._tick)
        self.run_worker(self._layouts.run())
        if self._trouble:
            self._tell(user_files.Outcome(text=self._trouble, alarm=True))
        self.set_timer(_SETTLED_S, self._miss_keys)

    def _come_back(self, _: App[None]) -> None:
        """The terminal was somebody else's for a while."""
        self._let_go()
        self._painter.restart()
        self.screen.refresh()

    async def _open(self, layout: LayoutSpec) -> None:
        """Go on with another layout; links of robots that are in both stay as they are."""
        self._let_go()
        view, dispatch = View(layout, fine=self._view.fine), Dispatch(layout)
        view.resize(self.size.width, self.size.height)
        gone = self._links.follow(layout)
        self.title = f"Rune {layout.path}"
        self._view, self._dispatch = view, dispatch
        self._keyboard.drives = dispatch.waits_for_hold
        self._actions = actions_of(layout)
        self._console = carried_over(self._console, layout)
        self._shown_layout = layout
        self._joysticks.follow(layout.joysticks, time.monotonic())
        self._filing.recorder.follow(layout)
        self._tell(user_files.Outcome(text=f"opened {layout.path}"))
        self._miss_keys()
        self._ask_for_pictures()
        for link in gone:
            await asyncio.to_thread(link.close)

    def _complain(self, text: str) -> None:
        self._console = dataclasses.replace(self._console, trouble=text)
        self._tell(user_files.Outcome(text=text, alarm=True))

    async def on_resize(self, event: events.Resize) -> None:
        """Follow the terminal's size; from now on, ask for no larger pictures than it shows."""
        moved = self._view.resize(event.size.width, event.size.height)
        if moved and self._dispatch.button_held:
            self._let_go()  # what the mouse holds stands elsewhere now
        self._ask_for_pictures()
        await self._draw()

    def on_key(self, event: events.Key) -> None:
        """A key went down or repeats."""
        if self.covered:
            return
        event.stop()
        event.prevent_default()
        now = self._look_up()
        key, fine = self._named(event.key, event.character)
        stale = self._stalls.deaf(now)
        self._handle(self._keyboard.press(key, now, read=event.time, fine=fine, stale=stale))

    def stop_key(self, event: events.Key) -> str:
        """The name of a key that stops a robot; empty if it stops none."""
        name, _ = self._named(event.key, event.character)
        return name if self._dispatch.stops(name) else ""

    def stop_below(self, name: str) -> None:
        """Stop the robots that the key of this name stops."""
        self._execute(self._dispatch.stopping(name, self.state))

    def _named(self, key: str, character: str | None) -> tuple[str, bool]:
        """The name of a key, and whether Shift makes it finer; a layout may bind it with Shift."""
        name, plain = name_of_key(key, character), without_shift(key, character)
        fine = bool(plain) and (name == plain or not self._dispatch.waits_for(name))
        return (plain, True) if fine else (name, False)

    def on_key_moved(self, event: KeyMoved) -> None:
        """A key moved, on a terminal that tells when it goes up."""
        now = self._look_up()
        key, fine = event.keypad, False
        if not (key and self._dispatch.waits_for(key)):
            key, fine = self._named(event.key, event.character)
        if event.move is KeyMove.RELEASE:
            self._handle(self._keyboard.up(key, now))
        elif self.covered or key == WAY_OUT:
            self.post_message(events.Key(event.key, event.character))
        else:
            repeat, stale = event.move is KeyMove.REPEAT, self._stalls.deaf(now)
            moved = self._keyboard.down(key, now, repeat=repeat, fine=fine, stale=stale)
            self._handle(moved)

    def on_releases_told(self, event: ReleasesTold) -> None:
        """The terminal says whether it tells when keys go up."""
        if not event.told:
            self._let_go()  # what it has told of would be held for ever
        self._console = dataclasses.replace(self._console, releases_told=event.told)

    def _miss_keys(self) -> None:
        """Say, once for each layout, what of it this terminal cannot tell."""
        text = "" if self._console.releases_told else untold_keys(self._shown_layout)
        if text and all(notice.text != text for notice in self._console.notices):
            self._tell(user_files.Outcome(text=text))

    def mouse(
        self, event: events.MouseEvent, part: str, *, pressed: bool = True, value: float = 1.0
    ) -> None:
        """A part of the mouse moved; if it says that no button is down, none is."""
        if part == "motion" and self._dispatch.button_held and not event.button:
            self._let_go()
        if self.covered:
            return
        event.stop()
        now = self._heard = self._look_up()
        meant = part and (self._console.paged or self._dispatch.waits_for(MOUSE + part))
        if not meant or self._stalls.deaf(now):
            return
        # A cell is two pixels high; which of them the mouse is on, terminals do not tell.
        state = self.state
        hits = self._view.hits(int(event.screen_x), 2 * int(event.screen_y) + 1, state)
        stray, name = pressed and now - self._focused < _FOCUSING_S, MOUSE + part
        moved = ControlEvent(name=name, pressed=pressed, value=value, hits=hits, stale=stray)
        self._execute(self._dispatch.handle(moved, state))

    def _joysticks_moved(self) -> None:
        """Joysticks have something to tell.

        Below the list or a question, and behind another window, they only stop.
        """
        now = self._look_up()
        unseen = self.covered or not self.app_focus
        for event in self._joysticks.events(now):
            if unseen and event.pressed:
                self._execute(self._dispatch.stopping(event.name, self.state))
            elif not unseen and self._dispatch.waits_for(event.name):
                self._execute(self._dispatch.handle(event, self.state))
        if unseen or self._console.paged:
            self._handle(self._joysticks.release_all(now))

    async def action_quit(self) -> None:
        """Ctrl-C: ask as the layout's own key does; the second time, end whatever is open."""
        while self.covered:
            self.pop_screen()
        self._leave_if_sure()

    def on_paste(self) -> None:
        """Pasted text is no driving: let go of all."""
        self._let_go()

    def on_app_focus(self) -> None:
        """The terminal is in front again; the click that did that means nothing else."""
        self._focused = self._look_up()

    def on_app_blur(self) -> None:
        """Keys can go up unseen while the terminal is not in front: let go of all."""
        self._let_go()

    def _tick(self) -> None:
        now = self._look_up()
        for link in self._links.values():
            link.attend()
        for look in (self._look_at_hands, self._look_at_robots):
            with self._sparing(look.__name__):
                look(now)

    def _look_at_hands(self, now: float) -> None:
        self._keyboard.answers = self._painter.answers_itself
        self._execute(self._dispatch.handle_all(self._keyboard.expire(now), self.state))
        unheard = self._painter.answers and now - self._heard > _UNHEARD_S
        if self._dispatch.button_held and unheard:
            self._let_go()  # no release comes over a line that is cut
        for text in self._joysticks.tick(now):
            self._tell(user_files.Outcome(text=text))
        if self._joysticks.unsaved:
            self._joysticks.unsaved = False
            self._filing.keep_calibrations(self._joysticks.store)

    def _look_at_robots(self, now: float) -> None:
        state = self.state
        if state.display is not None:
            self._filing.recorder.note(now, state.display)
        self._execute(Tell(notice=notice) for notice in self._watch.look(state))
        self._execute(self._dispatch.tick(state))

    def _look_up(self) -> float:
        """The time now; nothing counts as held after a pause of the console, or a stop."""
        now = time.monotonic()
        if self._stalls.stalled(now):
            self._let_go()
        self._execute(self._dispatch.look(self.state))
        return now

    async def on_frame_answered(self, event: FrameAnswered) -> None:
        """The terminal shows a frame; the next need not wait for the clock."""
        waited = not self._painter.ready(event.when)
        self._keyboard.heard(event.when, self._painter.answered(event.when, event.report))
        self._heard = event.when
        if waited:
            await self._draw()

    async def _draw(self) -> None:
        """Draw in two halves: hands need not wait for both."""
        if self._drawing or not self._painter.ready(time.monotonic()):
            return
        state, view = self.state, self._view
        if self._keyboard.needs_answers or self._dispatch.button_held:
            self._painter.ask(state.now, soon=self._keyboard.hurries)
        cells = view.render(state)
        self._drawing = cells is not None
        try:
            await asyncio.sleep(0)
        finally:
            self._drawing = False
        self._painter.paint(state.now, cells, view.urgencies)
        for name, robot in state.robots.items():
            if robot.picture is not None:
                self._links[name].shown(robot.picture.number)

    def _leave_if_sure(self) -> None:
        """End, or ask first if something would be lost or left alone; the second time, end."""
        reasons = reasons_to_stay(self.state)
        if reasons and not self._console.leaving:
            self._change(AskToLeave(reasons=reasons))
        else:
            self._leave()

    def _leave(self) -> None:
        """End, in order if the terminal lets us."""
        if self._leaving:
            return
        self._leaving = True
        self._let_go()
        end_anyway()
        self.exit()

    def _handle(self, control_events: Iterable[ControlEvent]) -> None:
        for event in control_events:
            self._execute(self._dispatch.handle(event, self.state))

    def _let_go(self) -> None:
        now = time.monotonic()
        self._keyboard.release_all(now)
        released = self._joysticks.release_all(now)
        self._execute(self._dispatch.released(self.state))
        self._handle(released)

    def _execute(self, effects: Iterable[Effect]) -> None:
        for effect in effects:
            with self._sparing(effect):
                self._change(effect) if isinstance(effect, StateEffect) else self._do(effect)

    def _do(self, effect: DeedEffect) -> None:
        match effect:
            case SuspendEffect():
                self._suspend()
            case PaletteEffect():
                self._let_go()
                self.push_screen(palette_of(self._actions, self._act))
            case AskEffect():
                self._ask(effect)
            case ReleaseFirst(keys=keys):
                self._keyboard.stop(keys, time.monotonic())
            case QuitEffect():
                self._leave_if_sure()
            case _:
                self._console = ordered(self._console, effect, time.monotonic())
                self._deeds.do(effect, self._shown_layout, self.state, self._pane.cells)

    def _suspend(self) -> None:
        self._let_go()
        if not suspend():
            text = "Ctrl-Z does nothing here: no shell would have the console go on"
            self._tell(user_files.Outcome(text=text))

    def _ask(self, effect: AskEffect) -> None:
        self._let_go()

        def answered(text: str) -> None:
            with self._sparing(effect):
                self._execute(effect.answer(text, self.state))

        stop = self._console.input_of("widgetStop", effect.robot)
        self.push_screen(Question(effect.asked, effect.text, answered, stop))

    def _act(self, action: Action) -> None:
        self._execute(self._dispatch.act(action, self.state))

    def _tell(self, said: user_files.Outcome) -> None:
        self._change(Tell.now(self.state, **dataclasses.asdict(said)))

    def _change(self, effect: StateEffect) -> None:
        moved = isinstance(effect, ShowViewport | FillView) and self._dispatch.button_held
        asked = isinstance(effect, AskToLeave) and effect.reasons
        if moved or asked or isinstance(effect, ChooseRobot | ToggleHelp | ToggleLog):
            self._let_go()  # what is held was meant for the robot before, seen, and in its place
        self._console = changed(self.state, effect)
        if isinstance(effect, TurnPage):
            self._console = self._view.within_page(self._console)
        self._ask_for_pictures()

    def _ask_for_pictures(self) -> None:
        """Ask each robot for pictures of the size and kind that is shown."""
        sizes = self._view.picture_sizes(self.state)
        for name, link in self._links.items():
            link.want_pictures(sizes.get(name), self._console.wishes.get(name))

    @property
    def state(self) -> ConsoleState:
        """What the console is doing and what it knows now."""
        return dataclasses.replace(
            self._console,
            now=time.monotonic(),
            places=self._view.places,
            rows=self._view.rows,
            clock=time.strftime("%H:%M:%S"),
            held=self._keyboard.held,
            must_release=self._keyboard.must_release,
            tap_first=self._keyboard.tap_first,
            hold_s=self._keyboard.hold_s,
            robots={name: link.state for name, link in self._links.items()},
            display=self._painter.display(time.monotonic()),
            recording=self._filing.recorder.path,
            joysticks=self._joysticks.states,
        )
