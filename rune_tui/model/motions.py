"""Reports why a robot does not move, once for each change."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.gcm.diagnostics import SLEEP
from hub.gcm.navigation import MotionState
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.control import Standing, control_of, standing
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import problems_of

_RELEASE: Final = "release all keys, then drive"
_WORDS: Final = {
    MotionState.NO_DRIVER: "its driver does not report: it cannot move",
    MotionState.STOPPED: f"it was stopped: {_RELEASE}",
    MotionState.WAITING: f"it waits: {_RELEASE}",
}
_AGAIN: Final = "its driver reports again"


class MotionWatch:
    """Compares navigation's use of commands with its last state."""

    def __init__(self) -> None:
        self._before: dict[str, tuple[MotionState, int]] = {}
        self._slept: dict[str, str] = {}

    def look(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """The changes since the last call; of its motion, the first call returns none."""
        yield from self._sleeps(robot, state)
        if robot.navigation is None:
            return
        control = control_of(robot)
        motion, owner = robot.navigation.value.motion, control.owner if control else 0
        before, owner_before = self._before.get(robot.name, (motion, owner))
        self._before[robot.name] = motion, owner
        if motion is before:
            return
        again = before is MotionState.NO_DRIVER
        # A change of control has its own event.
        handed = motion is MotionState.WAITING and not again and owner != owner_before
        others = motion is MotionState.WAITING and standing(robot) is Standing.OTHERS
        words = "" if handed or others else _WORDS.get(motion, "")
        if text := "; ".join(filter(None, (_AGAIN if again else "", words))):
            yield state.notice(text, robot=robot.name)

    def _sleeps(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """A sleep of the robot's computer, once."""
        slept = next((each for each in problems_of(robot) if each.value.name == SLEEP), None)
        before = self._slept.get(robot.name, "")
        now = self._slept[robot.name] = slept.value.message if slept is not None else ""
        if slept is not None and now != before:
            yield state.notice(now, robot=robot.name, ago=slept.age(state.now))
