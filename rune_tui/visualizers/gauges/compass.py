"""visualizeCompass: where the robot heads, on a round compass."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from rune_tui.layout.rules import ChoiceOption, VisualizerRule
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing, toward
from rune_tui.visualizers.parts.bearing import LETTERS, NORTH_OPTION, Bearing, bearing_words
from rune_tui.visualizers.parts.rows import fitting_form

_SMOOTHING = 3
_LEAST_RADIUS = 4.0


class Compass(Bearing):
    """A rose with its letters, an arrow where the robot heads, and the heading in words below."""

    rule: ClassVar = VisualizerRule(
        meaning="where the robot heads, on a round compass",
        message=ROBOT_STATE.name,
        options={
            "north_deg": NORTH_OPTION,
            "up": ChoiceOption(
                default="north", choices=("north", "robot"), meaning="what is at the top"
            ),
        },
    )

    def show(self, canvas: Canvas, reading: float, theme: Theme) -> None:
        """The rose, where there is room, above the words."""
        height = canvas.height - 2
        radius = min(canvas.width, height) / 2.0 - 0.5
        if radius >= _LEAST_RADIUS and math.isfinite(reading):
            self._show_rose(canvas, (canvas.width / 2.0, height / 2.0), radius, reading, theme)
        words = bearing_words(reading)
        shown = fitting_form(canvas.width, f"heading {words}", words, words[:4])
        canvas.text((canvas.width - len(shown)) // 2, canvas.rows - 1, shown, theme.ink)

    def _show_rose(
        self,
        canvas: Canvas,
        centre: tuple[float, float],
        radius: float,
        bearing: float,
        theme: Theme,
    ) -> None:
        robot_up = self.options.word("up") == "robot"
        # Directions are counter-clockwise from up, bearings clockwise from north.
        north = math.radians(bearing) if robot_up else 0.0
        ahead = 0.0 if robot_up else -math.radians(bearing)
        with drawing(canvas, smoothing=_SMOOTHING) as pen:
            pen.circle(centre, radius, rim=theme.faint)
            tip = toward(centre, radius * 0.7, ahead)
            wings = (toward(centre, radius * 0.5, ahead + turn) for turn in (2.6, -2.6))
            left, right = wings
            pen.polygon([tip, left, centre, right], theme.accent)
        for index, letter in enumerate(LETTERS):
            if len(letter) == 1:
                x, y = toward(centre, radius - 0.5, north - index * math.pi / 4.0)
                column = min(canvas.width - 1, int(x))
                canvas.text(column, min(canvas.rows - 1, int(y) // 2), letter, theme.ink)
