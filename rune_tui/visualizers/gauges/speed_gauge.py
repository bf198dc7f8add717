"""visualizeSpeed: measured and commanded speed and turn rate."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.navigation import RobotState as NavigationState
from hub.values import dataclass
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.gauges.bars import Bar, write_gauge
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import fitting_form
from rune_tui.visualizers.words.status_words import signed, turn_words


@dataclass(frozen=True, slots=True)
class _Pair:
    """A measured and a commanded velocity, positive to the right of the gauge's middle."""

    actual: float
    commanded: float


class Speed(MessageGauge[NavigationState, tuple[_Pair, _Pair]]):
    """Two gauges from the middle, ahead to the right and turning to where it turns.

    A sign marks the commanded speed, and the words have both speeds.
    """

    rule: ClassVar = VisualizerRule(
        meaning="how fast the robot moves and turns, and its commanded speed",
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

    def reading(self, value: NavigationState, _robot: RobotState) -> tuple[_Pair, _Pair]:
        """Velocities in hundredths of m/s and whole degrees a second."""
        turns = (-math.degrees(value.angular), -math.degrees(value.commanded_angular))
        return (
            _Pair(_rounded(value.linear, 2), _rounded(value.commanded_linear, 2)),
            _Pair(*(_rounded(turn, 0) for turn in turns)),
        )

    def show(self, canvas: Canvas, reading: tuple[_Pair, _Pair], theme: Theme) -> None:
        """Two gauges, or both values in one row."""
        linear, angular = reading
        if canvas.rows == 1:
            both = f"{signed(linear.actual, 2)} m/s  {turn_words(angular.actual)}°/s"
            short = f"{signed(linear.actual, 2)} {turn_words(angular.actual)}°"
            words = fitting_form(canvas.width, both, short, signed(linear.actual, 2))
            canvas.text(0, 0, words, theme.ink)
            return
        speed, turn = _linear_words(linear), _angular_words(angular)
        most = self.options.number("linear"), self.options.number("angular_deg")
        write_gauge(canvas, 0, "speed", _bar(linear, most[0]), speed, theme)
        write_gauge(canvas, 1, "turn", _bar(angular, most[1]), turn, theme)


def _rounded(value: float, digits: int) -> float:
    """The rounded value; infinite for NaN, which is not equal to itself."""
    return round(value, digits) + 0.0 if math.isfinite(value) else math.inf


def _linear_words(pair: _Pair) -> tuple[str, ...]:
    actual, commanded = signed(pair.actual, 2), signed(pair.commanded, 2)
    return f"{actual} of {commanded} m/s", f"{actual} m/s", actual


def _angular_words(pair: _Pair) -> tuple[str, ...]:
    actual, commanded = turn_words(pair.actual), turn_words(pair.commanded)
    both = f"{actual} of {commanded}°/s"
    if pair.actual * pair.commanded > 0.0:
        both = f"{actual} of {abs(pair.commanded):.0f}°/s"
    return both, f"{actual}°/s", actual


def _bar(pair: _Pair, most: float) -> Bar | None:
    if not math.isfinite(pair.actual):
        return None
    return Bar.from_middle(pair.actual / most, pair.commanded / most)
