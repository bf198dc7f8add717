"""visualizeHeading: a piece of a compass's rim, as a tape that runs below the heading."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.bearing import NORTH_OPTION, Bearing, bearing_words, letters_of
from rune_tui.visualizers.rows import fitting_form

_STEPS_DEG = (5, 15, 45, 90, 180)
_LABEL_COLUMNS = 6
_DEFAULT_SPAN_DEG = 120.0


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
        last = canvas.rows - 1
        if math.isfinite(reading):
            self._show_tape(canvas, reading, theme)
        words = bearing_words(reading)
        row = max(0, last - 2)
        shown = fitting_form(canvas.width, f"[ {words} ]", f"[{words}]", words, words[:4])
        canvas.text((canvas.width - len(shown)) // 2, row, shown, theme.ink)

    def _show_tape(self, canvas: Canvas, bearing: float, theme: Theme) -> None:
        last = canvas.rows - 1
        middle = (canvas.width - 1) // 2
        scale = canvas.width / (self.option or _DEFAULT_SPAN_DEG)
        step = next((s for s in _STEPS_DEG if s * scale >= _LABEL_COLUMNS), _STEPS_DEG[-1])
        for mark in range(0, 360, step):
            ahead = (mark - bearing + 180.0) % 360.0 - 180.0
            column = middle + round(ahead * scale)
            label = letters_of(mark) if mark % 45 == 0 else str(mark)
            canvas.text(column - len(label) // 2, last, label, theme.ink)
            if canvas.rows >= 3:
                canvas.text(column, last - 1, "'", theme.faint)
        if canvas.rows >= 3:
            canvas.text(middle, last - 1, "^", theme.ink)
