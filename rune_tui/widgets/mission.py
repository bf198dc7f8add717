"""The widget that begins, names and ends a robot's mission."""

from __future__ import annotations

from typing import ClassVar

from hub.gcm.mission import MISSION_STATE, MissionAction
from rune_tui.layout.rules import ChoiceOption, HandlerRule, Section
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, MissionEffect, Tell
from rune_tui.model.mission import mission_of
from rune_tui.model.robot_state import RobotState
from rune_tui.widgets.widget import OrderWidget

_END = "end"


class Mission(OrderWidget):
    """Asks for the name of a mission to begin; of one that runs, for another name or its end."""

    rule: ClassVar = HandlerRule(
        section=Section.MARK,
        says={"": "{do}"},
        meaning=(
            "Begins a mission under the name you type; while one runs, names it anew, or ends it "
            "when you type 'end'. The robot keeps marks, map and track of a mission."
        ),
        options={
            "do": ChoiceOption(
                default="ask",
                choices=("ask", "begin", "name", "end"),
                words={
                    "ask": "Mission: begin, name or end it",
                    "begin": "Begin a mission",
                    "name": "Name the mission anew",
                    "end": "End the mission",
                },
                meaning="what it does: asks what suits, or only this",
            )
        },
        uses=(MISSION_STATE.name,),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The question."""
        mission = mission_of(robot)
        do = self.spec.options.word("do")
        runs = mission is not None and bool(mission.running)
        if not runs or mission is None:
            if do in ("name", "end"):
                return (Tell.now(state, "no mission runs", robot=robot.name),)
            asked = f"Begin a mission of {robot.title}; its name, or nothing for date and time"
            return (self._question(robot, asked, "", MissionAction.BEGIN),)
        if do == "begin":
            text = f"mission {mission.name} runs already; end it first"
            return (Tell.now(state, text, robot=robot.name),)
        waiting = sum(state.unconfirmed.values())
        risk = f" {waiting} marks are NOT CONFIRMED yet!" if waiting else ""
        if do == "end":
            asked = f"End mission {mission.name} of {robot.title}? Type '{_END}'.{risk}"
            return (self._question(robot, asked, "", MissionAction.END),)
        asked = f"Mission {mission.name} of {robot.title}: another name, or '{_END}' ends it.{risk}"
        return (self._question(robot, asked, mission.name, MissionAction.NAME),)

    def _question(
        self, robot: RobotState, asked: str, text: str, action: MissionAction
    ) -> AskEffect:
        def answer(said: str) -> tuple[Effect, ...]:
            wanted = action
            if action is not MissionAction.BEGIN and said.lower() == _END:
                wanted = MissionAction.END
            elif action is MissionAction.END or (
                action is MissionAction.NAME and said in ("", text)
            ):
                return ()
            name = "" if wanted is MissionAction.END else said
            return (MissionEffect(robot=robot.name, action=wanted, name=name),)

        return AskEffect(robot=robot.name, asked=asked, text=text, answer=answer)
