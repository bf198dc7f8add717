"""Reports what a robot's autopilot does and says, once for each change.

| change | notice |
| --- | --- |
| it follows velocities, or is disarmed | says so |
| it is armed for 0.5 s in a mode of its own or of another | why; an alarm while a failsafe acts |
| it is gone | an alarm with the reason |
| it refuses an order | an alarm with its own reason |
| a text of an error | an alarm; no alarm if it is a check before arming |
| a text of a warning | the text |
| a text that only informs, or repeats a check before arming | none: the pane shows it |
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.gcm.autopilot import AutopilotPhase, AutopilotState, AutopilotText
from hub.gcm.diagnostics import Severity
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import autopilot_of

_ARMED: Final = (AutopilotPhase.DRIVING, AutopilotPhase.ELSEWHERE)
SETTLED_S: Final = 0.5
"""Time after which it is reported that it does not follow: a change of mode takes less [s]."""
_CHECKS: Final = ("PreArm:", "Arm:")
"""Begin the texts of checks before arming, which vehicles repeat every 30 s."""


class AutopilotWatch:
    """Compares the autopilot of each robot with its last state."""

    def __init__(self) -> None:
        self._before: dict[str, AutopilotState] = {}
        self._numbers: dict[str, int] = {}
        self._checks: dict[str, set[str]] = {}
        self._away: dict[str, tuple[str, float]] = {}
        """Why each robot does not follow, and since when; infinite: it was reported."""

    def look(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """The changes since the last call; the first state of a robot is none."""
        yield from self._said(robot, state)
        now = autopilot_of(robot)
        if now is None:
            return
        before = self._before.get(robot.name, now)
        self._before[robot.name] = now
        if before.phase is AutopilotPhase.DISARMED is not now.phase:
            self._checks.pop(robot.name, None)
        for text, alarm in _changes(before, now):
            yield state.notice(text, robot=robot.name, alarm=alarm)
        if now.phase is not AutopilotPhase.ELSEWHERE:
            self._away.pop(robot.name, None)
        elif now.refusal != before.refusal:
            self._away[robot.name] = now.why, math.inf
        else:
            yield from self._not_followed(robot, now, state)

    def _not_followed(
        self, robot: RobotState, now: AutopilotState, state: ConsoleState
    ) -> Iterator[Notice]:
        """Why it does not follow, once that has settled."""
        why, since = self._away.get(robot.name, ("", math.inf))
        if why != now.why:
            self._away[robot.name] = now.why, state.now
        elif state.now - since >= SETTLED_S:
            self._away[robot.name] = why, math.inf
            yield state.notice(why, robot=robot.name, alarm=bool(now.failsafe))

    def _said(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """What the autopilot said since the last call, in its own words."""
        last = self._numbers.get(robot.name, -1)
        for text in robot.texts:
            if text.number <= last:
                continue
            self._numbers[robot.name] = text.number
            if self._is_reported(robot.name, text.value):
                words = f"it says: {text.value.text}"
                fault, ago = is_fault(text.value), text.age(state.now)
                yield state.notice(words, robot=robot.name, alarm=fault, ago=ago)

    def _is_reported(self, robot: str, text: AutopilotText) -> bool:
        if text.level is Severity.OK:
            return False
        if not _is_check(text):
            return True
        known = self._checks.setdefault(robot, set())
        if text.text in known:
            return False
        known.add(text.text)
        return True


def is_fault(text: AutopilotText) -> bool:
    """Whether an autopilot reports a fault, such as a leak, and no check before arming."""
    return text.level is Severity.ERROR and not _is_check(text)


def _is_check(text: AutopilotText) -> bool:
    return text.text.startswith(_CHECKS)


def _changes(before: AutopilotState, now: AutopilotState) -> Iterator[tuple[str, bool]]:
    """The changes in words, and whether each needs the operator."""
    if now.refusal and now.refusal != before.refusal:
        yield now.refusal, True
        return
    entered = now.phase is not before.phase
    match now.phase:
        case AutopilotPhase.DRIVING if entered:
            yield f"it follows you in the mode {now.mode}", False
        case AutopilotPhase.DISARMED if before.phase in _ARMED:
            yield "it is disarmed", False
        case AutopilotPhase.GONE if entered:
            yield f"the autopilot is gone: {now.why}", True
        case AutopilotPhase.LEARNING if entered and now.why:
            yield f"it is asked for everything again: {now.why}", False
