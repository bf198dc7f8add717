"""The way down: which widgets a control event wakes, and what comes of it."""

from __future__ import annotations

import logging
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import cast

from hub.gcm.navigation import VELOCITY_COMMAND, Twist
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.actions import Action
from rune_tui.layout.names import JOYSTICK, MOUSE
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import EventSpec, LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import refusal, refused, taking
from rune_tui.model.control_changes import ControlChanges
from rune_tui.model.effects import (
    AskToLeave,
    Effect,
    Notify,
    QuitEffect,
    ReleaseFirst,
    SendEffect,
    ToggleHelp,
    ToggleLog,
    TurnPage,
)
from rune_tui.model.own_keys import own_key
from rune_tui.model.page import scrolled, turned
from rune_tui.widgets.driving import DrivingWidgets
from rune_tui.widgets.widget import TakingWidget, Widget, commanded

_logger = logging.getLogger(__name__)

_CLOSE = "escape"
_WHEEL = MOUSE + "wheel"
_WHEEL_LINES = 3
"""How far a notch of the mouse's wheel moves a page."""
_YES = "enter"
_TYPED_WHILE_AWAY = "what was typed while the console was held up does not count: press it again"
_CLICKED_TO_FOCUS = (
    "that click brought the terminal to the front and means nothing else: click again"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Listener:
    """An input pattern and the widget that waits for it."""

    widget: Widget
    spec: EventSpec
    viewport: str


class Dispatch:
    """All widgets of a layout, by the inputs that wake them.

    | case | what happens |
    | --- | --- |
    | two driving widgets of a robot | the one used last drives, see `DrivingWidgets` |
    | a stop | the robot's other widgets forget what is held |
    | a widget fails | the operator reads it once, and it rests until its next press |
    | a widget fails that drives | its robot gets zero speed as well |
    | another operator has control | what only the owner may send is not sent |
    | a new press drives a free robot | control is taken |
    | control changes | what is held no longer counts |
    | a page covers the view | keys of the stop, the page, the quit, the list and the shell count |
    | a key is stale | the keys of the stop, the help and the quit count |

    The caller executes the effects in order. Before it ends, and whenever it can no longer see
    the keys, it also executes those of `released`.
    """

    def __init__(self, layout: LayoutSpec) -> None:
        self._widgets: list[Widget] = []
        self._by_input: defaultdict[str, list[_Listener]] = defaultdict(list)
        self._buttons: set[str] = set()
        self._failed: set[int] = set()
        self._changes = ControlChanges()
        owners = [(viewport.robot, viewport.widgets) for viewport in layout.view.viewports]
        kinds = layout.vocabulary.widgets
        for robot, specs in (("", layout.view.widgets), *owners):
            for spec in specs:
                widget = cast("Widget", kinds[spec.handler].from_spec(spec, robot))
                self._widgets.append(widget)
                for event_spec in spec.events:
                    listener = _Listener(widget=widget, spec=event_spec, viewport=spec.viewport)
                    self._by_input[event_spec.name].append(listener)
        self._driving = DrivingWidgets(self._widgets)

    @property
    def button_held(self) -> bool:
        """Whether a button of the mouse is down that somebody waits for."""
        return bool(self._buttons)

    def waits_for(self, name: str) -> bool:
        """Whether an input of this name can have an effect."""
        return name in self._by_input

    def waits_for_hold(self, name: str) -> bool:
        """Whether something is done for as long as an input of this name is held."""
        return any(each.widget.rule.held for each in self._by_input.get(name, ()))

    def stops(self, name: str) -> bool:
        """Whether an input of this name stops a robot."""
        return bool(_of(self._by_input.get(name, ()), Purpose.STOP))

    def stopping(self, name: str, state: ConsoleState) -> tuple[Effect, ...]:
        """The stops of a key that means nothing else now."""
        event = ControlEvent(name=name, pressed=True)
        stops = _of(self._listeners(event), Purpose.STOP)
        return (*self.look(state), *self._woken(event, stops, state))

    def handle(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an event, from every widget that it matches."""
        return (*self.look(state), *self._handled(event, state))

    def handle_all(self, events: Iterable[ControlEvent], state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of events of one moment; of each robot's velocities only the last is sent.

        Of two keys that go up together, the second would else drive alone for no time.
        """
        effects = [effect for event in events for effect in self.handle(event, state)]
        last = {effect.driven: effect for effect in effects}
        return tuple(each for each in effects if last[each.driven] is each or not each.driven)

    def _handled(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        fresh = event.pressed and not event.repeat
        listeners = self._listeners(event)
        if event.must_release_first:
            listeners = [each for each in listeners if not each.widget.rule.held]
        elif event.proven:
            listeners = [each for each in listeners if each.widget.rule.held]
        self._note_button(event, listeners)
        if event.stale:
            return self._of_stale(event, state)
        if state.leaving and fresh and not event.name.startswith((MOUSE, JOYSTICK)):
            return self._answered(event, listeners, state)
        if state.paged:
            return self._paged(event, listeners, state)
        if fresh and event.name not in self._by_input:
            own = own_key(event.name)
            return () if own is None else (own.effect,)
        return self._woken(event, listeners, state)

    def _paged(
        self, event: ControlEvent, listeners: Iterable[_Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        """What an input does while a page lies over the view: the stop stops, whatever is typed."""
        if event.proven:
            return ()  # it was typed when it came; now it would only drive
        # What goes up is still told, but for what is done only then.
        safe = [
            each
            for each in listeners
            if each.widget.rule.under_help or not (event.pressed or each.spec.released)
        ]
        if not event.pressed:
            return self._woken(event, safe, state)
        stops = _of(safe, Purpose.STOP)
        stopping = self._woken(event, stops, state)
        if event.name == _WHEEL:
            page = scrolled(state.page, round(-_WHEEL_LINES * event.value))
        elif stops and event.name != _CLOSE:
            return stopping
        else:
            page = turned(state.page, event.name, state.rows)
        if page != state.page:
            return (TurnPage(page=page), *stopping)
        own = None if event.name in self._by_input else own_key(event.name)
        close = ToggleHelp() if state.help else ToggleLog()
        if own is not None and not event.repeat and (own.under_page or own.ends_page):
            return (close, own.effect) if own.ends_page else (own.effect,)
        if event.repeat or state.page.typing:
            return stopping
        if event.name == _CLOSE:
            return (close, *stopping)
        return self._woken(event, safe, state) if own is None else (own.effect,)

    def _answered(
        self, event: ControlEvent, listeners: Iterable[_Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        """What a key does while the operator is asked about the end of the console.

        Enter and the key that ends the console end it, the stop stops. All other keys mean to
        stay and do nothing else; one that drives must be released first.
        """
        if event.name == _YES and not self.stops(_YES):
            return (QuitEffect(),)
        safe = _of(listeners, Purpose.QUIT, Purpose.STOP)
        if safe:
            return self._woken(event, safe, state)
        stay = AskToLeave(reasons=())
        driving = any(each.widget.rule.held for each in listeners)
        return (stay, ReleaseFirst(keys=frozenset({event.name}))) if driving else (stay,)

    def _of_stale(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        """What a key does that may have been typed long ago: stop, help and quit, or nothing."""
        waiting = self._by_input.get(event.name, ())
        safe = [each for each in waiting if each.widget.rule.under_help]
        if safe:
            return self._woken(event, safe, state)
        meant = waiting or own_key(event.name) is not None
        text = _CLICKED_TO_FOCUS if event.name.startswith(MOUSE) else _TYPED_WHILE_AWAY
        return (Notify.now(state, text),) if meant and not event.repeat else ()

    def act(self, action: Action, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an action that somebody chose from a list, as if its first input was used."""
        spec = action.event
        chosen = [each for each in self._by_input.get(spec.name, ()) if each.spec is spec]
        press, release = (ControlEvent(name=spec.name, pressed=down) for down in (True, False))
        return (*self._woken(press, chosen, state), *self._woken(release, chosen, state))

    def _woken(
        self, event: ControlEvent, listeners: Iterable[_Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        effects: list[Effect] = []
        stopped: dict[str, None] = {}
        for listener in listeners:
            widget = listener.widget
            if event.pressed and not event.repeat:
                self._failed.discard(id(widget))
                self._driving.pressed(widget, listener.spec, state)
            elif id(widget) in self._failed:
                continue
            ask = partial(widget.handle, event, listener.spec, state)
            fresh = not event.repeat and event.pressed != listener.spec.released
            for effect in self._allowed(
                widget, self._asked(widget, ask, state), state, fresh=fresh
            ):
                effects.append(effect)
                if effect.stopped:
                    stopped[effect.stopped] = None
        for robot in stopped:
            effects += self._stop(robot, state)
        return tuple(effects)

    def _note_button(self, event: ControlEvent, listeners: Iterable[_Listener]) -> None:
        """Keep account of the mouse's buttons that are down."""
        if not event.pressed:
            self._buttons.discard(event.name)
        elif event.name.startswith(MOUSE) and any(each.widget.rule.held for each in listeners):
            self._buttons.add(event.name)

    def _listeners(self, event: ControlEvent) -> list[_Listener]:
        """Who waits for this; of the mouse, those of the nearest viewport in which somebody does.

        A button that goes up is told to all who wait for it, wherever the mouse is by then.
        """
        listeners = self._by_input.get(event.name, [])
        if not event.name.startswith(MOUSE) or not event.pressed:
            return listeners
        for hit in event.hits:
            found = [listener for listener in listeners if listener.viewport == hit.viewport]
            if found:
                return found
        return []

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of time going by; to be called 20 times a second."""
        effects = self.look(state)
        for widget in self._widgets:
            if not self._silent(widget, state):
                asked = self._asked(widget, partial(widget.tick, state), state)
                if asked:
                    effects += self._allowed(widget, asked, state, fresh=False)
        return tuple(effects)

    def look(self, state: ConsoleState) -> list[Effect]:
        """Let go where control has changed, or the robot was stopped: keys must be released.

        To be done before keys are taken for presses or repeats.
        """
        stopped = self._changes.look(state.robots.values())
        return [effect for name in stopped for effect in self._stop(name, state)]

    def _stop(self, robot: str, state: ConsoleState) -> list[Effect]:
        """What drives a robot is let go, and its keys must be released before they drive."""
        keys = frozenset(
            name
            for name, listeners in self._by_input.items()
            for each in listeners
            if each.widget.rule.held and commanded(each.widget, state) == robot
        )
        return [*self._release(robot, state), ReleaseFirst(keys=keys)]

    def _allowed(
        self, widget: Widget, asked: list[Effect], state: ConsoleState, *, fresh: bool
    ) -> list[Effect]:
        """What a widget wants done, if this console may; `fresh`: because of a new press."""
        by_hand = frozenset(
            commanded(each, state)
            for each in self._widgets
            if each.rule.purpose is Purpose.TAKE_CONTROL
            and not cast("TakingWidget", each).takes_by_driving()
        )
        robot = refused(asked, state, by_hand)
        if robot is None:
            return [*taking(asked, state), *asked] if fresh else asked
        rest = self._asked(widget, partial(widget.release, state), state)
        return [refusal(robot, state), *rest] if fresh else rest

    def released(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Everything is let go (focus lost, quit, crash): one zero speed for each driven robot.

        Axes that are not neutral then count again when all of them have been told to be neutral,
        which the caller does at once if it lets nothing through before they are.
        """
        self._buttons.clear()
        robots = dict.fromkeys(commanded(widget, state) for widget in self._widgets)
        return tuple(effect for robot in robots for effect in self._release(robot, state))

    def _release(self, robot: str, state: ConsoleState) -> list[Effect]:
        effects: list[Effect] = []
        for widget in self._widgets:
            if commanded(widget, state) == robot and not self._silent(widget, state):
                effects += self._asked(widget, partial(widget.release, state), state)
        return effects

    def _asked(
        self, widget: Widget, ask: Callable[[], Iterable[Effect]], state: ConsoleState
    ) -> list[Effect]:
        """What a widget wants done; if it fails, that its robot stands and somebody is told."""
        try:
            given = [_effect(each).addressed(state.chosen) for each in ask()]
            return [effect for effect in given if effect is not None]
        except Exception:  # a fault in one widget must not take the others from the operator
            name = type(widget).__name__
            _logger.exception("the widget %s failed", name)
        self._failed.add(id(widget))
        robot = commanded(widget, state)
        text = f"{name} failed; the log says why"
        told: list[Effect] = [Notify.now(state, text, robot=robot, alarm=True)]
        if robot and VELOCITY_COMMAND.name in widget.rule.sends:
            rest = Twist.planar(0.0, 0.0)
            told.append(SendEffect(robot=robot, definition=VELOCITY_COMMAND, value=rest))
        return told

    def _silent(self, widget: Widget, state: ConsoleState) -> bool:
        return id(widget) in self._failed or self._driving.is_silent(widget, state)


def _of(listeners: Iterable[_Listener], *purposes: Purpose) -> list[_Listener]:
    """Those whose widgets have one of these purposes."""
    return [each for each in listeners if each.widget.rule.purpose in purposes]


def _effect(given: object) -> Effect:
    """What a widget gave; a widget of somebody else may give anything."""
    if not isinstance(given, Effect):
        text = f"a widget gave {given!r:.80}, which is no effect"
        raise TypeError(text)
    return given
