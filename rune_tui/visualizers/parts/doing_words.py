"""Words about a robot's task: on the status line, and row by row."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hub.gcm.autonomy import Phase
from rune_tui.model.doing import Doing, doing_of
from rune_tui.model.robot_state import RobotState
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


def doing_parts(robot: RobotState, now: float) -> Iterator[Part]:
    """The short form, for the status line: what it does, or for a while how that ended."""
    doing = doing_of(robot)
    if doing is None or doing.phase is Phase.IDLE:
        return
    severity = _SEVERITIES.get(doing.phase, Severity.PLAIN)
    if doing.under_way and now - doing.measured > SILENT_S:
        silent = duration(now - doing.measured)
        yield Part(f"{head(doing)}, NOT HEARD FOR {silent}", 7, Severity.WARNING)
    elif doing.phase is Phase.WAITING:
        yield Part(doing.why.replace("waits", "WAITS", 1), 7, severity, short="WAITS")
    elif doing.under_way:
        yield Part(head(doing), 7, severity)
    elif doing.age(now) < SHOWN_S.get(doing.phase, OTHERS_S):
        yield Part(f"{head(doing)}: {doing.reason}", _OUTCOME_WEIGHT, severity, short=head(doing))


def doing_rows(robot: RobotState, now: float) -> Iterator[Part]:
    """All of it, a row each."""
    doing = doing_of(robot)
    if doing is None:
        yield Part("nothing yet: the robot has done nothing by itself", 0, Severity.FAINT)
        return
    yield Part(head(doing), 0, _SEVERITIES.get(doing.phase, Severity.PLAIN))
    if doing.reason:
        yield Part(doing.reason, 0)
    if doing.under_way and math.isfinite(doing.x) and math.isfinite(doing.y):
        left = f", {doing.left_m:.1f} m to go" if math.isfinite(doing.left_m) else ""
        yield Part(f"to {doing.x:.1f}, {doing.y:.1f} m{left}", 0)
    if doing.under_way and math.isfinite(doing.edge_m):
        yield Part(f"{doing.edge_m:.1f} m of the map's edge are left to explore", 0)
    took = f"{'for' if doing.under_way else 'took'} {duration(doing.seconds)}"
    ago = "" if doing.under_way else f", ended {duration(doing.age(now))} ago"
    yield Part(f"{took}{ago}", 0, Severity.FAINT)


def head(doing: Doing) -> str:
    """The kind of the task in capitals with its number, or its outcome."""
    kind = doing.kind.upper()
    share = f" {100.0 * doing.explored:.0f} %" if 0.0 <= doing.explored <= 1.0 else ""
    if doing.under_way:
        way = f" {doing.left_m:.1f} m" if math.isfinite(doing.left_m) and not share else ""
        waits = ", WAITS" if doing.phase is Phase.WAITING else ""
        return f"{kind}{share}{way}{waits}"
    return f"{kind}{share} {_OUTCOMES[doing.phase]}"


def goal_word(doing: Doing, now: float) -> tuple[str, Severity]:
    """The words at a task's target on the map, and their severity; empty: none."""
    if doing.phase is Phase.WAITING:
        return "G waits", Severity.WARNING
    if doing.under_way:
        return "G", Severity.GOOD
    if doing.age(now) >= SHOWN_S.get(doing.phase, OTHERS_S):
        return "", Severity.PLAIN
    if doing.phase is Phase.DONE:
        return "G reached", Severity.GOOD
    return f"G {_OUTCOMES[doing.phase]}", _SEVERITIES.get(doing.phase, Severity.FAINT)


def duration(seconds: float) -> str:
    """A time in whole seconds, from two minutes on in minutes."""
    whole = int(max(0.0, seconds)) if math.isfinite(seconds) else 0
    return f"{whole} s" if whole < 120 else f"{whole // 60} min {whole % 60} s"
