"""visualizeModules: the robot's modules and their states."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.supervision import MODULE_REPORTS, ModulePhase, ModuleReport, ModuleReports, is_console
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import Entry, entry_rows, write_rows
from rune_tui.visualizers.parts.severity import Severity

_HEAD = Entry(("module", "phase", "starts", "cpu", "memory"), "why", Severity.FAINT)
_WEIGHTS = (9, 8, 3, 4, 2, 6)
_SEVERITIES = {
    ModulePhase.WAITING: Severity.WARNING,
    ModulePhase.FAILED: Severity.ALARM,
    ModulePhase.STOPPED: Severity.FAINT,
}


class Modules(MessageGauge[ModuleReports, tuple[Entry, ...]]):
    """A row a module; on a narrow canvas, the reason for its phase is below it."""

    rule: ClassVar = VisualizerRule(
        meaning="the robot's modules: phase, why, starts, processor and memory",
        message=MODULE_REPORTS.name,
    )
    definition = MODULE_REPORTS
    subject = "module list"

    def reading(self, value: ModuleReports, _robot: RobotState) -> tuple[Entry, ...]:
        """The modules, with whole percents and megabytes; no consoles."""
        own = [each for each in value.modules if not is_console(each.capabilities.split())]
        return tuple(map(_line, own))

    def show(self, canvas: Canvas, reading: tuple[Entry, ...], theme: Theme) -> None:
        """A head line, if there are two rows, and the modules."""
        head = [_HEAD] if canvas.rows > 1 else []
        write_rows(canvas, [*entry_rows([*head, *reading], _WEIGHTS, canvas.width)], theme)


def _line(report: ModuleReport) -> Entry:
    severity = _SEVERITIES.get(report.phase, Severity.PLAIN)
    word = report.phase.name
    cells = (
        report.name,
        word if severity in {Severity.WARNING, Severity.ALARM} else word.lower(),
        str(report.starts),
        f"{100 * report.processor:.0f}%" if math.isfinite(report.processor) else "",
        f"{report.memory_mb:.0f} MB" if math.isfinite(report.memory_mb) else "",
    )
    return Entry(cells, report.why, severity)
