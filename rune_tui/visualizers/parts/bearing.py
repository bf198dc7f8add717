"""The robot's heading as a compass bearing: degrees clockwise from north, and letters."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.navigation import RobotState as NavigationState
from rune_tui.layout.rules import NumberOption
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.message_gauge import MessageGauge

LETTERS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")

NORTH_OPTION = NumberOption(
    default=90.0,
    least=-360.0,
    most=360.0,
    unit="deg",
    meaning="where north is, counter-clockwise from the map's x axis",
)


class Bearing(MessageGauge[NavigationState, float]):
    """Base of visualizers of the heading; infinite: not known."""

    urgency: ClassVar[Urgency] = Urgency.DRIVE
    definition = ROBOT_STATE
    subject: ClassVar[str] = "heading"

    def reading(self, value: NavigationState, _robot: RobotState) -> float:
        """The bearing in whole degrees [deg], 0 to 359."""
        if not math.isfinite(value.theta):
            return math.inf
        return round(self.options.number("north_deg") - math.degrees(value.theta)) % 360.0


def letters_of(bearing: float) -> str:
    """The nearest of eight winds."""
    return LETTERS[round(bearing / 45.0) % len(LETTERS)]


def bearing_words(bearing: float) -> str:
    """Such as "007° N"."""
    return f"{bearing:03.0f}° {letters_of(bearing)}" if math.isfinite(bearing) else "not known"
