"""The widgets of a layout, by the inputs that wake them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from typing import cast

from hub.values import dataclass
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.names import MOUSE
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import EventSpec, LayoutSpec
from rune_tui.widgets.widget import Widget


@dataclass(frozen=True, slots=True, kw_only=True)
class Listener:
    """An input pattern and its widget.

    Attributes:
        widget: The widget.
        spec: The pattern.
        viewport: The viewport that it belongs to; empty: none.
        handler: The name of the widget in layouts.
    """

    widget: Widget
    spec: EventSpec
    viewport: str
    handler: str


class Listeners:
    """All listeners of a layout.

    Attributes:
        widgets: All widgets, in the order of the layout.
    """

    def __init__(self, layout: LayoutSpec) -> None:
        """Make the widgets of a layout."""
        self.widgets: list[Widget] = []
        self._by_input: defaultdict[str, list[Listener]] = defaultdict(list)
        owners = [(viewport.robot, viewport.widgets) for viewport in layout.view.viewports]
        kinds = layout.vocabulary.widgets
        for robot, specs in (("", layout.view.widgets), *owners):
            for spec in specs:
                widget = cast("Widget", kinds[spec.handler].from_spec(spec, robot))
                self.widgets.append(widget)
                for event_spec in spec.events:
                    listener = Listener(
                        widget=widget,
                        spec=event_spec,
                        viewport=spec.viewport,
                        handler=spec.handler,
                    )
                    self._by_input[event_spec.name].append(listener)

    def __contains__(self, name: object) -> bool:
        """Whether the layout binds an input of this name."""
        return name in self._by_input

    @property
    def names(self) -> Iterable[str]:
        """The inputs that the layout binds."""
        return self._by_input.keys()

    def named(self, name: str) -> list[Listener]:
        """Listeners of an input, wherever the mouse is."""
        return self._by_input.get(name, [])

    def of(self, event: ControlEvent) -> list[Listener]:
        """Listeners of an event; a press of the mouse goes to the nearest viewport with listeners.

        The release of a button goes to all its listeners, wherever the mouse is.
        """
        listeners = self.named(event.name)
        if not event.name.startswith(MOUSE) or not event.pressed:
            return listeners
        for hit in event.hits:
            found = [listener for listener in listeners if listener.viewport == hit.viewport]
            if found:
                return found
        return []

    def holding(self, meant: Callable[[Widget], bool]) -> Iterator[str]:
        """Inputs that wake a widget while they are held, if the widget is meant."""
        for name, listeners in self._by_input.items():
            if any(each.widget.rule.held and meant(each.widget) for each in listeners):
                yield name


def with_purpose(listeners: Iterable[Listener], *purposes: Purpose) -> list[Listener]:
    """Listeners whose widgets have one of these purposes."""
    return [each for each in listeners if each.widget.rule.purpose in purposes]


def passed_under_page(event: ControlEvent, listeners: Iterable[Listener]) -> list[Listener]:
    """Listeners that an event wakes while a page covers the view."""
    return [each for each in listeners if each.widget.rule.under_help or _harmless(event, each)]


def passed_while_peeking(event: ControlEvent, listeners: Iterable[Listener]) -> list[Listener]:
    """Listeners that an event wakes while the operator peeks at another robot."""
    return [
        each
        for each in listeners
        if not each.widget.rule.needs_robot
        or (each.widget.rule.under_help and each.widget.rule.purpose is not Purpose.DISARM)
        or _harmless(event, each)
    ]


def _harmless(event: ControlEvent, listener: Listener) -> bool:
    """Whether it is a release, and the widget does not act on the release."""
    return not (event.pressed or listener.spec.released)
