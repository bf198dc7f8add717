"""visualizeBattery: the charge, as a bar and in words."""

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
from rune_tui.visualizers.gauges.bars import Bar, write_gauge
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.severity import Severity, ink_of
from rune_tui.visualizers.words.status_words import CRITICAL_BATTERY, LOW_BATTERY


@dataclass(frozen=True, slots=True)
class _Charge:
    """The state of the battery.

    Attributes:
        percent: Charge, 0 to 100; None if unknown.
        volts: Voltage in words; empty if not measured.
        severity: Severity of the charge.
    """

    percent: int | None
    volts: str
    severity: Severity


class Battery(MessageGauge[NavigationState, _Charge]):
    """A bar of the charge, and words, also for low and critical."""

    rule: ClassVar = VisualizerRule(
        meaning="the battery's charge, as a bar and in words",
        message=ROBOT_STATE.name,
        options={
            "low_percent": NumberOption(
                default=100 * LOW_BATTERY,
                least=0.0,
                most=100.0,
                unit="%",
                meaning="charge below which it is called low",
            ),
            "critical_percent": NumberOption(
                default=100 * CRITICAL_BATTERY,
                least=0.0,
                most=100.0,
                unit="%",
                meaning="charge below which it is called critical",
            ),
        },
    )
    definition = ROBOT_STATE
    subject = "battery"

    def reading(self, value: NavigationState, _robot: RobotState) -> _Charge:
        """The charge in whole percents and the voltage in tenths of a volt."""
        volts = f"{value.battery_voltage:.1f} V" if math.isfinite(value.battery_voltage) else ""
        if not math.isfinite(value.battery_fraction):
            return _Charge(None, volts, Severity.PLAIN)
        percent = 100.0 * value.battery_fraction
        critical = percent < self.options.number("critical_percent")
        low = percent < self.options.number("low_percent")
        severity = Severity.ALARM if critical else Severity.WARNING if low else Severity.PLAIN
        return _Charge(round(min(100.0, max(0.0, percent))), volts, severity)

    def show(self, canvas: Canvas, reading: _Charge, theme: Theme) -> None:
        """A gauge in the first row."""
        ink = None if reading.severity is Severity.PLAIN else ink_of(reading.severity, theme)
        bar = None if reading.percent is None else Bar.filled(reading.percent / 100.0)
        write_gauge(canvas, 0, "battery", bar, _values(reading), theme, ink=ink)


def _values(charge: _Charge) -> tuple[str, ...]:
    if charge.percent is None:
        volts = charge.volts or "nothing measured"
        return f"{volts}, charge not known", volts, "?"
    percent = f"{charge.percent}%"
    both = f"{percent} {charge.volts}".rstrip()
    if charge.severity is Severity.PLAIN:
        return both, percent
    word = "CRITICAL" if charge.severity is Severity.ALARM else "LOW"
    return f"{word} {both}", f"{word} {percent}", f"!{percent}"
