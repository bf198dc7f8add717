"""The way down: which widgets a control event wakes, and what comes of it."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import cast

from hub.gcm.navigation import STOP
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.actions import Action
from rune_tui.layout.names import MOUSE
from rune_tui.layout.spec import CHOSEN, EventSpec, LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    Effect,
    ExportEffect,
    PaletteEffect,
    SendEffect,
    ToggleHelp,
    ToggleNight,
    WishPictures,
)
from rune_tui.widgets.speed import SetSpeed, StopRobot
from rune_tui.widgets.widget import Widget

_UNLESS_BOUND: Mapping[str, Effect] = {"?": ToggleHelp(), "ctrl+p": PaletteEffect()}
"""What keys do that the layout binds to nothing."""
_CLOSE_HELP = "escape"
_TO_ROBOTS = SendEffect | ExportEffect | WishPictures | ToggleNight


@dataclass(frozen=True, slots=True, kw_only=True)
class _Listener:
    """An input pattern and the widget that waits for it."""

    widget: Widget
    spec: EventSpec
    viewport: str


class Dispatch:
    """All widgets of a layout, by the inputs that wake them.

    Only one of a robot's speed widgets speaks at a time, the one whose key was pressed last; two
    that spoke at once would contradict each other 20 times a second. After a stop, a robot's
    other widgets forget what is held.

    While the help covers everything, only the keys of the stop, the help and the quit count.

    The caller executes the effects in order. Before it ends, and whenever it can no longer see
    the keys, it also executes those of `released`.
    """

    def __init__(self, layout: LayoutSpec) -> None:
        self._widgets: list[Widget] = []
        self._by_input: defaultdict[str, list[_Listener]] = defaultdict(list)
        self._driving: dict[str, SetSpeed] = {}
        owners = [(viewport.robot, viewport.widgets) for viewport in layout.view.viewports]
        kinds = layout.vocabulary.widgets
        for robot, specs in (("", layout.view.widgets), *owners):
            for spec in specs:
                widget = cast("Widget", kinds[spec.handler].from_spec(spec, robot))
                self._widgets.append(widget)
                for event_spec in spec.events:
                    listener = _Listener(widget=widget, spec=event_spec, viewport=spec.viewport)
                    self._by_input[event_spec.name].append(listener)
                if isinstance(widget, SetSpeed):
                    self._driving.setdefault(robot, widget)

    def handle(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an event, from every widget that it matches."""
        fresh = event.pressed and not event.repeat
        listeners = self._listeners(event)
        if state.help and event.pressed:
            listeners = [each for each in listeners if each.widget.rule.under_help]
            if event.name == _CLOSE_HELP and fresh:
                stops = [each for each in listeners if isinstance(each.widget, StopRobot)]
                return (ToggleHelp(), *self._woken(event, stops, state))
        if fresh and event.name not in self._by_input and event.name in _UNLESS_BOUND:
            own = _UNLESS_BOUND[event.name]
            return (own,) if own == ToggleHelp() or not state.help else ()
        return self._woken(event, listeners, state)

    def act(self, action: Action, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an action that somebody chose from a list, as if its first input was used."""
        spec = action.event
        chosen = [each for each in self._by_input.get(spec.name, ()) if each.spec is spec]
        event = ControlEvent(name=spec.name, pressed=not spec.released)
        return self._woken(event, chosen, state)

    def _woken(
        self, event: ControlEvent, listeners: Iterable[_Listener], state: ConsoleState
    ) -> tuple[Effect, ...]:
        effects: list[Effect] = []
        stopped: dict[str, None] = {}
        for listener in listeners:
            widget = listener.widget
            if isinstance(widget, SetSpeed) and event.pressed and not event.repeat:
                self._take_over(widget)
            for effect in _addressed(widget.handle(event, listener.spec, state), state):
                effects.append(effect)
                if isinstance(effect, SendEffect) and effect.definition is STOP:
                    stopped[effect.robot] = None
        for robot in stopped:
            for name in (robot, CHOSEN) if robot == state.chosen else (robot,):
                effects += self._release(name, state)
        return tuple(effects)

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
        effects: list[Effect] = []
        for widget in self._widgets:
            if not self._silent(widget):
                effects += _addressed(widget.tick(state), state)
        return tuple(effects)

    def released(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Everything is let go (focus lost, quit, crash): one zero speed for each driven robot."""
        robots = dict.fromkeys(widget.robot for widget in self._widgets)
        return tuple(effect for robot in robots for effect in self._release(robot, state))

    def _release(self, robot: str, state: ConsoleState) -> list[Effect]:
        effects: list[Effect] = []
        for widget in self._widgets:
            if widget.robot == robot and not self._silent(widget):
                effects += _addressed(widget.release(state), state)
        return effects

    def _take_over(self, widget: SetSpeed) -> None:
        driving = self._driving[widget.robot]
        if driving is not widget:
            driving.forget()
            self._driving[widget.robot] = widget

    def _silent(self, widget: Widget) -> bool:
        return isinstance(widget, SetSpeed) and self._driving[widget.robot] is not widget


def _addressed(effects: Iterable[Effect], state: ConsoleState) -> Iterator[Effect]:
    """The effects, those for the chosen robot addressed to it; none of them if there is none."""
    for effect in effects:
        if not isinstance(effect, _TO_ROBOTS) or effect.robot != CHOSEN:
            yield effect
        elif state.chosen:
            yield dataclasses.replace(effect, robot=state.chosen)
