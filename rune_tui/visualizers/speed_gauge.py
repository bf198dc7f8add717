"""visualizeSpeed: how fast the robot moves and turns, and how fast it is told to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.navigation import RobotState as NavigationState
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.reading import Reading
from rune_tui.visualizers.rows import fitting_form
from rune_tui.visualizers.status_words import signed

_COMMANDED = "|"
_BEYOND = ("<", ">")


@dataclass(frozen=True, slots=True)
class _Pair:
    """A velocity as measured and as commanded, positive to the right of the gauge's middle."""

    actual: float
    commanded: float


class Speed(Reading[NavigationState, tuple[_Pair, _Pair]]):
    """Two bars from the middle, ahead to the right and turning to where it turns.

    A mark stands at what is commanded, and a row of words above each bar says both.
    """

    rule: ClassVar = VisualizerRule(
        meaning="how fast the robot moves and turns, and how fast it is told to",
        message=ROBOT_STATE.name,
        options={
            "linear": NumberOption(
                default=1.0, least=0.01, most=100.0, unit="m/s", meaning="where the bar ends"
            ),
            "angular_deg": NumberOption(
                default=90.0, least=1.0, most=3600.0, unit="deg/s", meaning="where the bar ends"
            ),
        },
    )
    urgency: ClassVar[Urgency] = Urgency.DRIVE
    definition = ROBOT_STATE
    subject = "speed"

    def reading(self, value: NavigationState, robot: RobotState) -> tuple[_Pair, _Pair]:  # noqa: ARG002
        """Velocities in hundredths of m/s and whole degrees a second."""
        turns = (-math.degrees(value.angular), -math.degrees(value.commanded_angular))
        return (
            _Pair(_rounded(value.linear, 2), _rounded(value.commanded_linear, 2)),
            _Pair(*(_rounded(turn, 0) for turn in turns)),
        )

    def show(self, canvas: Canvas, reading: tuple[_Pair, _Pair], theme: Theme) -> None:
        """Words, and bars below them where there are four rows."""
        linear, angular = reading
        if canvas.rows == 1:
            both = f"{signed(linear.actual, 2)} m/s  {_turn(angular.actual)}°/s"
            short = f"{signed(linear.actual, 2)} {_turn(angular.actual)}°"
            canvas.text(0, 0, fitting_form(canvas.width, both, short), theme.ink)
            return
        half = canvas.rows // 2
        canvas.text(0, 0, _linear_words(linear, canvas.width), theme.ink)
        canvas.text(0, half, _angular_words(angular, canvas.width), theme.ink)
        if half >= 2:
            _draw_bar(canvas, range(1, half), linear, self.options.number("linear"), theme)
            rows = range(half + 1, 2 * half)
            _draw_bar(canvas, rows, angular, self.options.number("angular_deg"), theme)


def _rounded(value: float, digits: int) -> float:
    """Nothing that is not a number, as that equals nothing, itself included."""
    return round(value, digits) + 0.0 if math.isfinite(value) else math.inf


def _linear_words(pair: _Pair, columns: int) -> str:
    actual, commanded = signed(pair.actual, 2), signed(pair.commanded, 2)
    return fitting_form(
        columns,
        f"speed {actual} m/s, commanded {commanded} m/s",
        f"{actual} m/s of {commanded}",
        f"{actual} of {commanded}",
        actual,
    )


def _angular_words(pair: _Pair, columns: int) -> str:
    actual, commanded = _turn(pair.actual), _turn(pair.commanded)
    return fitting_form(
        columns,
        f"turning {actual}°/s, commanded {commanded}°/s",
        f"{actual}°/s of {commanded}",
        f"{actual}° of {commanded}",
        actual,
    )


def _turn(value: float) -> str:
    if not math.isfinite(value):
        return "?"
    side = "right " if value > 0.0 else "left " if value < 0.0 else ""
    return f"{side}{abs(value):.0f}"


def _draw_bar(canvas: Canvas, rows: range, pair: _Pair, most: float, theme: Theme) -> None:
    top, bottom = 2 * rows.start, 2 * rows.stop
    middle = canvas.width / 2.0

    def column(value: float) -> float:
        return middle + max(-1.0, min(1.0, value / most)) * middle

    with drawing(canvas) as pen:
        if math.isfinite(pair.actual):
            low, high = sorted((middle, column(pair.actual)))
            pen.rectangle(round(low), top, round(high), bottom, theme.accent)
        zero = canvas.width // 2
        pen.rectangle(zero, top, zero + 1, bottom, theme.faint)
    if math.isfinite(pair.commanded):
        at = min(canvas.width - 1, int(column(pair.commanded)))
        for row in rows:
            canvas.text(at, row, _COMMANDED, theme.ink)
    if math.isfinite(pair.actual) and abs(pair.actual) > most:
        right = pair.actual > 0.0
        canvas.text(canvas.width - 1 if right else 0, rows.start, _BEYOND[right], theme.warning)
