"""visualizeCapabilities: the robot's capabilities, the missing ones, and the reasons."""

from __future__ import annotations

from typing import ClassVar

from hub.gcm.capability import Capability
from hub.gcm.supervision import (
    CAPABILITY_REPORTS,
    CapabilityPhase,
    CapabilityReport,
    CapabilityReports,
)
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.body import can_have
from rune_tui.model.robot_state import Lack, LackKind, RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import Entry, TextRow, entry_rows, write_rows
from rune_tui.visualizers.parts.severity import Severity

_ORDER = (
    CapabilityPhase.UNAVAILABLE,
    CapabilityPhase.AVAILABLE,
    CapabilityPhase.STARTING,
    CapabilityPhase.RUNNING,
)
_WEIGHTS = (9, 8, 4, 5)
_BODILESS = "this body has no parts for it"
_PHASES = {
    CapabilityPhase.AVAILABLE: "idle",
    CapabilityPhase.STARTING: "starting",
    CapabilityPhase.RUNNING: "runs",
    CapabilityPhase.UNAVAILABLE: "MISSING",
}


class Capabilities(MessageGauge[CapabilityReports, tuple[Entry, ...]]):
    """A row a capability: first the wanted ones, of these first the missing ones.

    Wanted capabilities that no module has are among them, though the robot does not list them;
    capabilities of consoles are not. What the body has no parts for comes last, and is no alarm.
    """

    rule: ClassVar = VisualizerRule(
        meaning="what the robot can do now, what is missing and why; wanted ones first",
        message=CAPABILITY_REPORTS.name,
    )
    definition = CAPABILITY_REPORTS
    subject = "capability list"

    def reading(self, value: CapabilityReports, robot: RobotState) -> tuple[Entry, ...]:
        """The robot's list, and the layout's wants that are missing in it."""
        listed = [each for each in value.capabilities if each.name != Capability.CON_REAL]
        bodiless = [each for each in listed if _is_bodiless(each, robot)]
        reports = [each for each in listed if each not in bodiless]
        known = {report.name for report in listed}
        unknown = [
            _lacking(name, lack)
            for name, lack in sorted(robot.link.lacking.items())
            if name not in known
        ]
        return (
            *unknown,
            *map(_entry, sorted(reports, key=_order)),
            *(Entry((each.name, "none", ""), _BODILESS, Severity.FAINT) for each in bodiless),
        )

    def show(self, canvas: Canvas, reading: tuple[Entry, ...], theme: Theme) -> None:
        """The list."""
        rows = [*entry_rows(reading, _WEIGHTS, canvas.width)]
        write_rows(canvas, rows or [TextRow("the robot can do nothing")], theme)


def _is_bodiless(report: CapabilityReport, robot: RobotState) -> bool:
    """Whether the robot's body has no parts for a capability."""
    return not report.modules and robot.body is not None and not can_have(robot.body, report.name)


def _lacking(name: str, lack: Lack) -> Entry:
    absent = lack.kind is LackKind.ABSENT
    phase = "none" if absent else _PHASES[CapabilityPhase.UNAVAILABLE]
    return Entry(
        (name, phase, "for this console"), lack.why, Severity.FAINT if absent else Severity.ALARM
    )


def _order(report: CapabilityReport) -> tuple[bool, int, str]:
    return not report.wanted_by, _ORDER.index(report.phase), report.name


def _entry(report: CapabilityReport) -> Entry:
    wanted, runs = bool(report.wanted_by), report.phase is CapabilityPhase.RUNNING
    missing = report.phase is CapabilityPhase.UNAVAILABLE
    why = report.module
    if missing:
        why = f"cannot start {report.modules}" if report.modules else "no module has it"
    severity = Severity.PLAIN if wanted or runs else Severity.FAINT
    if missing:
        severity = Severity.ALARM if wanted else Severity.WARNING
    elif wanted and not runs:
        severity = Severity.WARNING
    by = f"for {report.wanted_by}" if wanted else ""
    return Entry((report.name, _PHASES[report.phase], by), why, severity)
