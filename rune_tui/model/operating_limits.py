"""What robots may do by themselves in a condition of a study; pure.

`rune_tui.model.limited_effects` applies it to all that widgets mean, plugins too.

| level of autonomy | what it refuses |
| --- | --- |
| teleoperation | goals, turns, targets of holds, all behaviours, an autopilot's other modes |
| goals | the behaviours explore and wander |
| exploration | nothing |

What ends a robot's own task always passes: a stop, a goal without points, the behaviour hold, a
mode that follows the operator or stays where it is.
"""

from __future__ import annotations

import enum
import math
from typing import Any, Self

from hub.gcm.autonomy import AUTONOMY_COMMAND, AutonomyCommand, Behaviour
from hub.gcm.autopilot import OPERATED_MODES
from hub.gcm.navigation import (
    ASSISTANCE_COMMAND,
    GOAL_COMMAND,
    TURN_COMMAND,
    Assistance,
    AssistanceCommand,
    GoalCommand,
)
from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder
from hub.ipc.definition import MessageDefinition
from hub.values import dataclass


class AutonomyLevel(enum.IntEnum):
    """The most that robots do by themselves.

    Attributes:
        TELEOPERATION: Nothing: they follow keys and sticks.
        GOALS: They go to points, turn, and return to their start.
        EXPLORATION: They choose their goals too.
    """

    TELEOPERATION = 0
    GOALS = 1
    EXPLORATION = 2


class AssistanceRule(enum.Enum):
    """Whether robots stop before obstacles.

    Attributes:
        SWITCHED: As the operator switches it.
        ON: Always.
        OFF: Never.
    """

    SWITCHED = "switched"
    ON = "on"
    OFF = "off"


AUTONOMY = tuple(each.name.lower() for each in AutonomyLevel)
ASSISTANCE = tuple(each.value for each in AssistanceRule)
"""Names of the levels."""
_BEHAVIOURS = {
    Behaviour.HOLD: AutonomyLevel.TELEOPERATION,
    Behaviour.GO: AutonomyLevel.GOALS,
    Behaviour.FOLLOW: AutonomyLevel.GOALS,
    Behaviour.RETURN: AutonomyLevel.GOALS,
}
"""The least level that allows a behaviour; of all others it is exploration."""
_WORDS = {
    AutonomyLevel.GOALS: "robots do not drive by themselves",
    AutonomyLevel.EXPLORATION: "robots do not choose their goals",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatingLimits:
    """What robots may do by themselves.

    Attributes:
        autonomy: The most of it.
        assistance: Whether they stop before obstacles.
    """

    autonomy: AutonomyLevel = AutonomyLevel.EXPLORATION
    assistance: AssistanceRule = AssistanceRule.SWITCHED

    @classmethod
    def read(cls, text: str) -> Self | None:
        """The limits of a text such as `goals/off`; None: it is none."""
        autonomy, _, assistance = text.partition("/")
        if autonomy not in AUTONOMY or assistance not in ASSISTANCE:
            return None
        level = AutonomyLevel[autonomy.upper()]
        return cls(autonomy=level, assistance=AssistanceRule(assistance))

    def __str__(self) -> str:
        return f"{self.autonomy.name.lower()}/{self.assistance.value}"

    @property
    def kept(self) -> AssistanceCommand | None:
        """The command that keeps assistance as it has to be; None: the operator switches it."""
        if self.assistance is AssistanceRule.SWITCHED:
            return None
        return AssistanceCommand(assistance=Assistance[self.assistance.name])

    def refusal(self, definition: MessageDefinition[Any], value: object) -> str:
        """Why a message may not be sent; empty: it may."""
        if definition.name == ASSISTANCE_COMMAND.name:
            if self.kept is None or value == self.kept:
                return ""
            return f"assistance stays {self.assistance.value}"
        needed = needed_for(definition.name, value)
        return _WORDS[needed] if needed > self.autonomy else ""


NO_LIMITS = OperatingLimits()


def needed_for(message: str, value: object) -> AutonomyLevel:
    """The least level of autonomy that allows a message; a strange value needs the highest."""
    if message == GOAL_COMMAND.name:
        ends = isinstance(value, GoalCommand) and not value.points
        return AutonomyLevel.TELEOPERATION if ends else AutonomyLevel.GOALS
    if message == TURN_COMMAND.name:
        return AutonomyLevel.GOALS
    if message == AUTONOMY_COMMAND.name:
        behaviour = value.behaviour if isinstance(value, AutonomyCommand) else None
        return _BEHAVIOURS.get(behaviour, AutonomyLevel.EXPLORATION)  # type: ignore[arg-type]
    if message == VEHICLE_COMMAND.name and isinstance(value, VehicleCommand):
        return AutonomyLevel.GOALS if _goes(value) else AutonomyLevel.TELEOPERATION
    return AutonomyLevel.TELEOPERATION


def _goes(command: VehicleCommand) -> bool:
    """Whether a vehicle goes somewhere by itself then."""
    if command.order is VehicleOrder.MODE:
        return command.name not in OPERATED_MODES
    return command.order is VehicleOrder.HOLD and not math.isnan(command.value)
