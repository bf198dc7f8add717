"""Turns reports of the terminal and of joysticks into control events, and executes their effects.

Events that release all inputs:

| event | reason |
| --- | --- |
| the console was paused | moves in the pause are unknown |
| the terminal loses the focus, or stops to report releases | a release would be lost |
| text is pasted, or other keys are dropped | text must not drive |
| a mouse button is held, and the terminal does not answer for 1 s | a release may be lost |
| a mouse button is held, and the mouse moves with no button down | its release was lost |
| another layout opens, or another arrangement below a held button | the button's target moved |
"""

from __future__ import annotations

import asyncio
import dataclasses
import math
import time
from collections.abc import Callable, Collection, Iterable
from typing import Final

from textual import events

from hub.own_pauses import OwnPauses
from rune_tui.controls.devices import local_devices
from rune_tui.controls.events import PAUSE_S, STALE_S, ControlEvent
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick_set import Joysticks
from rune_tui.controls.joystick_sources import Sources
from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.files.recorder import Recorder
from rune_tui.layout.key_notes import unreported_keys
from rune_tui.layout.names import JOYSTICK, MOUSE, WAY_OUT
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify
from rune_tui.model.own_records import InputOutcome
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.ui.covered import CoveredApp
from rune_tui.ui.current_layout import CurrentLayout
from rune_tui.ui.driver_reports import KeyMoved, KeysDropped
from rune_tui.ui.input_record import input_record
from rune_tui.ui.key_names import KeyNames
from rune_tui.ui.painter import Painter
from rune_tui.ui.waking import waker

_UNHEARD_S: Final = 1.0
"""Silence of an answering terminal that releases a held mouse button [s]."""
_FOCUSING_S: Final = 0.3
"""Longest time from a focusing click to its report; the click has no other effect [s]."""
_PASTED: Final = "pasted text presses no keys"
_BROKEN: Final = "the terminal sent part of a key: pause, then press it again"
_WITHHELD: Final = "control is withheld for now; only a stop works"
_MOMENTARY: Final = (MOUSE + "wheel", MOUSE + "motion")
"""Inputs that are never released."""


class InputEvents:
    """Handles reports of the terminal and of joysticks.

    Attributes:
        names: What keys mean.
        keyboard: The held keys.
        joysticks: The joysticks of the open layout.
        recorder: Records the inputs; None: nothing does.
        withheld: Whether inputs do nothing but stop.
    """

    def __init__(
        self,
        app: CoveredApp,
        current: CurrentLayout,
        painter: Painter,
        links: RobotLinks,
        state: Callable[[], ConsoleState],
        execute: Callable[[Iterable[Effect]], None],
    ) -> None:
        """Prepare.

        Args:
            app: The console's app.
            current: The open layout with its widgets.
            painter: Says whether the terminal answers.
            links: Links to the robots; they bring joysticks of other machines too.
            state: Returns the console's state now.
            execute: Executes effects.
        """
        self._app = app
        self._current = current
        self._painter = painter
        self._links = links
        self._state = state
        self._execute = execute
        self.names = KeyNames(current)
        self.keyboard = KeyboardHold(self.names.drives)
        self.joysticks = Joysticks(
            current.layout.joysticks,
            Sources(local_devices.reader(), links.pads),
            CalibrationStore(),
        )
        self._pauses = OwnPauses(PAUSE_S, stale_s=STALE_S)
        self.recorder: Recorder | None = None
        self.withheld = False
        self._down: dict[str, ControlEvent] = {}
        self._recorded = ""
        self._used = -math.inf
        self._heard = 0.0
        self._focused = -math.inf

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """Start to read joysticks, and handle their events in this loop."""
        self.joysticks.start(waker(loop, self.joysticks_moved))

    def follow(self) -> None:
        """Follow another layout."""
        self.joysticks.follow(self._current.layout.joysticks, time.monotonic())

    def key(self, event: events.Key) -> None:
        """Handle a press or repeat of a key."""
        now = self.time_now()
        key, fine = self.names.named(event.key, event.character)
        stale = self.is_stale(now)
        pressed = self.keyboard.press(key, now, read=event.time, fine=fine, stale=stale)
        self._handle(pressed, event.time)
        self._name_unbound(key)

    def keys_dropped(self, event: KeysDropped) -> None:
        """Release all inputs, as these keys were not typed; a stop among them counts."""
        self.release_all()
        self.keyboard.drop(event.time)
        typed = self._app.covered and event.text
        for name in dict.fromkeys(map(self.names.stops, () if typed else event.keys)):
            if name:
                self.stop(name)
        if not typed:
            self._notify(_PASTED if event.pasted else _BROKEN)

    def pasted(self, when: float) -> None:
        """Release all inputs: text was pasted, and keys may follow that belong to it."""
        self.release_all()
        self.keyboard.drop(when)
        self._notify(_PASTED)

    def stop(self, name: str) -> None:
        """Run only the stop widgets of this input."""
        self._execute(self._current.dispatch.stopping(name, self._state()))

    def key_moved(self, event: KeyMoved) -> None:
        """Handle a key's move, on a terminal that reports releases."""
        now = self.time_now()
        key, fine = event.keypad, False
        if not (key and self._current.dispatch.waits_for(key)):
            key, fine = self.names.named(event.key, event.character, event.base)
        if event.move is KeyMove.RELEASE:
            self._handle(self.keyboard.up(key, now))
        elif self._app.covered or key == WAY_OUT:
            self._app.post_message(events.Key(event.key, event.character))
        else:
            repeat, stale = event.move is KeyMove.REPEAT, self.is_stale(now)
            moved = self.keyboard.down(key, now, repeat=repeat, fine=fine, stale=stale)
            self._handle(moved)
            self._name_unbound(key)

    @property
    def waiting(self) -> bool:
        """Whether reports of the terminal wait to be handled."""
        return self._app.message_queue_size > 0

    def _name_unbound(self, key: str) -> None:
        if text := self.names.unbound(key):
            self._notify(text)

    def is_stale(self, now: float) -> bool:
        """Whether an input that arrives now may be from a pause of the console."""
        return self._pauses.is_stale(now)

    def name_unreported_keys(self) -> None:
        """Name the layout's keys that this terminal cannot report, once for each layout."""
        console = self._current.console
        text = "" if console.releases_reported else unreported_keys(self._current.layout)
        if text and all(notice.text != text for notice in console.notices):
            self._notify(text)

    def mouse(self, event: events.MouseEvent, part: str, *, pressed: bool, value: float) -> None:
        """Handle a move of a part of the mouse; see `MouseApp.mouse`."""
        dispatch = self._current.dispatch
        if part == "motion" and dispatch.button_held and not event.button:
            self.release_all()
        if self._app.covered:
            return
        event.stop()
        now = self._heard = self.time_now()
        meant = part and (self._current.console.paged or dispatch.waits_for(MOUSE + part))
        if not meant or self.is_stale(now):
            return
        # A cell is two pixels high; terminals report cells only.
        state = self._state()
        hits = self._current.view.hits(int(event.screen_x), 2 * int(event.screen_y) + 1, state)
        stray, name = pressed and now - self._focused < _FOCUSING_S, MOUSE + part
        moved = ControlEvent(name=name, pressed=pressed, value=value, hits=hits, stale=stray)
        self._give(moved, event.time)

    def joysticks_moved(self) -> None:
        """Handle the events of joysticks.

        Under a list or a question, and without the focus, a joystick can only stop.
        """
        now = self._after_pause()
        unseen = self._app.covered or not self._app.app_focus
        for event in self.joysticks.events(now):
            dispatch = self._current.dispatch
            if unseen and event.pressed:
                self.stop(event.name)
            elif not unseen and dispatch.waits_for(event.name):
                self._give(event, now)
        if unseen or self._current.console.paged:
            self._handle(self.joysticks.release_all(now))

    def focus(self) -> None:
        """Note the focus; the click that caused it has no other effect."""
        self._focused = self.time_now()
        if self.recorder is not None:
            self.recorder.note_focus(self._focused, on=True)

    def blur(self) -> None:
        """Release all inputs: without the focus, releases of keys do not arrive."""
        if self.recorder is not None:
            self.recorder.note_focus(time.monotonic(), on=False)
        self.release_all()

    def answered(self, now: float, asked: float | None) -> None:
        """Note an answer to a question of this time [s]; None: an older question."""
        self.keyboard.heard(now, asked)
        self._heard = now

    def tick(self, now: float) -> None:
        """Release expired keys, and report changes of joysticks; runs 20 times a second."""
        dispatch = self._current.dispatch
        self.keyboard.answers = self._painter.answers_itself
        self._record_held(now)
        if expired := self.keyboard.expire(now):
            state = self._state()
            effects = dispatch.handle_all(expired, state)
            for each in expired:
                self._note(each, effects, state, now)
            self._execute(effects)
        self.names.follow(self._links.states.values())
        unheard = self._painter.answers and now - self._heard > _UNHEARD_S
        if self._current.dispatch.button_held and unheard:
            self.release_all()  # a cut line brings no release
        for text in self.joysticks.tick(now):
            self._notify(text)

    def time_now(self) -> float:
        """The time now [s]; releases all inputs after a pause of the console or a stop."""
        now = self._after_pause()
        dispatch = self._current.dispatch
        if stopped := dispatch.stopped_robots(self._links.states.values()):
            self._execute(dispatch.end_holds(stopped, self._state()))
        return now

    def _after_pause(self) -> float:
        """The time now [s]; releases all inputs after a pause of the console."""
        now = time.monotonic()
        if self._pauses.look(now):
            self.release_all()
        return now

    def unused_for(self, now: float) -> float:
        """How long no input has been held or used [s]; withheld ones do not count.

        Negative: none was used since the console was away.
        """
        return 0.0 if self._down else now - self._used

    def forget_use(self) -> None:
        """Count the time without inputs from the next input on: the console was away."""
        self._used = math.inf

    def release_all(self) -> None:
        """Release all inputs."""
        now = time.monotonic()
        keys, axes = self.keyboard.release_all(now), self.joysticks.release_all(now)
        state = self._state()
        effects = self._current.dispatch.released(state)
        for each in keys:
            self._note(each, effects, state, now)
        self._execute(effects)
        self._handle(axes)
        self._down.clear()

    def _notify(self, text: str) -> None:
        self._execute((Notify.now(self._state(), text),))

    def _handle(self, control_events: Iterable[ControlEvent], read: float | None = None) -> None:
        """Handle events; `read` is the time at which their report was read [s]."""
        for event in control_events:
            self._give(event, time.monotonic() if read is None else read)

    def _give(self, event: ControlEvent, read: float) -> None:
        state = self._state()
        if self.withheld:
            self._withhold(event, state, read)
            return
        effects = self._current.dispatch.handle(event, state)
        self._note(event, effects, state, read)
        self._execute(effects)

    def _withhold(self, event: ControlEvent, state: ConsoleState, read: float) -> None:
        """Let an input do nothing but stop, and say so."""
        dispatch = self._current.dispatch
        if event.pressed and not event.name.startswith((MOUSE, JOYSTICK)):
            self.keyboard.drop(read)
        effects = dispatch.stopping(event.name, state) if event.pressed else ()
        if effects:
            self._note(event, effects, state, read)
            self._execute(effects)
            return
        if self.recorder is not None and self.recorder.path:
            record = input_record(event, dispatch.listeners.of(event), (), state, read)
            withheld = dataclasses.replace(record, outcome=InputOutcome.WITHHELD)
            self.recorder.note_input(withheld)
        if event.pressed and not event.repeat and dispatch.listeners.of(event):
            self._notify(_WITHHELD)

    def _note(
        self, event: ControlEvent, effects: Collection[Effect], state: ConsoleState, read: float
    ) -> None:
        """Note that an input was used; record it, and what became of it."""
        self._used = time.monotonic()
        self._record_held(self._used)
        if event.pressed and event.name not in _MOMENTARY:
            self._down[event.name] = event
        else:
            self._down.pop(event.name, None)
        self._record(event, effects, state, read)

    def _record(
        self, event: ControlEvent, effects: Collection[Effect], state: ConsoleState, read: float
    ) -> None:
        if self.recorder is not None and self.recorder.path:
            bound = self._current.dispatch.listeners.of(event)
            self.recorder.note_input(input_record(event, bound, effects, state, read))

    def note_taken(self, name: str, read: float, *, repeat: bool) -> None:
        """Record a key that another program takes; the console does not use it."""
        if self.recorder is not None and self.recorder.path:
            event = ControlEvent(name=name, pressed=True, repeat=repeat)
            self.recorder.note_input(input_record(event, (), (), self._state(), read))

    def _record_held(self, now: float) -> None:
        """Let a recording that begins have the inputs that are down."""
        path = self.recorder.path if self.recorder is not None else ""
        if path != self._recorded:
            self._recorded, state = path, self._state()
            for event in self._down.values():
                self._record(dataclasses.replace(event, repeat=True), (), state, now)
