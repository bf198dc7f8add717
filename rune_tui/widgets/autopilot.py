"""Widgets for a vehicle whose autopilot has modes: drive, hold, and any mode that it offers."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotPhase
from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import ChoiceOption, HandlerRule, Purpose, Section
from rune_tui.layout.spec import EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import autopilot_of
from rune_tui.widgets.vehicle import AGAIN_S
from rune_tui.widgets.widget import OrderWidget, PressWidget

_SENDS = (VEHICLE_COMMAND.name,)
_NONE = "it has no autopilot with modes"


def _asked(
    robot: RobotState, state: ConsoleState, command: VehicleCommand, text: str
) -> tuple[Effect, ...]:
    """The order, and the notice of it."""
    send = SendEffect(robot=robot.name, definition=VEHICLE_COMMAND, value=command)
    return (send, Notify.now(state, text, robot=robot.name))


class AutopilotWidget(OrderWidget):
    """Asks an autopilot to follow the operator, or to stay where it is."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.FOLLOW,
        purpose_with={"order": "drive"},
        section=Section.DRIVE,
        says={"": "Autopilot: {order}"},
        meaning=(
            "Asks a vehicle's autopilot for the mode that follows your commands, or for the one "
            "in which it stays where it is and nothing drives it. Sticks and keys have to be let "
            "go before they drive."
        ),
        options={
            "order": ChoiceOption(
                default="drive",
                choices=("drive", "hold"),
                words={"drive": "follow me", "hold": "stay here"},
                meaning="what it shall do",
            )
        },
        sends=_SENDS,
        uses=(AUTOPILOT_STATE.name,),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The order, or why it would change nothing."""
        autopilot = autopilot_of(robot)
        if autopilot is None:
            return (Notify.now(state, _NONE, robot=robot.name),)
        if self.spec.options.word("order") == "hold":
            if autopilot.holds:
                text = f"it is asked to stay, in the mode {autopilot.holds}"
                return _asked(robot, state, VehicleCommand(order=VehicleOrder.STAY), text)
            return (Notify.now(state, "it has no mode that stays here", robot=robot.name),)
        if autopilot.phase is AutopilotPhase.DISARMED:
            return (Notify.now(state, "it is disarmed: arm it first", robot=robot.name),)
        command = VehicleCommand(order=VehicleOrder.DRIVE)
        return _asked(robot, state, command, "it is asked to follow you")


class ModeWidget(PressWidget):
    """Chooses one of an autopilot's modes: one input shows the next, another one sets it."""

    rule: ClassVar = HandlerRule(
        section=Section.ROBOT,
        says={"next": "Modes: show the next one", "set": "Modes: set the one that is shown"},
        meaning=(
            "Chooses a mode of a vehicle's autopilot: `next` shows the next one that it offers, "
            f"and `set` asks for it within {AGAIN_S:.0f} s."
        ),
        controls=("next", "set"),
        sends=_SENDS,
        uses=(AUTOPILOT_STATE.name,),
    )

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._robot, self._shown, self._since = "", "", -math.inf

    def press(
        self, _event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The next mode as a question, or the order."""
        robot = state.robot(self.robot)
        if robot is None:
            return ()
        autopilot = autopilot_of(robot)
        if autopilot is None or not autopilot.modes:
            return (Notify.now(state, _NONE, robot=robot.name),)
        left = state.looked.get(robot.name, -math.inf) >= self._since
        old = left or robot.name != self._robot or state.now - self._since > AGAIN_S
        shown = "" if old else self._shown
        if event_spec.control == "set":
            self._since = -math.inf
            if shown in autopilot.modes:
                command = VehicleCommand(order=VehicleOrder.MODE, name=shown)
                return _asked(robot, state, command, f"it is asked for the mode {shown}")
            keys = (each.name for each in self.spec.events if each.control == "next")
            text = f"{next(keys, 'another key').upper()} shows a mode first"
            return (Notify.now(state, text, robot=robot.name),)
        modes = [each for each in autopilot.modes if each != autopilot.mode]
        place = modes.index(shown) + 1 if shown in modes else 0
        self._robot, self._since = robot.name, state.now
        self._shown = modes[place % len(modes)] if modes else autopilot.mode
        text = f"MODE {self._shown}? It is in {autopilot.mode}: set it, or show the next"
        return (Notify.now(state, text, robot=robot.name, alarm=True, question_s=AGAIN_S),)
