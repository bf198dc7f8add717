"""The widget that begins, names and ends a robot's mission."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Final

from hub.gcm.mission import MISSION_COMMAND, MISSION_STATE, MissionAction, MissionState
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, HandlerRule, Purpose, Section
from rune_tui.layout.spec import WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, MissionEffect, Notify
from rune_tui.model.lacks import why_unsupported
from rune_tui.model.mission import mission_of
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.widgets.widget import OrderWidget

_Answer = Callable[[str, ConsoleState], tuple[Effect, ...]]
_END: Final = "end"
_YES: Final = "yes"
WAIT_S: Final = 20.0
"""A name waits at most this time for the robot to report its mission [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _PendingMission:
    """A name that was typed before the robot reported its mission.

    Attributes:
        robot: The robot.
        name: The name.
        since: Time at which it was typed [s].
    """

    robot: str
    name: str
    since: float


class Mission(OrderWidget):
    """Asks for the name of a mission to begin; of one that runs, for another name or its end."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.MISSION,
        section=Section.MARK,
        says={"": "{do}"},
        meaning=(
            "Begins a mission under the name you type; while one runs, gives it another name. Type "
            "'end' to end it, then 'yes'. The robot keeps marks, map and track of a mission."
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

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._waiting: _PendingMission | None = None

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The question; of a robot that keeps no missions, why it does not."""
        if why := why_unsupported(robot, MISSION_COMMAND.name, lasting=True):
            return (Notify.now(state, f"no mission: {why}", robot=robot.name),)
        mission = _running(robot)
        do = self.spec.options.word("do")
        if mission is None:
            if do in ("name", "end"):
                return (Notify.now(state, "no mission runs", robot=robot.name),)
            asked = f"Begin a mission of {robot.title}; its name, or nothing for date and time"
            text = self._waiting.name if self._waiting is not None else ""
            return (AskEffect(robot=robot.name, asked=asked, text=text, answer=self._named(robot)),)
        if do == "begin":
            text = f"mission {mission.name} runs already; end it first"
            return (Notify.now(state, text, robot=robot.name),)
        if do == "end":
            return (_ending(robot, mission, state),)
        asked = f"Mission {mission.name} of {robot.title}: another name; '{_END}' asks to end it"
        answer = self._renamed(robot)
        return (AskEffect(robot=robot.name, asked=asked, text=mission.name, answer=answer),)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Give a mission the name that was typed before the robot reported it."""
        waiting = self._waiting
        if waiting is None:
            return ()
        robot = state.robots.get(waiting.robot)
        if robot is not None and _reachable(robot):
            self._waiting = None
            return _given(robot, waiting.name)
        if state.now - waiting.since < WAIT_S:
            return ()
        self._waiting = None
        text = f"no mission '{waiting.name}': the robot tells of no mission"
        return (Notify.now(state, text, robot=waiting.robot, alarm=True),)

    def _named(self, asked: RobotState) -> _Answer:
        """Begin a mission, or name the one that began meanwhile; wait if its state is not known."""

        def answer(said: str, state: ConsoleState) -> tuple[Effect, ...]:
            robot = state.robots.get(asked.name, asked)
            if _reachable(robot):
                return _given(robot, said)
            self._waiting = _PendingMission(robot=robot.name, name=said, since=state.now)
            text = "the mission begins when the robot tells that it can keep one"
            return (Notify.now(state, text, robot=robot.name),)

        return answer

    @staticmethod
    def _renamed(asked: RobotState) -> _Answer:
        """Another name for the mission that runs, or the question whether to end it."""

        def answer(said: str, state: ConsoleState) -> tuple[Effect, ...]:
            robot = state.robots.get(asked.name, asked)
            mission = _running(robot)
            if said.lower() == _END and mission is not None:
                return (_ending(robot, mission, state),)
            if said == "" or (mission is not None and said == mission.name):
                return ()
            return _given(robot, said)

        return answer


def _given(robot: RobotState, name: str) -> tuple[Effect, ...]:
    """The mission gets a name: the one that runs, else one that begins."""
    runs = _running(robot) is not None
    if runs and not name:
        return ()
    action = MissionAction.NAME if runs else MissionAction.BEGIN
    return (MissionEffect(robot=robot.name, action=action, name=name),)


def _ending(robot: RobotState, mission: MissionState, state: ConsoleState) -> AskEffect:
    """The question whether to end a mission."""
    waiting = state.unconfirmed_marks(robot.name)
    risk = f" {waiting} marks are NOT CONFIRMED yet!" if waiting else ""

    def answer(said: str, _: ConsoleState) -> tuple[Effect, ...]:
        if said.lower() != _YES:
            return ()
        return (MissionEffect(robot=robot.name, action=MissionAction.END, name=""),)

    asked = f"End mission {mission.name} of {robot.title}? Type '{_YES}'.{risk}"
    return AskEffect(robot=robot.name, asked=asked, text="", answer=answer)


def _reachable(robot: RobotState) -> bool:
    """Whether a robot is linked and has reported its mission."""
    return robot.link.phase is LinkPhase.CONNECTED and mission_of(robot) is not None


def _running(robot: RobotState) -> MissionState | None:
    """The mission, if one runs."""
    mission = mission_of(robot)
    return mission if mission is not None and mission.running else None
