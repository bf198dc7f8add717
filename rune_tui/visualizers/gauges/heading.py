"""visualizeHeading and visualizeCompass: the heading, on a tape and on a round compass.

A bearing is in degrees clockwise from north.
"""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.navigation import RobotState as NavigationState
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing, toward
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import fitting_form

LETTERS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")

NORTH_OPTION = NumberOption(
    default=90.0,
    least=-360.0,
    most=360.0,
    unit="deg",
    meaning="where north is, counter-clockwise from the map's x axis",
)

_STEPS_DEG = (5, 15, 45, 90, 180)
_LABEL_COLUMNS = 6
_DEFAULT_SPAN_DEG = 120.0
_ROWS = 3
"""Rows of the whole tape: heading, signs, labels."""
_SMOOTHING = 3
_LEAST_RADIUS = 4.0


class Bearing(MessageGauge[NavigationState, float]):
    """Base of visualizers of the heading; infinite: unknown."""

    urgency: ClassVar[Urgency] = Urgency.DRIVE
    definition = ROBOT_STATE
    subject: ClassVar[str] = "heading"

    def reading(self, value: NavigationState, _robot: RobotState) -> float:
        """The bearing in whole degrees [deg], 0 to 359."""
        if not math.isfinite(value.theta):
            return math.inf
        return round(self.options.number("north_deg") - math.degrees(value.theta)) % 360.0


class Heading(Bearing):
    """A tape of degrees and letters, with the heading in the middle."""

    rule: ClassVar = VisualizerRule(
        meaning="where the robot heads, on a compass tape",
        message=ROBOT_STATE.name,
        option=NumberOption(
            default=0.0, least=0.0, most=360.0, unit="deg", meaning="length; 0 means 120 deg"
        ),
        options={"north_deg": NORTH_OPTION},
    )

    def show(self, canvas: Canvas, reading: float, theme: Theme) -> None:
        """The heading over the tape; in one row, in its middle."""
        if math.isfinite(reading):
            self._show_tape(canvas, reading, theme)
        words = bearing_words(reading)
        shown = fitting_form(canvas.width, f" {words} ", words, words[:4])
        canvas.text((canvas.width - len(shown)) // 2, 0, shown, theme.ink)

    def _show_tape(self, canvas: Canvas, bearing: float, theme: Theme) -> None:
        """Labels in the last of three rows, and signs above them."""
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


class Compass(Bearing):
    """A rose with letters, an arrow along the heading, and the heading in words below."""

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
        """The words, and the rose above them if there is room."""
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
        # A direction is counter-clockwise from up, a bearing clockwise from north.
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


def letters_of(bearing: float) -> str:
    """The nearest of eight compass points."""
    return LETTERS[round(bearing / 45.0) % len(LETTERS)]


def bearing_words(bearing: float) -> str:
    """A bearing in words, such as "007° N"."""
    return f"{bearing:03.0f}° {letters_of(bearing)}" if math.isfinite(bearing) else "not known"
