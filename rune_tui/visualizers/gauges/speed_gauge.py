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
from rune_tui.visualizers.words.motion_words import along_words, other_speed_words, other_speeds
from rune_tui.visualizers.words.status_words import signed, signed_forms, turn_words

_BAR_COLUMNS = 16
"""Room of a gauge's name and its shortest bar [cells]."""


@dataclass(frozen=True, slots=True)
class _Pair:
    """A measured and a commanded velocity, positive to the right of the gauge's middle."""

    actual: float
    commanded: float


@dataclass(frozen=True, slots=True)
class _Speeds:
    """The visible speeds: ahead, turning, to the left and upward."""

    linear: _Pair
    angular: _Pair
    sway: float
    heave: float


class Speed(MessageGauge[NavigationState, _Speeds]):
    """Two gauges from the middle, ahead to the right and turning to where it turns.

    A sign marks the commanded speed, and the words have both speeds. Motion to the side and up or
    down has rows of words below, or stands in place of the commanded speed where these lack.
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

    def reading(self, value: NavigationState, robot: RobotState) -> _Speeds:
        """Velocities in hundredths of m/s and whole degrees a second."""
        turns = (-math.degrees(value.angular), -math.degrees(value.commanded_angular))
        sway, heave = other_speeds(robot, value)
        return _Speeds(
            _Pair(_rounded(value.linear, 2), _rounded(value.commanded_linear, 2)),
            _Pair(*(_rounded(turn, 0) for turn in turns)),
            _rounded(sway, 2),
            _rounded(heave, 2),
        )

    def show(self, canvas: Canvas, reading: _Speeds, theme: Theme) -> None:
        """Two gauges, or the values in one row."""
        linear, angular = reading.linear, reading.angular
        others = other_speed_words(reading.sway, reading.heave)
        along = along_words(signed(linear.actual, 2), reading.sway, reading.heave)
        if canvas.rows == 1:
            both = f"{along}  {turn_words(angular.actual)}°/s"
            short = f"{signed(linear.actual, 2)} {turn_words(angular.actual)}°"
            forms = (both, along, short) if others else (both, short)
            forms = (*forms, *signed_forms(linear.actual, 2))
            canvas.text(0, 0, fitting_form(canvas.width, *forms), theme.ink)
            return
        speed, turn = _linear_words(linear), _angular_words(angular)
        if canvas.width < len(speed[-1]):
            speed = (fitting_form(canvas.width, *signed_forms(linear.actual, 2)),)
        bar = _bar(linear, self.options.number("linear"))
        if others and canvas.rows < 2 + len(others):
            speed, others = (along, *speed[1:]), ()
            # Words about motion to the side matter more than the bar.
            bar = bar if len(along) <= canvas.width - _BAR_COLUMNS else None
        write_gauge(canvas, 0, "speed", bar, speed, theme)
        end = self.options.number("angular_deg")
        write_gauge(canvas, 1, "turn", _bar(angular, end), turn, theme)
        for row, words in enumerate(others, 2):
            write_gauge(canvas, row, "moves", None, (words,), theme)


def _rounded(value: float, digits: int) -> float:
    """The rounded value; infinite for NaN, which is not equal to itself."""
    return round(value, digits) + 0.0 if math.isfinite(value) else math.inf


def _linear_words(pair: _Pair) -> tuple[str, ...]:
    actual, commanded = signed(pair.actual, 2), signed(pair.commanded, 2)
    return f"{actual} m/s, command {commanded}", f"{actual} m/s", actual


def _angular_words(pair: _Pair) -> tuple[str, ...]:
    actual, commanded = turn_words(pair.actual), turn_words(pair.commanded)
    return f"{actual}°/s, command {commanded}", f"{actual}°/s", actual


def _bar(pair: _Pair, most: float) -> Bar | None:
    if not math.isfinite(pair.actual):
        return None
    return Bar.from_middle(pair.actual / most, pair.commanded / most)
