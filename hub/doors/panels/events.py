"""What a robot says, as lines of a log: /rosout for the panel Log."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from hub.gcm.autopilot import AUTOPILOT_TEXT, AutopilotText
from hub.gcm.control import CONTROL_REFUSAL, CONTROL_STATE, ControlRefusal, ControlState
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics, Severity
from hub.gcm.mapping import POINT_REFUSAL, PointRefusal
from hub.gcm.navigation import NAVIGATION_STATUS, NavigationStatus
from hub.gcm.recording import RECORD_MARK, RecordMark
from hub.gcm.standard import Time
from hub.gcm.supervision import MODULE_REPORTS, ModulePhase, ModuleReports
from hub.ipc.definition import Keep, MessageDefinition
from hub.ros.standard_types import LogEntry, LogSeverity

LOG: Final = MessageDefinition(name="rosout", type=LogEntry, keep=Keep.ALL)
LOG_TOPIC: Final = "/rosout"
_OVER_S = 3.0
"""Time without a report after which a problem is over [s]."""
_LEVELS = {
    Severity.OK: LogSeverity.INFO,
    Severity.WARN: LogSeverity.WARN,
    Severity.ERROR: LogSeverity.ERROR,
    Severity.STALE: LogSeverity.WARN,
}
_TROUBLE = frozenset({ModulePhase.WAITING, ModulePhase.FAILED})

_Line = tuple[LogSeverity, str, str]
"""How bad it is, who says it, and what."""


class EventLog:
    """Says each thing once: when it is new, and when it has changed."""

    def __init__(self) -> None:
        """Begin; the first messages are news."""
        self._said: dict[str, str] = {}
        self._problems: dict[str, tuple[Severity, float]] = {}

    def entries(
        self,
        definition: MessageDefinition[Any],
        value: Any,  # noqa: ANN401 - any message
        stamp: float,
    ) -> Iterator[LogEntry]:
        """The lines about a message of `EVENTS`, measured at `stamp` [s since the epoch]."""
        for level, name, text in _LINES[definition.name](self, value, stamp):
            if text:
                yield LogEntry(stamp=Time.of(stamp), level=level, name=name[:64], msg=text[:1000])

    def changed(self, name: str, text: str) -> bool:
        """Whether this name has another text than before."""
        before, self._said[name] = self._said.get(name), text
        return before != text

    def problems(self, value: Diagnostics, stamp: float) -> Iterator[_Line]:
        """New problems, worse ones, and those that are over."""
        for each in value.status:
            before, _ = self._problems.get(each.name, (None, 0.0))
            self._problems[each.name] = each.level, stamp
            if before is not each.level:
                yield _LEVELS[each.level], each.name, each.message
        for name, (_, seen) in [*self._problems.items()]:
            if stamp - seen > _OVER_S:
                del self._problems[name]
                yield LogSeverity.INFO, name, "over"


def _control(log: EventLog, value: ControlState, _stamp: float) -> Iterator[_Line]:
    if log.changed("control", value.why):
        yield LogSeverity.INFO, "control", value.why


def _modules(log: EventLog, value: ModuleReports, _stamp: float) -> Iterator[_Line]:
    for module in value.modules:
        text = f"{module.phase.name.lower()}{', ' if module.why else ''}{module.why}"
        if log.changed(f"module {module.name}", text):
            level = LogSeverity.WARN if module.phase in _TROUBLE else LogSeverity.INFO
            yield level, module.name, text


def _task(log: EventLog, value: NavigationStatus, _stamp: float) -> Iterator[_Line]:
    text = f"{value.task.name.lower()}{': ' if value.why else ''}{value.why}"
    if log.changed("navigation", f"{value.number} {text}"):
        yield LogSeverity.INFO, "navigation", text


def _autopilot(_log: EventLog, value: AutopilotText, _stamp: float) -> Iterator[_Line]:
    yield _LEVELS[value.level], "autopilot", value.text


def _refused(_log: EventLog, value: ControlRefusal, _stamp: float) -> Iterator[_Line]:
    yield LogSeverity.WARN, "control", f"{value.message} refused: {value.operator} has control"


def _point(_log: EventLog, value: PointRefusal, _stamp: float) -> Iterator[_Line]:
    yield LogSeverity.WARN, "marks", value.text


def _mark(_log: EventLog, value: RecordMark, _stamp: float) -> Iterator[_Line]:
    yield LogSeverity.INFO, "recorder", f"mark {value.number}: {value.text}"


_LINES: Mapping[str, Callable[[EventLog, Any, float], Iterator[_Line]]] = {
    DIAGNOSTICS.name: EventLog.problems,
    CONTROL_STATE.name: _control,
    MODULE_REPORTS.name: _modules,
    NAVIGATION_STATUS.name: _task,
    AUTOPILOT_TEXT.name: _autopilot,
    CONTROL_REFUSAL.name: _refused,
    POINT_REFUSAL.name: _point,
    RECORD_MARK.name: _mark,
}
EVENTS: Final = (
    DIAGNOSTICS,
    CONTROL_STATE,
    MODULE_REPORTS,
    NAVIGATION_STATUS,
    AUTOPILOT_TEXT,
    CONTROL_REFUSAL,
    POINT_REFUSAL,
    RECORD_MARK,
)
"""The messages that say something."""
