"""visualizeMarks: the list of victims and landmarks."""

from __future__ import annotations

import math
import time
from collections import Counter
from typing import ClassVar

from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.model.world import metres_text
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import NARROW, TextRow, fitting_form, tabled, write_rows
from rune_tui.visualizers.parts.severity import Severity

_Cells = tuple[str, ...]
_WEIGHTS = (8, 7, 9, 10, 5, 2, 4, 3, 6)
_UNKEPT = "NOT KEPT"


class Marks(MessageGauge[InterestPoints, tuple[str, tuple[_Cells, ...]]]):
    """The number of each kind, then a row for each mark.

    A row has: number, kind, whether the robot's disk lacks it, place, error, distance at which it
    was seen, time, operator, note. The newest is at the top. With little room, a letter stands for
    the kind, and a sign for a mark that is not on the disk.
    """

    rule: ClassVar = VisualizerRule(
        meaning="the victims and landmarks marked so far, as a list",
        message=INTEREST_POINTS.name,
    )
    definition = INTEREST_POINTS
    subject = "list of marks"

    def reading(self, value: InterestPoints, _robot: RobotState) -> tuple[str, tuple[_Cells, ...]]:
        """The head line, and the cells of each mark."""
        newest_first = sorted(value.points, key=lambda point: point.number, reverse=True)
        return _head(value), tuple(map(_cells, newest_first))

    def show(self, canvas: Canvas, reading: tuple[str, tuple[_Cells, ...]], theme: Theme) -> None:
        """The newest marks; the head line above them where at least two marks have room too.

        What is not kept is said in one row less.
        """
        head, marks = reading
        severities = [Severity.WARNING if unkept else Severity.PLAIN for _, _, unkept, *_ in marks]
        if canvas.width < NARROW:
            marks = tuple(
                (f"{number} {kind[0].upper()}{'!' if unkept else ''}", "", "", *rest)
                for number, kind, unkept, *rest in marks
            )
        lines = tabled(marks, _WEIGHTS, canvas.width)
        rows = [TextRow(line, severity) for line, severity in zip(lines, severities, strict=True)]
        unkept = _UNKEPT in head
        if canvas.rows > min(len(rows), 1 if unkept else 2):
            severity = Severity.WARNING if unkept else Severity.FAINT
            rows.insert(0, TextRow(fitting_form(canvas.width, head, _short(head)), severity))
        write_rows(canvas, rows, theme)


def _head(value: InterestPoints) -> str:
    if not value.points:
        return "nothing marked yet"
    counts = Counter(point.kind for point in value.points)
    words = [
        f"{count} {kind.name.lower()}{'s' if count > 1 else ''}"
        for kind, count in sorted(counts.items())
    ]
    unkept = sum(not point.kept for point in value.points)
    # First, because the first words stay when room is short.
    return ", ".join([f"{unkept} {_UNKEPT}", *words] if unkept else words)


def _short(head: str) -> str:
    """A short form such as "1 NOT KEPT, 2 v, 1 l"."""
    parts = head.split(", ")
    return ", ".join(
        part if part.endswith(_UNKEPT) else part[: part.find(" ") + 2] for part in parts
    )


def _cells(point: InterestPoint) -> _Cells:
    off, away = metres_text(point.uncertainty, 2), metres_text(point.distance, 1)
    return (
        f"{point.number:>2}",
        point.kind.name.lower(),
        "" if point.kept else _UNKEPT,
        f"{point.x:.2f}, {point.y:.2f}",
        f"±{off} m" if off else "",
        f"from {away} m" if away else "",
        _clock(point.stamp),
        point.by,
        point.note,
    )


def _clock(stamp: float) -> str:
    """A time [s since the epoch] as the local time of day; empty: none."""
    if not (math.isfinite(stamp) and stamp > 0.0):
        return ""
    return time.strftime("%H:%M:%S", time.localtime(stamp))
