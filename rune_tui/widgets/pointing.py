"""Widgets that need a place: a click on the video or on the map."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.widgets.widget import PressWidget

FRESH_S = 1.0
"""Largest age of the pose for an order that depends on it [s]."""


class PointedWidget(PressWidget):
    """A widget that acts on the place that was clicked."""

    purpose: ClassVar[str]
    """The failed action of a click beside the ground, such as "marked"."""

    @abstractmethod
    def point(
        self, place: WorldPoint, event: ControlEvent, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of a click on a place."""

    def press(
        self, event: ControlEvent, _event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects for the clicked place, or a sentence if there is none."""
        robot = state.robot(self.robot)
        if robot is None:
            return ()
        place = place_of(event, self.spec.viewport, robot.name)
        if place is None:
            text = f"not {self.purpose}: nothing tells how far away that is; click on the floor"
            return (Notify.now(state, text, robot=robot.name),)
        return self.point(place, event, robot, state)


def place_of(event: ControlEvent, viewport: str, robot: str) -> WorldPoint | None:
    """The place in the world that was clicked.

    | under the mouse, nearest first | place |
    | --- | --- |
    | a picture over the widget's own viewport | that of this picture, if it is of the same robot |
    | the widget's own viewport, which shows the world | its own |
    | a viewport of the same robot that shows the world | that of this viewport |
    """
    for hit in event.hits:
        if hit.viewport == viewport:
            break
        if hit.in_picture is not None:
            return hit.place if hit.robot == robot else None
    hits = [hit for hit in event.hits if hit.place is not None and hit.robot == robot]
    own = [hit for hit in hits if hit.viewport == viewport]
    return next((hit.place for hit in (*own, *hits)), None)
