"""Words about control: its owner, requests for it, and the keys to answer them."""

from __future__ import annotations

from collections.abc import Iterator

from hub.gcm.autonomy import DrivingMode
from hub.gcm.control import WARNED_S, ControlState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import (
    Standing,
    answer_keys,
    asks,
    control_of,
    owner_words,
    seconds_left,
    standing,
    take_key_words,
)
from rune_tui.model.robot_state import RobotState
from rune_tui.visualizers.parts.severity import Part, Severity


def control_parts(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The short form, for the status line and for alarms."""
    control = control_of(robot)
    if control is None:
        return
    stands = standing(robot)
    if stands is Standing.OTHERS:
        yield Part(f"{control.operator} has control", 7)
    elif stands is Standing.MINE:
        yield Part("you have control", 4.5, Severity.GOOD, short="yours")
    else:
        yield Part("nobody has control", 4.5, short="nobody")
    yield from request_parts(robot, state)
    yield from _silence(control, mine=stands is Standing.MINE)


def control_rows(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """All words, a row each; a request comes first."""
    control = control_of(robot)
    if control is None:
        yield Part("control: not known", 6, Severity.FAINT, short="not known")
        return
    stands = standing(robot)
    severities = {Standing.OTHERS: Severity.WARNING, Standing.MINE: Severity.GOOD}
    words = owner_words(robot)
    short = words.partition(" since")[0]
    yield Part(words, 6.5, severities.get(stands, Severity.PLAIN), short=short)
    yield from request_parts(robot, state)
    yield from _silence(control, mine=stands is Standing.MINE)
    moved = "moves the robot"
    if control.commander is DrivingMode.NOBODY:
        yield Part(f"nobody {moved}", 2, Severity.FAINT)
    else:
        yield Part(f"{control.commander_name} {moved}", 4)
    if hint := _hint(robot, state):
        yield Part(hint, 3, Severity.FAINT)
    yield Part(control.why, 0, Severity.FAINT)


def request_parts(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The request for control, the time left to answer it, and the key that answers."""
    control = control_of(robot)
    if control is None or not control.asker:
        return
    left = f"{seconds_left(robot, state.now)} s"
    more = f", {control.waiting} more wait" if control.waiting else ""
    if asks(robot):
        yield Part(f"you ask {control.operator}: {left}", 8, Severity.WARNING)
    elif standing(robot) is Standing.MINE:
        keys = ", ".join(answer_keys(robot, state))
        answers = f": {keys}" if keys else ""
        text = f"{control.asker_operator} ASKS FOR CONTROL, {left}{answers}{more}"
        yield Part(text, 9, Severity.ALARM, cause="control")
    else:
        text = f"{control.asker_operator} asks {control.operator}: {left}{more}"
        yield Part(text, 3)


def _silence(control: ControlState, *, mine: bool) -> Iterator[Part]:
    if control.owner and control.silent_s >= WARNED_S:
        other = f"{control.operator}'s console is silent"
        text = "the hub does not hear you" if mine else other
        yield Part(text, 6, Severity.WARNING, cause="silence")


def _hint(robot: RobotState, state: ConsoleState) -> str:
    if standing(robot) is not Standing.MINE:
        return "" if asks(robot) else take_key_words(robot, state)
    key = state.input_of(Purpose.RELEASE_CONTROL, robot.name)
    return f"press {key} to give it up" if key else ""
