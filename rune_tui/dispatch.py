"""The way down: which widgets a control event wakes, and what comes of it."""

from __future__ import annotations

from collections import defaultdict

from hub.gcm.navigation import STOP
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.spec import EventSpec, LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, SendEffect
from rune_tui.widgets.registry import WIDGETS
from rune_tui.widgets.speed import SetSpeed
from rune_tui.widgets.widget import Widget


class Dispatch:
    """All widgets of a layout, by the keys that wake them.

    Only one of a robot's speed widgets speaks at a time, the one whose key was pressed last; two
    that spoke at once would contradict each other 20 times a second. After a stop, a robot's
    other widgets forget what is held.

    The caller executes the effects in order. Before it ends, and whenever it can no longer see
    the keys, it also executes those of `released`.
    """

    def __init__(self, layout: LayoutSpec) -> None:
        self._widgets: list[Widget] = []
        self._by_key: defaultdict[str, list[tuple[Widget, EventSpec]]] = defaultdict(list)
        self._driving: dict[str, SetSpeed] = {}
        owners = [(viewport.robot, viewport.widgets) for viewport in layout.view.viewports]
        for robot, specs in (("", layout.view.widgets), *owners):
            for spec in specs:
                widget = WIDGETS[spec.handler].from_spec(spec, robot)
                self._widgets.append(widget)
                for event_spec in spec.events:
                    self._by_key[event_spec.key].append((widget, event_spec))
                if isinstance(widget, SetSpeed):
                    self._driving.setdefault(robot, widget)

    def handle(self, event: ControlEvent, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of an event, from every widget that it matches."""
        effects: list[Effect] = []
        stopped: dict[str, None] = {}
        for widget, event_spec in self._by_key.get(event.key, ()):
            if isinstance(widget, SetSpeed) and event.pressed and not event.repeat:
                self._take_over(widget)
            for effect in widget.handle(event, event_spec, state):
                effects.append(effect)
                if isinstance(effect, SendEffect) and effect.definition is STOP:
                    stopped[effect.robot] = None
        for robot in stopped:
            effects += self._release(robot, state)
        return tuple(effects)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of time going by; to be called 20 times a second."""
        effects: list[Effect] = []
        for widget in self._widgets:
            if not self._silent(widget):
                effects += widget.tick(state)
        return tuple(effects)

    def released(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Everything is let go (focus lost, quit, crash): one zero speed for each driven robot."""
        robots = dict.fromkeys(widget.robot for widget in self._widgets)
        return tuple(effect for robot in robots for effect in self._release(robot, state))

    def _release(self, robot: str, state: ConsoleState) -> list[Effect]:
        effects: list[Effect] = []
        for widget in self._widgets:
            if widget.robot == robot and not self._silent(widget):
                effects += widget.release(state)
        return effects

    def _take_over(self, widget: SetSpeed) -> None:
        driving = self._driving[widget.robot]
        if driving is not widget:
            driving.forget()
            self._driving[widget.robot] = widget

    def _silent(self, widget: Widget) -> bool:
        return isinstance(widget, SetSpeed) and self._driving[widget.robot] is not widget
