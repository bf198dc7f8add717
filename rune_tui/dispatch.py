"""Runs the widgets that a control event matches, and filters their effects."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import cast

from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.actions import Action
from rune_tui.layout.names import JOYSTICK, MOUSE
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import LayoutSpec
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
from rune_tui.model.limited_effects import within
from rune_tui.model.own_keys import own_key
from rune_tui.model.page import scrolled, turned
from rune_tui.model.robot_state import RobotState
from rune_tui.widgets.driving import DrivingWidgets
from rune_tui.widgets.listeners import (
    Listener,
    Listeners,
    passed_under_page,
    passed_while_peeking,
    with_purpose,
)
from rune_tui.widgets.widget import TakingWidget, Widget, commanded

_logger = logging.getLogger(__name__)

_CLOSE = "escape"
_WHEEL = MOUSE + "wheel"
_WHEEL_LINES = 3
"""Lines that a page moves per notch of the mouse's wheel."""
_YES = "enter"
_STALE_KEY = (
    "the console ignores keys typed while it was blocked or right after: pause, then press it again"
)
_STALE_CLICK = "that click only brought the terminal to the front: click again"


class Dispatch:
    """All widgets of a layout, by their inputs.

    | case | action |
    | --- | --- |
    | two driving widgets of a robot | the one used last drives, see `DrivingWidgets` |
    | a stop | release the held inputs of the robot |
    | a widget fails | notify the operator once; disable the widget until its next press |
    | a driving widget fails | also send zero speed to its robot |
    | the condition of a study refuses a message | drop it, and say why |
    | another operator has control | drop the messages that only the owner may send |
    | a new press drives a free robot | take control |
    | control changes | release the held inputs |
    | a page covers the view | only keys of stop, page, quit, list and shell work |
    | the operator begins to peek | release the held inputs that drive |
    | the operator peeks at another robot | no input commands a robot, but a stop |
    | a key is stale | only a stop works |

    The caller executes the effects in order. When it ends or loses sight of the keys, it executes
    `released` too.

    Attributes:
        listeners: The widgets by their inputs.
    """

    def __init__(self, layout: LayoutSpec) -> None:
        self.listeners = Listeners(layout)
        self._widgets = self.listeners.widgets
        self._taking_by_hand = list(_taking_by_hand(self._widgets))
        self._buttons: set[str] = set()
        self._failed: set[int] = set()
        self._changes = ControlChanges()
        self._driving = DrivingWidgets(self._widgets)

    @property
    def button_held(self) -> bool:
        """Whether a button of the mouse holds a widget."""
        return bool(self._buttons)

    def waits_for(self, name: str) -> bool:
        """Whether the layout binds an input of this name."""
        return name in self.listeners

    def waits_for_hold(self, name: str) -> bool:
        """Whether a widget acts while an input of this name is held."""
        return any(each.widget.rule.held for each in self.listeners.named(name))

    def stops(self, name: str) -> bool:
        """Whether an input of this name stops a robot."""
        return bool(with_purpose(self.listeners.named(name), Purpose.STOP))

    def stopping(self, name: str, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of a key's stop widgets only."""
        event = ControlEvent(name=name, pressed=True)
        stops = with_purpose(self.listeners.of(event), Purpose.STOP)
        return (*self.look(state), *self._run_widgets(event, stops, state))

    def handle(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an event on all widgets that it matches."""
        return (*self.look(state), *self._handled(event, state))

    def handle_all(self, events: Iterable[ControlEvent], state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of simultaneous events; only the last velocity for each robot is kept.

        If two keys go up together, the second must not drive alone in between.
        """
        effects = [effect for event in events for effect in self.handle(event, state)]
        last = {effect.driven: effect for effect in effects}
        return tuple(each for each in effects if last[each.driven] is each or not each.driven)

    def _handled(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        fresh = event.pressed and not event.repeat
        listeners = self.listeners.of(event)
        if event.must_release_first:
            listeners = [each for each in listeners if not each.widget.rule.held]
        elif event.proven:
            listeners = [each for each in listeners if each.widget.rule.held]
        self._note_button(event, listeners)
        if event.stale:
            return self._stale(event, state)
        if state.leaving and fresh and not event.name.startswith((MOUSE, JOYSTICK)):
            return self._answered(event, listeners, state)
        if state.paged:
            return self._paged(event, listeners, state)
        if fresh and event.name not in self.listeners:
            own = own_key(event.name)
            return () if own is None else (own.effect,)
        if state.peeked:
            return self._peeking(event, listeners, state)
        return self._run_widgets(event, listeners, state)

    def _paged(
        self, event: ControlEvent, listeners: Iterable[Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of an input while a page covers the view; a stop always works."""
        if event.proven or event.second:
            return ()  # the page took it already
        safe = passed_under_page(event, listeners)
        if not event.pressed:
            return self._run_widgets(event, safe, state)
        stops = with_purpose(safe, Purpose.STOP)
        stopping = self._run_widgets(event, stops, state)
        if event.name == _WHEEL:
            page = scrolled(state.page, round(-_WHEEL_LINES * event.value))
        elif stops and event.name != _CLOSE:
            return stopping
        else:
            page = turned(state.page, event.name, state.rows)
        if page != state.page:
            return (TurnPage(page=page), *stopping)
        own = None if event.name in self.listeners else own_key(event.name)
        close = ToggleHelp() if state.help else ToggleLog()
        if own is not None and not event.repeat and (own.under_page or own.ends_page):
            return (close, own.effect) if own.ends_page else (own.effect,)
        if event.repeat or state.page.typing:
            return stopping
        if event.name == _CLOSE:
            return (close, *stopping)
        return self._run_widgets(event, safe, state) if own is None else (own.effect,)

    def _peeking(
        self, event: ControlEvent, listeners: list[Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of an input while the operator peeks at another robot."""
        safe = passed_while_peeking(event, listeners)
        effects = self._run_widgets(event, safe, state)
        if len(safe) == len(listeners) or event.repeat:
            return effects
        text = f"that does nothing while you peek at {state.title(state.peeked)}"
        effects = (*effects, Notify.now(state, text))
        driving = any(each.widget.rule.held for each in listeners)
        if not driving or event.name.startswith((MOUSE, JOYSTICK)):
            return effects
        return (*effects, ReleaseFirst(keys=frozenset({event.name})))

    def _answered(
        self, event: ControlEvent, listeners: Iterable[Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of a key while the console asks whether to end.

        Enter and the quit key end the console; the stop stops. All other keys mean "stay": one that
        disarms does that too, and one that drives must be released first.
        """
        if event.name == _YES and not self.stops(_YES):
            return (QuitEffect(),)
        safe = with_purpose(listeners, Purpose.QUIT, Purpose.STOP)
        if safe:
            return self._run_widgets(event, safe, state)
        stay = AskToLeave(reasons=())
        if disarming := with_purpose(listeners, Purpose.DISARM):
            return (stay, *self._run_widgets(event, disarming, state))
        driving = any(each.widget.rule.held for each in listeners)
        return (stay, ReleaseFirst(keys=frozenset({event.name}))) if driving else (stay,)

    def _stale(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of a key that may be old, or follows a dropped one: only a stop works."""
        waiting = self.listeners.named(event.name)
        stops = with_purpose(waiting, Purpose.STOP)
        if stops:
            return self._run_widgets(event, stops, state)
        meant = waiting or own_key(event.name) is not None
        text = _STALE_CLICK if event.name.startswith(MOUSE) else _STALE_KEY
        return (Notify.now(state, text),) if meant and not event.repeat else ()

    def act(self, action: Action, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an action chosen from the list: a press and release of its first input."""
        spec = action.event
        chosen = [each for each in self.listeners.named(spec.name) if each.spec is spec]
        # No finger is on it, so a time limit ends it.
        press, release = (
            ControlEvent(name=spec.name, pressed=down, timed=True) for down in (True, False)
        )
        return (
            *self._run_widgets(press, chosen, state),
            *self._run_widgets(release, chosen, state),
        )

    def _run_widgets(
        self, event: ControlEvent, listeners: Iterable[Listener], state: ConsoleState
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
                widget, self._effects_of(widget, ask, state), state, fresh=fresh
            ):
                effects.append(effect)
                if effect.stopped:
                    stopped[effect.stopped] = None
        for robot in stopped:
            effects += self._stop(robot, state)
        if any(effect.ends_driving for effect in effects):
            effects = [*self._end_driving(state), *effects]
        return tuple(effects)

    def _note_button(self, event: ControlEvent, listeners: Iterable[Listener]) -> None:
        """Update the set of mouse buttons that are down."""
        if not event.pressed:
            self._buttons.discard(event.name)
        elif event.name.startswith(MOUSE) and any(each.widget.rule.held for each in listeners):
            self._buttons.add(event.name)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of a tick; the caller runs 20 ticks a second."""
        effects = self.look(state)
        for widget in self._widgets:
            if not self._silent(widget, state):
                asked = self._effects_of(widget, partial(widget.tick, state), state)
                if asked:
                    effects += self._allowed(widget, asked, state, fresh=False)
        return tuple(effects)

    def look(self, state: ConsoleState) -> list[Effect]:
        """Release held inputs of robots whose control changed or that stopped."""
        return self.end_holds(self.stopped_robots(state.robots.values()), state)

    def stopped_robots(self, robots: Iterable[RobotState]) -> list[str]:
        """Names of robots whose control changed or that stopped since the last call."""
        return self._changes.look(robots)

    def end_holds(self, robots: Iterable[str], state: ConsoleState) -> list[Effect]:
        """Release held inputs of these robots."""
        return [effect for name in robots for effect in self._stop(name, state)]

    def _stop(self, robot: str, state: ConsoleState) -> list[Effect]:
        """Release what drives a robot; its keys must go up before they drive again."""
        keys = frozenset(self.listeners.holding(lambda each: commanded(each, state) == robot))
        return [*self._release(robot, state), ReleaseFirst(keys=keys)]

    def _end_driving(self, state: ConsoleState) -> Iterator[Effect]:
        """Release all that drives; keys that are down must go up before they drive again."""
        for widget in self._widgets:
            if widget.rule.held and not self._silent(widget, state):
                yield from self._effects_of(widget, partial(widget.release, state), state)
        held = {key for key in state.held if self.waits_for_hold(key)}
        if held:
            yield ReleaseFirst(keys=frozenset(held))

    def _allowed(
        self, widget: Widget, asked: list[Effect], state: ConsoleState, *, fresh: bool
    ) -> list[Effect]:
        """A widget's effects that this console may execute; `fresh`: caused by a new press."""
        by_hand = frozenset(commanded(each, state) for each in self._taking_by_hand)
        robot = refused(asked, state, by_hand)
        if robot is None:
            return [*taking(asked, state), *asked] if fresh else asked
        rest = self._effects_of(widget, partial(widget.release, state), state)
        return [refusal(robot, state), *rest] if fresh else rest

    def released(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Release all inputs (focus lost, quit, crash): one zero speed for each driven robot.

        A deflected axis works again after a neutral event for each axis. A caller that holds back
        deflected axes may send these events at once.
        """
        self._buttons.clear()
        robots = dict.fromkeys(commanded(widget, state) for widget in self._widgets)
        return tuple(effect for robot in robots for effect in self._release(robot, state))

    def _release(self, robot: str, state: ConsoleState) -> list[Effect]:
        effects: list[Effect] = []
        for widget in self._widgets:
            if commanded(widget, state) == robot and not self._silent(widget, state):
                effects += self._effects_of(widget, partial(widget.release, state), state)
        return effects

    def _effects_of(
        self, widget: Widget, ask: Callable[[], Iterable[Effect]], state: ConsoleState
    ) -> list[Effect]:
        """A widget's effects; if it fails, a notice and zero speed for its robot."""
        try:
            given = [_checked(each).addressed(state.chosen) for each in ask()]
            return within((effect for effect in given if effect is not None), state)
        except Exception:  # a fault in one widget must not disable the rest
            name = type(widget).__name__
            _logger.exception("the widget %s failed", name)
        self._failed.add(id(widget))
        robot = commanded(widget, state)
        text = f"{name} failed; the log says why"
        effects: list[Effect] = [Notify.now(state, text, robot=robot, alarm=True)]
        if robot and VELOCITY_COMMAND.name in widget.rule.sends:
            rest = TwistStamped()
            effects.append(SendEffect(robot=robot, definition=VELOCITY_COMMAND, value=rest))
        return effects

    def _silent(self, widget: Widget, state: ConsoleState) -> bool:
        return id(widget) in self._failed or self._driving.is_silent(widget, state)


def _taking_by_hand(widgets: Iterable[Widget]) -> Iterator[Widget]:
    """Widgets of robots for which only a key takes control, not a drive command."""
    for each in widgets:
        taking = each.rule.purpose is Purpose.TAKE_CONTROL
        if taking and not cast("TakingWidget", each).takes_by_driving():
            yield each


def _checked(given: object) -> Effect:
    """Check that a widget gave an effect; a widget of a plugin may give anything."""
    if not isinstance(given, Effect):
        text = f"a widget gave {given!r:.80}, which is no effect"
        raise TypeError(text)
    return given
