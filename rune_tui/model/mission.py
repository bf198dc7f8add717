"""The state of a robot's mission, and its reports to the operator."""

from __future__ import annotations

from collections.abc import Iterator

from hub.gcm.mission import MISSION_STATE, MissionState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import RobotState

OLD_S = 60.0
"""A saved map that is older than this is not called fresh [s]."""


def mission_of(robot: RobotState) -> MissionState | None:
    """The mission that the robot reports; None: it reports none."""
    newest = robot.newest(MISSION_STATE)
    return newest.value if newest is not None else None


class MissionWatch:
    """Compares each robot's mission with its last state."""

    def __init__(self) -> None:
        self._known: dict[str, MissionState] = {}

    def look(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """Reports since the last call."""
        now = mission_of(robot)
        if now is None:
            return
        before = self._known.get(robot.name)
        self._known[robot.name] = now
        if before is None:
            if now.running:
                text = f"mission {now.name} runs, {_marks(now)}"
                yield state.notice(text, robot=robot.name)
            before = now
        key = state.input_of(Purpose.MISSION, robot.name)
        for text, alarm in _changes(before, now, key):
            yield state.notice(text, robot=robot.name, alarm=alarm)


def _changes(before: MissionState, now: MissionState, key: str) -> Iterator[tuple[str, bool]]:
    """The changes in words, and whether each needs the operator."""
    again = (now.running, now.begun) != (before.running, before.begun)
    if again and now.running:
        yield f"mission {now.name} begins", False
    elif again and before.running:
        more = f"; {key} begins another" if key else ""
        yield f"mission {before.name} is ended, {_marks(before)}{more}", False
    elif now.running and now.name != before.name:
        yield f"the mission is named {now.name}", False
    if now.running and not again and now.sheet > before.sheet:
        stay = f"; {now.earlier} marks stay on the sheets before" if now.earlier else ""
        yield f"sheet {now.sheet} of the map begins{stay}", now.earlier > before.earlier
    if now.fault != before.fault:
        if now.fault:
            yield f"NOT KEPT: {now.fault}", True
        else:
            yield "all of the mission is kept again", False


def _marks(mission: MissionState) -> str:
    count = mission.marks + mission.earlier
    return f"{count} mark{'' if count == 1 else 's'} kept"
