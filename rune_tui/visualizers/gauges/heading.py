"""visualizeHeading: a piece of a compass's rim, as a tape that runs below the heading."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.bearing import NORTH_OPTION, Bearing, bearing_words, letters_of
from rune_tui.visualizers.parts.rows import fitting_form

_STEPS_DEG = (5, 15, 45, 90, 180)
_LABEL_COLUMNS = 6
_DEFAULT_SPAN_DEG = 120.0
_ROWS = 3
"""Of the whole tape: the heading, signs, labels."""


class Heading(Bearing):
    """Degrees and letters left and right of the heading, and the heading itself in the middle."""

    rule: ClassVar = VisualizerRule(
        meaning="where the robot heads, on a compass tape",
        message=ROBOT_STATE.name,
        option=NumberOption(
            default=0.0, least=0.0, most=360.0, unit="deg", meaning="length; 0 means 120 deg"
        ),
        options={"north_deg": NORTH_OPTION},
    )

    def show(self, canvas: Canvas, reading: float, theme: Theme) -> None:
        """The heading over the tape; in one row, amid it."""
        if math.isfinite(reading):
            self._show_tape(canvas, reading, theme)
        words = bearing_words(reading)
        shown = fitting_form(canvas.width, f" {words} ", words, words[:4])
        canvas.text((canvas.width - len(shown)) // 2, 0, shown, theme.ink)

    def _show_tape(self, canvas: Canvas, bearing: float, theme: Theme) -> None:
        """Labels in the last of at most three rows, and signs above them."""
        last = min(canvas.rows, _ROWS) - 1
        middle = (canvas.width - 1) // 2
        scale = canvas.width / (self.option or _DEFAULT_SPAN_DEG)
        step = next((s for s in _STEPS_DEG if s * scale >= _LABEL_COLUMNS), _STEPS_DEG[-1])
        for mark in range(0, 360, step):
            ahead = (mark - bearing + 180.0) % 360.0 - 180.0
            column = middle + round(ahead * scale)
            label = letters_of(mark) if mark % 45 == 0 else str(mark)
            first = column - len(label) // 2
            if first < 0 or first + len(label) > canvas.width:
                continue  # no half of a label
            canvas.text(first, last, label, theme.soft)
            if last == _ROWS - 1:
                canvas.text(column, 1, "╷", theme.faint)
        if last == _ROWS - 1:
            canvas.text(middle, 1, "▼", theme.ink)
