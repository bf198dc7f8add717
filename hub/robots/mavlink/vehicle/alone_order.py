"""The action of a vehicle that lost its operator, until its mode is asked for; pure.

| event | the mode of the action |
| --- | --- |
| it is driven and moves | waits: the driving mode brakes, and others may coast |
| it stands, or its speed is not known, or 4 s passed | is asked for |
| an operator is there again | is not asked for any more |
"""

from __future__ import annotations

import math
from typing import Final

from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.vehicle.telemetry import Telemetry

_BRAKES_S: Final = 4.0
"""Longest time in which it brakes before its mode changes [s]."""


class AloneOrder:
    """The order for one vehicle; times are monotonic [s].

    Attributes:
        action: What it is asked to do; None: nothing, or it was done.
    """

    def __init__(self) -> None:
        self.action: LeftAlone | None = None
        self._until = -math.inf

    def begin(self, action: LeftAlone | None, now: float) -> None:
        """Take an action; None: an operator is there again."""
        self.action, self._until = action, now + _BRAKES_S

    def mode(
        self, profile: VehicleProfile | None, read: Telemetry, now: float, *, driven: bool
    ) -> int | None:
        """The mode to ask for now; None: none, or not yet.

        Args:
            profile: The vehicle's kind; None: it is not known.
            read: What it measures.
            now: The time.
            driven: Whether it follows velocities.
        """
        if self.action is None or profile is None:
            return None
        if driven and read.moves(now) and now < self._until:
            return None
        number, self.action = profile.alone.get(self.action), None
        return number
