"""Control of a robot, as this console sees it, and what the console may send; pure."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Iterator

from hub.gcm.control import CONTROL_STATE, ControlAction, ControlState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ControlEffect, Effect, Notify
from rune_tui.model.robot_state import LinkPhase, RobotState

_ANSWERS = ((Purpose.GRANT_CONTROL, "hands it over"), (Purpose.DENY_CONTROL, "keeps it"))


class Standing(enum.Enum):
    """The state of control, for this console.

    Attributes:
        UNKNOWN: There is no link, or the hub does not report it.
        FREE: No console has control.
        MINE: This console has control.
        OTHERS: Another console has control.
    """

    UNKNOWN = "unknown"
    FREE = "free"
    MINE = "mine"
    OTHERS = "others"


def control_of(robot: RobotState | None) -> ControlState | None:
    """The hub's report of control; None: there is no link, or the hub does not report it."""
    if robot is None or robot.link.phase is not LinkPhase.CONNECTED:
        return None
    received = robot.newest(CONTROL_STATE)
    return received.value if received is not None else None


def standing(robot: RobotState | None) -> Standing:
    """The state of control of a robot now."""
    control = control_of(robot)
    if robot is None or control is None:
        return Standing.UNKNOWN
    if not control.owner:
        return Standing.FREE
    return Standing.MINE if control.owner == robot.link.number else Standing.OTHERS


def asks(robot: RobotState) -> bool:
    """Whether this console's request for control is the present one."""
    control = control_of(robot)
    return control is not None and control.asker == robot.link.number != 0


def seconds_left(robot: RobotState, now: float) -> int:
    """Time that is left to answer the present request [s], in whole seconds."""
    received = robot.newest(CONTROL_STATE)
    if received is None:
        return 0
    return max(0, math.ceil(received.value.left_s - received.age(now)))


def owner_words(robot: RobotState) -> str:
    """The owner, and since when, for people."""
    control = control_of(robot)
    if control is None or not control.owner:
        return "nobody has control"
    since = f" since {robot.link.owned_since}" if robot.link.owned_since else ""
    who = "you have" if standing(robot) is Standing.MINE else f"{control.operator} has"
    return f"{who} control{since}"


def take_key_words(robot: RobotState, state: ConsoleState) -> str:
    """The key that takes or requests control, in words; empty if there is none."""
    key = state.input_of(Purpose.TAKE_CONTROL, robot.name) if robot.link.may_command else ""
    does = "take it" if standing(robot) is Standing.FREE else "ask"
    return f"press {key} to {does}" if key else ""


def answer_keys(robot: RobotState, state: ConsoleState) -> Iterator[str]:
    """The keys that answer a request, in words."""
    for purpose, does in _ANSWERS:
        if key := state.input_of(purpose, robot.name):
            yield f"{key} {does}"


def refused(
    effects: Iterable[Effect], state: ConsoleState, by_hand: frozenset[str]
) -> RobotState | None:
    """The robot whose control one of these effects needs; None: all may be sent.

    Args:
        effects: Effects of a widget at one moment.
        state: Of the console.
        by_hand: Robots for which only a key takes control, not a drive command.
    """
    for effect in effects:
        if not (name := effect.controlled):
            continue
        robot = state.robots.get(name)
        stands = standing(robot)
        by_key = stands is Standing.FREE and name in by_hand and effect.takes_control
        if stands is Standing.OTHERS or by_key:
            return robot
    return None


def refusal(robot: RobotState, state: ConsoleState) -> Notify:
    """A notice that names the reason for a refusal, and what to do."""
    words = "; ".join(filter(None, (owner_words(robot), take_key_words(robot, state))))
    return Notify.now(state, words, robot=robot.name)


def taking(effects: Iterable[Effect], state: ConsoleState) -> tuple[Effect, ...]:
    """Requests for control of the free robots that these effects drive."""
    driven = dict.fromkeys(each.controlled for each in effects if each.takes_control)
    free = [name for name in driven if standing(state.robots.get(name)) is Standing.FREE]
    take = ControlAction.TAKE
    return tuple(ControlEffect(robot=name, action=take, by_driving=True) for name in free)


def is_lost(before: Standing, now: Standing) -> bool:
    """Whether held inputs must be released, because the owner has changed."""
    if now is before:
        return False
    if before is Standing.UNKNOWN:
        return now is Standing.OTHERS
    return (before, now) != (Standing.FREE, Standing.MINE)
