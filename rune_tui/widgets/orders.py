"""Widgets for a robot's own tasks, and for its assistance."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.autonomy import AUTONOMY_COMMAND, AUTONOMY_STATE, AutonomyCommand, Behaviour
from hub.gcm.mapping import InterestPoint
from hub.gcm.navigation import (
    ASSISTANCE_COMMAND,
    GOAL_COMMAND,
    NAVIGATION_STATUS,
    ROBOT_STATE,
    Assistance,
    AssistanceCommand,
    GoalCommand,
    Point,
)
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import ChoiceOption, HandlerRule, NumberOption, Section
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from rune_tui.model.lacks import why_unsupported
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.widgets.confirming import nearest_mark
from rune_tui.widgets.pointing import FRESH_S, PointedWidget
from rune_tui.widgets.widget import OrderWidget

_ORDERS = {
    "explore": Behaviour.EXPLORE,
    "return": Behaviour.RETURN,
    "hold": Behaviour.HOLD,
    "wander": Behaviour.WANDER,
}


class GoTo(PointedWidget):
    """Sends the robot to the place that was clicked, or near to the mark there."""

    purpose: ClassVar[str] = "sent"
    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={"": "Go there by itself"},
        meaning=(
            "Sends the robot where you click; a driving key or a stop ends it. Click on a mark: "
            "the robot stops before it, and turns to it."
        ),
        options={
            "linear": NumberOption(
                default=0.0,
                least=0.0,
                most=10.0,
                unit="m/s",
                meaning="fastest speed; 0: the robot's own limit",
            ),
            "mark": NumberOption(
                default=0.3,
                least=0.0,
                most=5.0,
                unit="m",
                meaning="a click no farther from a mark means that mark; 0: none",
            ),
            "before": NumberOption(
                default=1.0,
                least=0.0,
                most=20.0,
                unit="m",
                meaning="how far before a mark it stops",
            ),
        },
        sends=(GOAL_COMMAND.name,),
        uses=(NAVIGATION_STATUS.name,),
        pointed=True,
    )

    def point(
        self, place: WorldPoint, _event: ControlEvent, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The goal, with any heading, or the goal before a mark."""
        if why := why_unsupported(robot, GOAL_COMMAND.name, lasting=True):
            return (Notify.now(state, f"not sent there: {why}", robot=robot.name, alarm=True),)
        mark = nearest_mark(place, robot, self.spec.options.number("mark"))
        if mark is not None:
            return self._before(mark, robot, state)
        text = f"sent to {place.x:.1f}, {place.y:.1f} m"
        return self._send(Point(x=place.x, y=place.y), math.nan, text, robot, state)

    def _before(
        self, mark: InterestPoint, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The goal on the line from the robot to a mark: at the mark itself may be a person."""
        named = f"{mark.kind.name.lower()} {mark.number}"
        known = robot.navigation
        if known is None or known.age(state.now) > FRESH_S:
            text = f"not sent to {named}: where the robot is now is not known"
            return (Notify.now(state, text, robot=robot.name, alarm=True),)
        ahead_x, ahead_y = mark.x - known.value.x, mark.y - known.value.y
        way, before = math.hypot(ahead_x, ahead_y), self.spec.options.number("before")
        if not way > before:
            text = f"not sent to {named}: the robot is {way:.1f} m from it already"
            return (Notify.now(state, text, robot=robot.name),)
        goal = Point(x=mark.x - before * ahead_x / way, y=mark.y - before * ahead_y / way)
        text = f"sent to {named}, {before:.1f} m before it"
        return self._send(goal, math.atan2(ahead_y, ahead_x), text, robot, state)

    def _send(
        self, goal: Point, theta: float, text: str, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        limit = self.spec.options.number("linear") or math.nan
        command = GoalCommand(points=(goal,), theta=theta, linear_limit=limit)
        send = SendEffect(robot=robot.name, definition=GOAL_COMMAND, value=command)
        return (send, Notify.now(state, text, robot=robot.name))


class Autonomy(OrderWidget):
    """Starts and ends the robot's own tasks."""

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={"": "{order}"},
        meaning="Tells the robot what to do by itself; a driving key or a stop ends it.",
        options={
            "order": ChoiceOption(
                default="explore",
                choices=tuple(_ORDERS),
                words={
                    "explore": "Explore by itself",
                    "return": "Go back to the start by itself",
                    "hold": "Do nothing by itself",
                    "wander": "Wander by itself",
                },
                meaning="explore what is not mapped, return to where it started, hold still for "
                "the operator, or wander about",
            )
        },
        sends=(AUTONOMY_COMMAND.name,),
        uses=(AUTONOMY_STATE.name,),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The order."""
        order = self.spec.options.word("order")
        if why := why_unsupported(robot, AUTONOMY_COMMAND.name, lasting=True):
            return (Notify.now(state, f"no order {order}: {why}", robot=robot.name, alarm=True),)
        command = AutonomyCommand(behaviour=_ORDERS[order])
        send = SendEffect(robot=robot.name, definition=AUTONOMY_COMMAND, value=command)
        return (send, Notify.now(state, f"the order is: {order}", robot=robot.name))


class Safety(OrderWidget):
    """Switches the slowdown before obstacles."""

    rule: ClassVar = HandlerRule(
        section=Section.ROBOT,
        says={"": "Stop before obstacles: {assistance}"},
        meaning=(
            "Switches the robot's help on or off. With it, it stops before what is in its way; "
            "without it, it follows you into walls."
        ),
        options={
            "assistance": ChoiceOption(
                default="toggle",
                choices=("toggle", "on", "off"),
                words={"toggle": "on or off"},
                meaning="what is wanted",
            )
        },
        sends=(ASSISTANCE_COMMAND.name,),
        uses=(ROBOT_STATE.name,),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The command, and an alarm if it switches the help off.

        If the state is not known, it switches the help on.
        """
        wanted = self.spec.options.word("assistance")
        if wanted == "toggle":
            known = robot.navigation
            helped = known is not None and known.value.assistance is Assistance.ON
            wanted = "off" if helped else "on"
        command = AssistanceCommand(assistance=Assistance[wanted.upper()])
        off = command.assistance is Assistance.OFF
        text = "SAFETY OFF: it follows you into walls" if off else "safety is on"
        send = SendEffect(robot=robot.name, definition=ASSISTANCE_COMMAND, value=command)
        return (send, Notify.now(state, text, robot=robot.name, alarm=off))
