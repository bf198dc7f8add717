"""visualizeEnvironment: sound level and carbon dioxide, as bars and in words."""

from __future__ import annotations

import math
from typing import ClassVar, Final

from hub.gcm.environment import ENVIRONMENT, Environment
from hub.values import dataclass
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.gauges.bars import Bar, write_gauge
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.severity import Severity, ink_of

LOUD_DB: Final = 45.0
"""Louder than a quiet room: a victim may call [dB]."""
BREATH_PPM: Final = 600.0
"""More carbon dioxide than in fresh air: a victim may breathe here [ppm]."""
_SOUND: Final = (30.0, 90.0)
_CO2: Final = (400.0, 2000.0)
"""Values at the ends of the bars."""


@dataclass(frozen=True, slots=True)
class _Air:
    """The visible part of the message.

    Attributes:
        sound: Sound level [dB]; None: not measured.
        co2: Carbon dioxide in tens [ppm]; None: not measured.
    """

    sound: int | None
    co2: int | None


class EnvironmentGauge(MessageGauge[Environment, _Air]):
    """A bar for sound and one for carbon dioxide; a colour and a word where a victim may be."""

    rule: ClassVar = VisualizerRule(
        meaning="sound level and carbon dioxide around the robot, as bars and in words",
        message=ENVIRONMENT.name,
        measured=True,
        options={
            "loud_db": NumberOption(
                default=LOUD_DB,
                least=0.0,
                most=200.0,
                unit="dB",
                meaning="sound level from which it is called a sound",
            ),
            "breath_ppm": NumberOption(
                default=BREATH_PPM,
                least=0.0,
                most=1e6,
                unit="ppm",
                meaning="carbon dioxide from which it is called breath",
            ),
        },
    )
    definition = ENVIRONMENT
    subject = "sound or carbon dioxide"

    def reading(self, value: Environment, _robot: RobotState) -> _Air:
        """Whole decibels, and carbon dioxide in tens."""
        return _Air(
            round(value.sound) if math.isfinite(value.sound) else None,
            round(value.co2 / 10.0) * 10 if math.isfinite(value.co2) else None,
        )

    def show(self, canvas: Canvas, reading: _Air, theme: Theme) -> None:
        """A gauge in each row."""
        rows = (
            ("sound", reading.sound, "dB", _SOUND, self.options.number("loud_db"), "SOUND"),
            ("CO2", reading.co2, "ppm", _CO2, self.options.number("breath_ppm"), "BREATH"),
        )
        for row, (name, value, unit, (low, high), limit, word) in enumerate(rows):
            if row >= canvas.rows:
                return
            if value is None:
                write_gauge(canvas, row, name, None, ("not measured", "?"), theme)
                continue
            bar = Bar.filled(min(1.0, max(0.0, (value - low) / (high - low))))
            notable = value >= limit
            ink = ink_of(Severity.WARNING, theme) if notable else None
            text = f"{value} {unit}"
            forms = (f"{word} {text}", f"!{value}") if notable else (text, str(value))
            write_gauge(canvas, row, name, bar, forms, theme, ink=ink)
