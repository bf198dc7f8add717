"""Which of a robot's driving widgets acts: the one used last.

Two that acted at once would contradict each other 20 times a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import cast

from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.widgets.widget import DrivingWidget, Widget, commanded


class DrivingWidgets:
    """The driving widgets of a layout, and which of them acts for each robot."""

    def __init__(self, widgets: Iterable[Widget]) -> None:
        """None was used yet.

        Args:
            widgets: All widgets of the layout, in its order.
        """
        self._all = tuple(_driving(widgets))
        self._used: dict[str, DrivingWidget] = {}

    def pressed(self, widget: Widget, event_spec: EventSpec, state: ConsoleState) -> None:
        """An input of a widget was pressed: if it drives, its widget acts from now on."""
        for driving in _driving((widget,)):
            if driving.accepts(event_spec, state):
                before = self._acting(driving, state)
                if before is not driving:
                    if before is not None:
                        before.forget()
                    self._used[commanded(driving, state)] = driving

    def is_silent(self, widget: Widget, state: ConsoleState) -> bool:
        """Whether a widget must not act, because another one drives its robot."""
        driving = widget.rule.purpose is Purpose.DRIVE
        return driving and self._acting(widget, state) is not widget

    def _acting(self, widget: Widget, state: ConsoleState) -> DrivingWidget | None:
        """The driving widget of its robot; the layout's first until another is used."""
        robot = commanded(widget, state)
        used = self._used.get(robot)
        if used is not None and commanded(used, state) == robot:
            return used
        return next((each for each in self._all if commanded(each, state) == robot), None)


def _driving(widgets: Iterable[Widget]) -> Iterator[DrivingWidget]:
    return (cast("DrivingWidget", each) for each in widgets if each.rule.purpose is Purpose.DRIVE)
