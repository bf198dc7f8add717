"""How often a link can be asked for large data without a queue building up in it; pure.

The robot and the link count as a single server: an answer takes the bare round trip, waits for
the one before it, and keeps the server busy for its own time, the service. With intervals of at
least the service, requests never wait, and no answer grows old on its way.
"""

from __future__ import annotations

import math

LEAST_S = 1.0 / 30.0
"""Shortest time between two requests [s]: the console draws no more often."""
MAX_OPEN = 12
"""Enough for 15 pictures a second over a round trip of 0.7 s."""
TIMEOUT_S, LONGEST_TIMEOUT_S = 1.0, 8.0
"""Longest wait for an answer [s]; after a missing one, the wait grows."""
_LONG_ROUND_TRIP_S = 0.01
_SHOWN_WITHIN_S = 0.05
"""An answer is on the screen within this time [s]."""
_MARGIN = 1.1
"""Factor of intervals on the service, so that queues drain."""
_USUAL_PARTS = 4.0
_RISING, _FALLING = 0.5, 0.2
"""Weights of a new measurement: a longer one counts more."""


class Pace:
    """Learns from the times of answers.

    Attributes:
        interval: Shortest time between two requests [s].
        service: How long robot and link are busy with one answer [s]; NaN before the first.
    """

    def __init__(self) -> None:
        self.interval = 0.0
        self.service = math.nan
        self._bare = 0.0
        self._arrived = -math.inf
        self._timeout = TIMEOUT_S

    @property
    def spacing(self) -> float:
        """Time from one request to the next [s]."""
        return max(self.interval, LEAST_S, _MARGIN * self._busy)

    @property
    def window(self) -> int:
        """Most open requests: under way, or with an answer that is not shown yet.

        One, unless the round trip alone is too long for the wanted rate.
        """
        whole = self._bare + self._busy + _SHOWN_WITHIN_S
        if self._bare < _LONG_ROUND_TRIP_S or whole <= self.spacing:
            return 1
        return min(MAX_OPEN, 1 + math.ceil(whole / self.spacing))

    @property
    def timeout(self) -> float:
        """How long to wait for an answer [s]."""
        usual = _USUAL_PARTS * (self._bare + self._busy)
        return min(LONGEST_TIMEOUT_S, max(self._timeout, usual))

    def answered(self, asked: float, arrived: float, round_trip: float) -> tuple[float, float]:
        """Note an answer.

        Args:
            asked: When it was asked for [s].
            arrived: Its arrival [s].
            round_trip: How long an empty message takes there and back [s]; NaN: not known.

        Returns:
            How long robot and link were busy with it, and how long it waited before that [s].
        """
        self._bare = min(arrived - asked, 0.0 if math.isnan(round_trip) else round_trip)
        began = asked + self._bare
        waited = max(0.0, min(arrived, self._arrived) - began)
        service = arrived - began - waited
        if math.isnan(self.service):
            self.service = service
        part = _RISING if service > self.service else _FALLING
        self.service += part * (service - self.service)
        self._arrived = arrived
        self._timeout = TIMEOUT_S
        return service, waited

    def timed_out(self) -> None:
        """Note a missing answer."""
        self._timeout = min(LONGEST_TIMEOUT_S, 2.0 * self._timeout)

    def forget(self) -> None:
        """Forget the service: later requests have another size."""
        self.service = math.nan

    @property
    def _busy(self) -> float:
        return 0.0 if math.isnan(self.service) else self.service
