"""Reports when tasks of robots begin, wait and end, each once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

from hub.gcm.autonomy import Phase
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import RobotState
from rune_tui.model.robot_task import RobotTask, autonomy_task, operator_task

WAIT_S: Final = 4.0
"""Shorter waits are not reported [s]."""

_SOURCES: Final[tuple[Callable[[RobotState], RobotTask | None], ...]] = (
    autonomy_task,
    operator_task,
)
_VERBS: Final = {
    Phase.DONE: "done",
    Phase.BLOCKED: "BLOCKED",
    Phase.STOPPED: "stopped",
    Phase.TAKEN_OVER: "ended",
    Phase.LOST: "GIVEN UP",
    Phase.REFUSED: "REFUSED",
}


class TaskWatch:
    """Compares each robot's tasks with their last state."""

    def __init__(self) -> None:
        self._before: dict[tuple[str, int], RobotTask | None] = {}
        self._waits: dict[tuple[str, int], tuple[str, float]] = {}
        self._reported: dict[tuple[str, int], str] = {}

    def look(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """Tasks that began, wait or ended since the last call."""
        for index, source in enumerate(_SOURCES):
            key = robot.name, index
            now = source(robot)
            before = self._before.get(key)
            self._before[key] = now
            yield from self._changed(robot, state, before, now)
            yield from self._waiting(key, robot, state, now)

    @staticmethod
    def _changed(
        robot: RobotState,
        state: ConsoleState,
        before: RobotTask | None,
        now: RobotTask | None,
    ) -> Iterator[Notice]:
        """The begin or end of a task, with its time."""
        same = before is not None and now is not None and before.number == now.number
        if before is not None and before.under_way and not same:
            known = now is not None and now.number > before.number
            why = "another task began" if known else "the robot no longer reports it"
            text = f"{before.kind} ended: {why}"
            yield state.notice(text, robot=robot.name, alarm=not known)
        if now is None:
            return
        if now.under_way:
            if not same:
                yield state.notice(_begun(now), robot=robot.name, ago=now.since_begin(state.now))
        elif not same or (before is not None and before.under_way):
            took = f" ({now.seconds:.0f} s)" if now.seconds >= 1.0 else ""
            text = f"{now.kind} {_VERBS[now.phase]}: {now.reason}{took}"
            yield state.notice(text, robot=robot.name, alarm=now.failed, ago=now.age(state.now))
        elif before is not None and before.why != now.why:
            # A robot's own navigation says why it gave up a little later.
            yield state.notice(f"{now.kind} {_VERBS[now.phase]}: {now.reason}", robot=robot.name)

    def _waiting(
        self, key: tuple[str, int], robot: RobotState, state: ConsoleState, now: RobotTask | None
    ) -> Iterator[Notice]:
        """A long wait, and its end."""
        if now is None or now.phase is not Phase.WAITING:
            self._waits.pop(key, None)
            if self._reported.pop(key, "") and now is not None and now.phase is Phase.ACTIVE:
                yield state.notice(f"{now.kind} goes on", robot=robot.name)
            return
        why, since = self._waits.get(key, ("", state.now))
        if why != now.why:
            why, since = now.why, state.now if not why else since
            self._waits[key] = why, since
        if state.now - since >= WAIT_S and self._reported.get(key) != why:
            self._reported[key] = why
            yield state.notice(f"{now.kind} {why}", robot=robot.name)


def _begun(task: RobotTask) -> str:
    place = f" to {task.x:.1f}, {task.y:.1f} m" if math.isfinite(task.x + task.y) else ""
    return f"{task.kind}{place if task.kind == 'going' else ''} begins"
