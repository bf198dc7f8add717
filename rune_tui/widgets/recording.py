"""The widget that gives orders to a robot's own recorder."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from hub.gcm.recording import RECORD_COMMAND, RECORD_STATE, RecordAction, RecordCommand
from rune_tui.layout.rules import ChoiceOption, HandlerRule, NumberOption, Section
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, Notify, RobotRecordEffect
from rune_tui.model.lacks import why_unsupported
from rune_tui.model.recording import recording_of
from rune_tui.model.robot_state import RobotState
from rune_tui.widgets.widget import OrderWidget


class RobotRecordWidget(OrderWidget):
    """Has the robot record, mark a moment, or keep the time around it."""

    rule: ClassVar = HandlerRule(
        section=Section.ROBOT,
        says={"": "{do}"},
        meaning=(
            "Has the robot record all that is published on it, or ends that; marks a moment of the "
            "recording; or keeps the time around now as a file of its own. The files are on the "
            "robot."
        ),
        options={
            "do": ChoiceOption(
                default="record",
                choices=("record", "mark", "note", "snapshot", "split"),
                words={
                    "record": "Record on the robot, or end it",
                    "mark": "Mark this moment of the recording",
                    "note": "Mark this moment, in words",
                    "snapshot": "Keep the last seconds",
                    "split": "Go on in another file",
                },
                meaning="what it does",
            ),
            "before": NumberOption(
                default=30.0, least=0.0, most=3600.0, unit="s",
                meaning="how much of a snapshot is before the press",
            ),
            "after": NumberOption(
                default=10.0, least=0.0, most=3600.0, unit="s", meaning="how much is after it"
            ),
        },
        uses=(RECORD_STATE.name,),
    )  # fmt: skip

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The order; of a robot without a recorder, why there is none."""
        if why := why_unsupported(robot, RECORD_COMMAND.name, lasting=True):
            return (Notify.now(state, f"no recording: {why}", robot=robot.name),)
        do = self.spec.options.word("do")
        if do == "note":
            asked = f"Mark this moment of the recording of {robot.title}, as"
            return (AskEffect(robot=robot.name, asked=asked, text="", answer=self._noted(robot)),)
        return (RobotRecordEffect(robot=robot.name, command=self._command(robot, do)),)

    def _command(self, robot: RobotState, do: str) -> RecordCommand:
        if do == "snapshot":
            number = self.spec.options.number
            return RecordCommand(
                action=RecordAction.SNAPSHOT, before_s=number("before"), after_s=number("after")
            )
        if do == "record":
            known = recording_of(robot)
            runs = known is not None and known.recording
            return RecordCommand(action=RecordAction.STOP if runs else RecordAction.START)
        return RecordCommand(action=RecordAction.MARK if do == "mark" else RecordAction.SPLIT)

    @staticmethod
    def _noted(robot: RobotState) -> Callable[[str, ConsoleState], tuple[Effect, ...]]:
        def answer(said: str, _state: ConsoleState) -> tuple[Effect, ...]:
            command = RecordCommand(action=RecordAction.MARK, text=said[:1000])
            return (RobotRecordEffect(robot=robot.name, command=command),)

        return answer
