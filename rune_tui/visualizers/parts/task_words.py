"""Words about a robot's task: on the status line, and row by row."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hub.gcm.autonomy import Phase
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.robot_task import RobotTask, task_of, tasks_heard
from rune_tui.visualizers.parts.severity import Part, Severity

SHOWN_S = {Phase.DONE: 30.0, Phase.BLOCKED: 120.0, Phase.LOST: 120.0, Phase.REFUSED: 30.0}
"""Time for which an outcome stays on the status line [s]; others: OTHERS_S."""
OTHERS_S = 10.0
SILENT_S = 3.0
"""Age of a report from which it may be outdated [s]."""

_OUTCOME_WEIGHT = 2.5
"""Weight of an outcome: the owner, the battery and the nearest obstacle come first."""
_SEVERITIES = {
    Phase.WAITING: Severity.WARNING,
    Phase.DONE: Severity.GOOD,
    Phase.BLOCKED: Severity.WARNING,
    Phase.LOST: Severity.WARNING,
    Phase.REFUSED: Severity.WARNING,
}
_OUTCOMES = {
    Phase.DONE: "DONE",
    Phase.BLOCKED: "BLOCKED",
    Phase.STOPPED: "STOPPED",
    Phase.TAKEN_OVER: "ENDED",
    Phase.LOST: "GIVEN UP",
    Phase.REFUSED: "REFUSED",
}


def task_parts(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The short form, for the status line: the task, or for a while its outcome.

    An outcome from before the console's start is history.
    """
    task, now = task_of(robot), state.now
    if task is None or task.phase is Phase.IDLE:
        return
    severity = _SEVERITIES.get(task.phase, Severity.PLAIN)
    if task.under_way and now - task.measured > SILENT_S:
        silent = duration(now - task.measured)
        text = f"{head(task)}, NOT HEARD FOR {silent}"
        yield Part(text, 7, Severity.WARNING, cause="task")
    elif task.phase is Phase.WAITING:
        why = task.why.removeprefix("waits").lstrip(" ,:;")
        text = f"{head(task)}: {why}" if why else head(task)
        yield Part(text, 7, severity, short=head(task), cause="task")
    elif task.under_way:
        yield Part(head(task), 7, severity)
    elif task.age(now) < min(SHOWN_S.get(task.phase, OTHERS_S), now - state.began):
        text = f"{head(task)}: {task.reason}"
        yield Part(text, _OUTCOME_WEIGHT, severity, short=head(task), cause="task")


def task_rows(robot: RobotState, now: float) -> Iterator[Part]:
    """All words, a row each."""
    task = task_of(robot)
    if task is None:
        nothing = "nothing yet: the robot has done nothing by itself"
        unknown = "not known: the robot reports no tasks"
        yield Part(nothing if tasks_heard(robot) else unknown, 0, Severity.FAINT)
        return
    short = f"{task.kind.upper()} WAITS" if task.phase is Phase.WAITING else ""
    yield Part(head(task), 9, _SEVERITIES.get(task.phase, Severity.PLAIN), short=short)
    if task.reason:
        yield Part(task.reason, 6)
    if task.under_way and math.isfinite(task.x) and math.isfinite(task.y):
        left = f", {task.left_m:.1f} m to go" if math.isfinite(task.left_m) else ""
        yield Part(f"to {task.x:.1f}, {task.y:.1f} m{left}", 7)
    if task.under_way and math.isfinite(task.edge_m):
        text = f"{task.edge_m:.1f} m of the map's edge are left to explore"
        yield Part(text, 4, short=f"{task.edge_m:.1f} m of edge left")
    took = f"{'for' if task.under_way else 'took'} {duration(task.seconds)}"
    if task.under_way:
        yield Part(took, 3, Severity.FAINT)
    else:
        ago = f"ended {duration(task.age(now))} ago"
        yield Part(f"{took}, {ago}", 8, Severity.FAINT, short=ago)


def head(task: RobotTask) -> str:
    """The kind of the task in capitals with its number, or its outcome."""
    kind = task.kind.upper()
    share = f" {100.0 * task.explored:.0f} %" if 0.0 <= task.explored <= 1.0 else ""
    if task.under_way:
        way = f" {task.left_m:.1f} m" if math.isfinite(task.left_m) and not share else ""
        waits = ", WAITS" if task.phase is Phase.WAITING else ""
        return f"{kind}{share}{way}{waits}"
    return f"{kind}{share} {_OUTCOMES[task.phase]}"


def goal_word(task: RobotTask, now: float) -> tuple[str, Severity]:
    """The words at a task's target on the map, and their severity; empty: none."""
    if task.phase is Phase.WAITING:
        return "G waits", Severity.WARNING
    if task.under_way:
        return "G", Severity.GOOD
    if task.age(now) >= SHOWN_S.get(task.phase, OTHERS_S):
        return "", Severity.PLAIN
    if task.phase is Phase.DONE:
        return "G reached", Severity.GOOD
    return f"G {_OUTCOMES[task.phase]}", _SEVERITIES.get(task.phase, Severity.FAINT)


def duration(seconds: float) -> str:
    """A time in whole seconds, from two minutes on in minutes; "?" where it is not known."""
    if not math.isfinite(seconds):
        return "?"
    whole = int(max(0.0, seconds))
    return f"{whole} s" if whole < 120 else f"{whole // 60} min {whole % 60} s"
