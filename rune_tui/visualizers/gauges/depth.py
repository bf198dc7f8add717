"""visualizeDepth: depth or height of the robot, on an upright tape and in words."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.flight import ALTITUDE, Altitude
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, NumberOption, VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import fitting_form

_DEFAULT_SPAN_M = 10.0
_LABEL_ROWS = 2
_NAMES = ("depth", "above ground", "height")
_SIZES = (1.0, 2.0, 5.0)


@dataclass(frozen=True, slots=True)
class _Level:
    """Depth or height.

    Attributes:
        name: One of `_NAMES`.
        value: In tenths of a metre [m]; infinite if not measured.
        climb: In tenths of a metre a second [m/s], positive up; infinite if not measured.
    """

    name: str
    value: float
    climb: float


class Depth(MessageGauge[Altitude, _Level]):
    """Metres on the left side, the robot's value in the middle, and its climb."""

    rule: ClassVar = VisualizerRule(
        meaning="depth or height, on an upright tape and in words",
        message=ALTITUDE.name,
        measured=True,
        names=True,
        option=NumberOption(
            default=0.0,
            least=0.0,
            most=10_000.0,
            unit="m",
            meaning="from the lower edge to the upper; 0 means 10 m",
        ),
        options={
            "shows": ChoiceOption(
                default="what is known",
                choices=("what is known", *_NAMES),
                meaning="which of them; what is known is the first that is measured",
            )
        },
    )
    urgency: ClassVar[Urgency] = Urgency.DRIVE
    definition = ALTITUDE
    subject = "depth or height"

    def reading(self, value: Altitude, _robot: RobotState) -> _Level:
        """The level that the layout selects."""
        levels = dict(zip(_NAMES, (value.depth, value.above_ground, value.height), strict=True))
        wanted = self.options.word("shows")
        known = [name for name, level in levels.items() if math.isfinite(level)]
        name = wanted if wanted in levels else (known or _NAMES)[0]
        return _Level(name, _tenths(levels[name]), _tenths(value.climb))

    def shown_word(self, robot: RobotState) -> str:
        """Depth or height, as the robot measures it."""
        known = robot.newest(ALTITUDE)
        name = self.reading(known.value, robot).name if known is not None else "height"
        return name if name in {"depth", "height"} else "height"

    def show(self, canvas: Canvas, reading: _Level, theme: Theme) -> None:
        """The tape with the value in its middle; words at the bottom."""
        last = canvas.rows - 1
        if last >= 2 and math.isfinite(reading.value):
            self._show_tape(canvas, reading, theme)
        words = _words(reading, canvas.width)
        canvas.text((canvas.width - len(words)) // 2, last, words, theme.ink)

    def _show_tape(self, canvas: Canvas, level: _Level, theme: Theme) -> None:
        rows = canvas.rows - 1
        middle = (rows - 1) // 2
        metres = (self.option or _DEFAULT_SPAN_M) / rows
        step = _step(_LABEL_ROWS * metres)
        downward = 1.0 if level.name == "depth" else -1.0
        first = math.ceil((level.value - rows * metres) / step)
        last = math.floor((level.value + rows * metres) / step)
        for number in range(first, last + 1):
            row = middle + round(downward * (number * step - level.value) / metres)
            if 0 <= row < rows and row != middle and (number >= 0 or downward < 0.0):
                canvas.text(0, row, f"{number * step:>6g} ┤", theme.soft)
        canvas.text(0, middle, fitting_form(canvas.width, f"{level.value:>6.1f} ◀"), theme.ink)


def _step(least: float) -> float:
    """The smallest of 1, 2, 5, 10, 20, ... that is not below this."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(
        (size * power for size in _SIZES if size * power >= least * (1 - 1e-9)), 10.0 * power
    )


def _tenths(value: float) -> float:
    return round(value, 1) + 0.0 if math.isfinite(value) else math.inf


def _words(level: _Level, columns: int) -> str:
    if not math.isfinite(level.value):
        return fitting_form(columns, f"{level.name} not measured", f"{level.name} ?", "?")
    short = f"{level.value:.1f} m"
    named = f"{level.name} {short}"
    if not math.isfinite(level.climb):
        return fitting_form(columns, named, short)
    verb = "rising" if level.climb > 0.0 else "sinking" if level.climb < 0.0 else "steady"
    rate = f" {abs(level.climb):.1f} m/s" if level.climb else ""
    return fitting_form(columns, f"{named}, {verb}{rate}", f"{short} {verb}", named, short)
