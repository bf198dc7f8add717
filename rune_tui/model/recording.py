"""The state of a robot's own recorder, and its reports to the operator."""

from __future__ import annotations

from collections.abc import Iterator

from hub.gcm.recording import RECORD_STATE, RecordState
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import RobotState


def recording_of(robot: RobotState) -> RecordState | None:
    """What the robot's recorder reports; None: it reports nothing."""
    newest = robot.newest(RECORD_STATE)
    return newest.value if newest is not None else None


class RecordingWatch:
    """Compares each robot's recorder with its last state."""

    def __init__(self) -> None:
        self._known: dict[str, RecordState] = {}

    def look(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """Reports since the last call."""
        now = recording_of(robot)
        if now is None:
            return
        before = self._known.get(robot.name, now)
        self._known[robot.name] = now
        for text, alarm in _changes(before, now):
            yield state.notice(text, robot=robot.name, alarm=alarm)


def _changes(before: RecordState, now: RecordState) -> Iterator[tuple[str, bool]]:
    """The changes in words, and whether each needs the operator."""
    if now.recording and (not before.recording or now.begun != before.begun):
        yield f"the robot records to {now.path}", False
    elif before.recording and not now.recording:
        yield f"the robot's recording is ended: {before.size_mb:.1f} MB", False
    if now.marks > before.marks:
        text = f": {now.mark}" if now.mark else ""
        yield f"mark {now.marks} is in the recording{text}", False
    if now.lost > before.lost:
        yield f"{now.lost - before.lost} messages are missing in the recording", False
    if now.fault != before.fault:
        yield (now.fault, True) if now.fault else ("all is recorded again", False)
