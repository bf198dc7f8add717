"""When a vehicle that began to drive without a place gets its better driving mode; pure.

| state | event | action |
| --- | --- | --- |
| the operator named its mode | any | none |
| it knows its place now | no velocity is asked for, for 1 s | ask for the best driving mode |
| it knows its place now | velocities are asked for | say what it waits for |
| the better mode was asked for | it stays in the other one | none, until its place comes again |
"""

from __future__ import annotations

import math
from typing import Final

from hub.robots.mavlink.profiles.profile import VehicleProfile

_RESTS_S: Final = 1.0


class BetterMode:
    """The better driving mode of one vehicle.

    Attributes:
        waits: Whether the vehicle knows its place, and drives in a mode for those that do not.
    """

    def __init__(self) -> None:
        self.waits = False
        self._tried = False
        self._moved = -math.inf

    def due(
        self, profile: VehicleProfile, mode: int, now: float, *, place: bool, rests: bool
    ) -> bool:
        """Whether to ask for it now; the order to drive is valid, and names no mode.

        Args:
            profile: The vehicle's kind.
            mode: Its mode.
            now: Monotonic time [s].
            place: Whether it knows its place.
            rests: Whether no velocity is asked for.
        """
        self._tried = self._tried and place
        self.waits = place and mode in profile.drives and mode != profile.drives[0]
        if not rests:
            self._moved = now
        if not self.waits or self._tried or now - self._moved < _RESTS_S:
            return False
        self._tried = True
        return True
