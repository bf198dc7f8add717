"""Words about a robot's own recorder, for the status line and for alarms."""

from __future__ import annotations

from collections.abc import Iterator

from rune_tui.model.recording import recording_of
from rune_tui.model.robot_state import RobotState
from rune_tui.visualizers.parts.severity import Part, Severity


def recording_parts(robot: RobotState) -> Iterator[Part]:
    """What the robot records, what is lost of it, and why it records nothing."""
    recording = recording_of(robot)
    if recording is None:
        return
    if recording.recording:
        minutes = int(recording.running_s) // 60
        time = f"{minutes // 60}:{minutes % 60:02}"
        text = f"ROBOT REC {time} h {recording.size_mb:.0f} MB"
        yield Part(text, 3, short=f"RREC {time}")
    elif recording.ring:
        yield Part(f"RING {_span(recording.ring_s)}", 1)
    if recording.fault:
        text, short = f"NOT RECORDED: {recording.fault}", "NOT RECORDED"
        yield Part(text, 6, Severity.WARNING, short, cause="recording")
    elif recording.lost and (recording.recording or recording.ring):
        yield Part(f"{recording.lost} LOST", 4, Severity.WARNING)


def _span(seconds: float) -> str:
    """A span of time: "90 s", "12 min", "2.0 h"."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"
