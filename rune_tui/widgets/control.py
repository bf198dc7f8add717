"""Widgets of the control lease: take control, ask for it, hand it over, give it up."""

from __future__ import annotations

from typing import ClassVar

from hub.gcm.control import CONTROL_STATE, ControlAction
from rune_tui.layout.rules import ChoiceOption, HandlerRule, Purpose, Section
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import Standing, asks, control_of, owner_words, standing
from rune_tui.model.effects import ControlEffect, Effect, Notify
from rune_tui.model.robot_state import RobotState
from rune_tui.widgets.widget import OrderWidget

_USES = (CONTROL_STATE.name,)


class TakeControl(OrderWidget):
    """Takes control of a robot, or asks its owner for it."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.TAKE_CONTROL,
        section=Section.ROBOT,
        says={"": "Take control, or ask for it"},
        meaning=(
            "Takes control of the robot, or asks who has it to hand it over. Who has control "
            "commands the robot alone; everybody can stop it."
        ),
        options={
            "driving": ChoiceOption(
                default="takes",
                choices=("takes", "waits"),
                meaning="whether a key that drives takes control of a free robot as well, or "
                "waits until this one was pressed",
            )
        },
        uses=_USES,
    )

    def takes_by_driving(self) -> bool:
        """Whether keys that drive take control as well."""
        return self.spec.options.word("driving") == "takes"

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The request, unless control is here already."""
        stands = standing(robot)
        if stands is Standing.MINE:
            return (Notify.now(state, owner_words(robot), robot=robot.name),)
        action = ControlAction.ASK if stands is Standing.OTHERS else ControlAction.TAKE
        return (ControlEffect(robot=robot.name, action=action),)


class TakeOver(OrderWidget):
    """Takes control from the present owner."""

    rule: ClassVar = HandlerRule(
        section=Section.ROBOT,
        says={"": "Take control from whoever has it"},
        meaning=(
            "Takes control from who has it, without asking; that needs a key made with "
            "`--role supervise`, or a console on the robot itself."
        ),
        uses=_USES,
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The request, unless control is here already."""
        if standing(robot) is Standing.MINE:
            return (Notify.now(state, owner_words(robot), robot=robot.name),)
        return (ControlEffect(robot=robot.name, action=ControlAction.TAKE_OVER),)


class ReleaseControl(OrderWidget):
    """Gives up control."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.RELEASE_CONTROL,
        section=Section.ROBOT,
        says={"": "Give up control"},
        meaning="Gives up control of the robot, or no longer asks for it.",
        uses=_USES,
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The request; the hub decides whether the console has control to give up."""
        if standing(robot) is Standing.FREE:
            return (Notify.now(state, owner_words(robot), robot=robot.name),)
        return (ControlEffect(robot=robot.name, action=ControlAction.RELEASE),)


class _AnswerRequest(OrderWidget):
    """Answers a request for control."""

    action: ClassVar[ControlAction]

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The answer, if there is a request to this console."""
        control = control_of(robot)
        if standing(robot) is Standing.MINE and control is not None and control.asker:
            return (ControlEffect(robot=robot.name, action=self.action),)
        asked = "you ask yourself" if asks(robot) else "nobody asks you for control"
        return (Notify.now(state, asked, robot=robot.name),)


class GrantControl(_AnswerRequest):
    """Hands control to the console that asks."""

    action: ClassVar = ControlAction.GRANT
    rule: ClassVar = HandlerRule(
        purpose=Purpose.GRANT_CONTROL,
        section=Section.ROBOT,
        says={"": "Hand control to who asks for it"},
        meaning="Hands control of the robot to who asks for it; the robot stands then.",
        uses=_USES,
    )


class DenyControl(_AnswerRequest):
    """Refuses a request for control."""

    action: ClassVar = ControlAction.DENY
    rule: ClassVar = HandlerRule(
        purpose=Purpose.DENY_CONTROL,
        section=Section.ROBOT,
        says={"": "Keep control from who asks for it"},
        meaning="Keeps control of the robot from who asks for it.",
        uses=_USES,
    )
