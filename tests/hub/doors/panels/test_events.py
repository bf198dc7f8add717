"""The log of a robot: each thing is said once."""

from __future__ import annotations

from hub.doors.panels.events import EventLog
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics, DiagnosticStatus, Severity
from hub.ros.standard_types import LogSeverity

LEAK = DiagnosticStatus(level=Severity.WARN, name="leak", message="water in the hull")


def lines(log: EventLog, value: object, stamp: float) -> list[tuple[LogSeverity, str, str]]:
    definition = DIAGNOSTICS if isinstance(value, Diagnostics) else CONTROL_STATE
    return [(each.level, each.name, each.msg) for each in log.entries(definition, value, stamp)]


def test_a_problem_is_said_when_it_is_new_worse_and_over() -> None:
    log, worse = EventLog(), DiagnosticStatus(level=Severity.ERROR, name="leak", message="sinks")
    said = [
        lines(log, Diagnostics(status=status), stamp)
        for stamp, status in ((1.0, (LEAK,)), (2.0, (LEAK,)), (3.0, (worse,)), (4.0, ()), (7.0, ()))
    ]
    assert said == [
        [(LogSeverity.WARN, "leak", "water in the hull")],
        [],
        [(LogSeverity.ERROR, "leak", "sinks")],
        [],  # another publisher may have sent this one
        [(LogSeverity.INFO, "leak", "over")],
    ]


def test_control_is_said_when_it_changes() -> None:
    log, taken = EventLog(), ControlState(why="alice took control")
    assert lines(log, taken, 1.0) == [(LogSeverity.INFO, "control", "alice took control")]
    assert lines(log, taken, 2.0) == []
