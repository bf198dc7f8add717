"""Who has control of a robot, as this console sees it, and what it may send; pure."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Iterator
from typing import TypeGuard

from hub.gcm.control import CONTROL_STATE, DRIVING, RESTRICTED, ControlAction, ControlState
from hub.gcm.navigation import Twist
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ControlEffect, Effect, SendEffect, Tell
from rune_tui.model.robot_state import LinkPhase, RobotState

_ANSWERS = ((Purpose.GRANT_CONTROL, "hands it over"), (Purpose.DENY_CONTROL, "keeps it"))


class Standing(enum.Enum):
    """How this console stands to a robot.

    Attributes:
        UNKNOWN: There is no link, or the hub does not say.
        FREE: Nobody has control.
        MINE: This console has it.
        OTHERS: Another one has it.
    """

    UNKNOWN = "unknown"
    FREE = "free"
    MINE = "mine"
    OTHERS = "others"


def control_of(robot: RobotState | None) -> ControlState | None:
    """What the robot's hub says of control; None while there is no link, or it does not say."""
    if robot is None or robot.link.phase is not LinkPhase.CONNECTED:
        return None
    received = robot.newest(CONTROL_STATE)
    return received.value if received is not None else None


def standing(robot: RobotState | None) -> Standing:
    """How this console stands to a robot now."""
    control = control_of(robot)
    if robot is None or control is None:
        return Standing.UNKNOWN
    if not control.owner:
        return Standing.FREE
    return Standing.MINE if control.owner == robot.link.number else Standing.OTHERS


def asks(robot: RobotState) -> bool:
    """Whether this console asks for control, and its turn has come."""
    control = control_of(robot)
    return control is not None and control.asker == robot.link.number != 0


def seconds_left(robot: RobotState, now: float) -> int:
    """How long the owner has to answer who asks now [s], in whole seconds."""
    received = robot.newest(CONTROL_STATE)
    if received is None:
        return 0
    return max(0, math.ceil(received.value.left_s - received.age(now)))


def owner_words(robot: RobotState) -> str:
    """Who has control, and since when, for people."""
    control = control_of(robot)
    if control is None or not control.owner:
        return "nobody has control"
    since = f" since {robot.link.owned_since}" if robot.link.owned_since else ""
    who = "you have" if standing(robot) is Standing.MINE else f"{control.operator} has"
    return f"{who} control{since}"


def to_take(robot: RobotState, state: ConsoleState) -> str:
    """Which key takes control or asks for it, for people; empty if none does."""
    key = state.input_of(Purpose.TAKE_CONTROL, robot.name) if robot.link.may_command else ""
    does = "take it" if standing(robot) is Standing.FREE else "ask"
    return f"press {key} to {does}" if key else ""


def answer_keys(robot: RobotState, state: ConsoleState) -> Iterator[str]:
    """Which keys answer who asks, in words."""
    for purpose, does in _ANSWERS:
        if key := state.input_of(purpose, robot.name):
            yield f"{key} {does}"


def refused(
    effects: Iterable[Effect], state: ConsoleState, by_hand: frozenset[str]
) -> RobotState | None:
    """The robot whose owner alone may send one of these; None if they may all be sent.

    Args:
        effects: What a widget wants done at one moment.
        state: Of the console.
        by_hand: Robots of which control is taken by its own key alone, not by driving.
    """
    for command in filter(_is_command, effects):
        robot = state.robots.get(command.robot)
        stands = standing(robot)
        waits = stands is Standing.FREE and _drives(command) and command.robot in by_hand
        if stands is Standing.OTHERS or waits:
            return robot
    return None


def refusal(robot: RobotState, state: ConsoleState) -> Tell:
    """Why nothing was sent, and what to do."""
    words = "; ".join(filter(None, (owner_words(robot), to_take(robot, state))))
    return Tell.now(state, words, robot=robot.name)


def taking(effects: Iterable[Effect], state: ConsoleState) -> tuple[Effect, ...]:
    """Requests for control of the free robots that these effects drive."""
    free = dict.fromkeys(
        command.robot
        for command in filter(_is_command, effects)
        if _drives(command) and standing(state.robots.get(command.robot)) is Standing.FREE
    )
    take = ControlAction.TAKE
    return tuple(ControlEffect(robot=name, action=take, by_driving=True) for name in free)


def _is_command(effect: Effect) -> TypeGuard[SendEffect]:
    """Whether only the owner of a robot may send it; everybody may send zero speed."""
    if not isinstance(effect, SendEffect) or effect.definition.name not in RESTRICTED:
        return False
    return not (isinstance(effect.value, Twist) and effect.value.neutral)


def _drives(command: SendEffect) -> bool:
    return command.definition.name in DRIVING


def is_lost(before: Standing, now: Standing) -> bool:
    """Whether what is held must not go on: whose commands count has changed."""
    if now is before:
        return False
    if before is Standing.UNKNOWN:
        return now is Standing.OTHERS
    return (before, now) != (Standing.FREE, Standing.MINE)
