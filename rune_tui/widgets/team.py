"""Widgets for an operator with several robots: choose one, go to the next alarm, peek at one."""

from __future__ import annotations

import math
from typing import ClassVar, Self

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.names import MOUSE
from rune_tui.layout.rules import HandlerRule, Purpose, Section, TextOption
from rune_tui.layout.spec import EventSpec, WidgetSpec
from rune_tui.model.attention import next_robot
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ChooseRobot, Effect, Notify, Peek
from rune_tui.widgets.widget import EffectWidget, PressWidget

PEEK_S = 3.0
"""Duration of a peek whose end is not reported [s]."""
_REPEATED_S = 1.0
"""Least time that such a peek goes on after a repeat of its key [s]."""


class ChooseRobotWidget(EffectWidget):
    """Chooses the robot that some viewports show and command."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.CHOOSE_ROBOT,
        section=Section.ROBOT,
        says={"": "Choose the robot: {robot}"},
        meaning=(
            "Chooses the robot that viewports of the robot `*` show and command. What is held is "
            "let go first."
        ),
        options={"robot": TextOption(names="robot", meaning="which one; empty: the next")},
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """The choice."""
        return ChooseRobot(robot=self.spec.options.word("robot"))


class NextAlarm(PressWidget):
    """Chooses the robot of the next alarm."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.NEXT_ALARM,
        section=Section.ROBOT,
        says={"": "Go to the robot of the next alarm"},
        meaning=(
            "Chooses the robot that needs you next: the one of the first alarm that you did not "
            "look at, else the next one with an alarm. What is held is let go first. The console "
            "never chooses a robot by itself."
        ),
        needs_robot=False,
    )

    def press(
        self, _event: ControlEvent, _event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The choice, if another robot has an alarm."""
        robot = next_robot(state.attention, state.chosen)
        if robot:
            return (ChooseRobot(robot=robot),)
        here = any(entry.robot == state.chosen for entry in state.attention)
        text = "only this robot has alarms" if here else "no robot has an alarm"
        return (Notify.now(state, text),)


class PeekWidget:
    """Shows another robot in place of the chosen one, and drives neither.

    | event | action |
    | --- | --- |
    | press | release all that drives; show the other robot |
    | release, where it is reported | show the chosen robot again |
    | `PEEK_S` after the press, where it is not | the same |
    | focus lost, robot chosen, page opened | the same |
    """

    rule: ClassVar = HandlerRule(
        section=Section.ROBOT,
        says={"": "Hold it: peek at {robot}"},
        meaning=(
            "Shows another robot in the viewports of the robot `*` while it is held, or for 3 s "
            "where the terminal does not report releases. What is held is let go first, and until "
            "it ends no input commands a robot; stops work, and stop both."
        ),
        options={
            "robot": TextOption(
                names="robot",
                meaning="which one; empty: the one of the first alarm that you did not look at, "
                "else the one not looked at for longest",
            )
        },
        needs_robot=False,
    )

    def __init__(self, robot: str, wanted: str) -> None:
        """Prepare.

        Args:
            robot: The robot of its viewport; empty: none.
            wanted: The robot to look at; empty: the one that needs it most.
        """
        self.robot = robot
        self._wanted = wanted
        self._until: float | None = None

    @classmethod
    def from_spec(cls, spec: WidgetSpec, robot: str) -> Self:
        """The widget that a layout describes."""
        return cls(robot, spec.options.word("robot"))

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Begin, go on or end."""
        if event.repeat:
            if self._until is not None and event.timed:
                self._until = max(self._until, state.now + _REPEATED_S)
            return ()
        if event.pressed == event_spec.released:
            return self.release(state) if self._until == math.inf else ()
        robot = self._wanted or _next_look(state)
        if robot not in state.robots or robot == state.chosen:
            return (Notify.now(state, "there is no other robot to look at"),)
        # A lost release of the mouse would keep it.
        reported = not (event.timed or event_spec.released or event.name.startswith(MOUSE))
        self._until = math.inf if reported else state.now + PEEK_S
        return (Peek(robot=robot),)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """End it, if it is time or something else ended it."""
        if self._until is None or (state.peeked and state.now < self._until):
            return ()
        return self.release(state)

    def release(self, _state: ConsoleState) -> tuple[Effect, ...]:
        """End it."""
        if self._until is None:
            return ()
        self._until = None
        return (Peek(),)


def _next_look(state: ConsoleState) -> str:
    """The robot to look at next, apart from the chosen one; empty: none.

    That is the one of the first alarm without an answer, else the one not looked at for longest.
    """
    others = [name for name in state.robots if name != state.chosen]
    raised = (entry.robot for entry in state.attention if not entry.answered and not entry.over)
    return next(
        (name for name in raised if name in others), max(others, key=state.unseen_s, default="")
    )
