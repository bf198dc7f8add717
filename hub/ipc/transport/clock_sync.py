"""The hub's clock at a client: central's monotonic clock, between two bounds.

All stamps on the bus are on this clock, so an age is a difference of two stamps on any machine.
Processes on central's machine share its clock. Another machine bounds the offset by round trips:
central read its clock after the request was sent and before the answer came. So the offset is

| bound | the answer took | used for |
| --- | --- | --- |
| `least` | no time: all of the round trip was on the way up | stamps of what this client sends |
| `most` | all of the round trip: none was on the way up | ages of what this client receives |

So no age is too small, here or at a receiver. Both hold on any line, however its two ways differ.
The tightest bounds count, and loosen with time, because clocks drift. A stamp is too old by the
shortest way down, an age by the shortest way up.
"""

from __future__ import annotations

import functools
import hashlib
import math
import os
import sys
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

_ROUND_TRIPS = 20
"""Number of kept round trips: those of the last ten seconds."""
DRIFT = 5e-4
"""Fastest drift between two clocks: bad quartzes, or a clock that is set slowly, as NTP sets it."""
_AHEAD_S = 2.0
"""The bounds hold for this time after a round trip; the next one comes sooner [s]."""
_FARTHEST = 1e9
"""Largest offset; a larger one, above 31 years, is from a damaged message [s]."""


@functools.cache
def this_machine() -> int:
    """A number for this machine since its start; 0: the system has none.

    Processes with the same number share CLOCK_MONOTONIC.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_bytes()
        # A container may have a monotonic clock of its own (time_namespaces(7)).
        offsets = Path("/proc/self/timens_offsets")
        boot += offsets.read_bytes() if offsets.exists() else b""
    except OSError:
        return 0
    return int.from_bytes(hashlib.blake2b(boot, digest_size=8).digest(), "little")


@functools.cache
def this_neighbourhood() -> int:
    """A number for all processes that reach this one through abstract Unix sockets; 0: none.

    They run on this machine, in this network namespace and as this user; others are refused.
    """
    try:
        network = Path("/proc/self/ns/net").stat().st_ino
    except OSError:
        return 0
    if not (sys.platform == "linux" and this_machine()):
        return 0
    text = f"{this_machine()} {network} {os.getuid()}"
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


class ClockSync:
    """Bounds of the offset between this process's monotonic clock and the hub's.

    Attributes:
        least: Hub's time minus own time is at least this [s].
        most: It is at most this [s].
        machine: This client's number of its machine; 0: its clock is not the machine's.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.least = self.most = 0.0
        self.machine = this_machine() if clock is time.monotonic else 0
        self._shared = False
        self._noted = 0.0
        self._round_trips: deque[float] = deque(maxlen=_ROUND_TRIPS)

    @property
    def round_trip(self) -> float:
        """The shortest of the last round trips [s]; NaN before the first."""
        return min(self._round_trips, default=math.nan)

    @property
    def uncertainty(self) -> float:
        """Largest amount by which an age may be too large, that of a command at the hub too [s]."""
        return self.most - self.least

    def begin(self, hub_machine: int) -> None:
        """Start at a central on the machine of this number."""
        self._shared = self.machine != 0 and hub_machine == self.machine
        self._round_trips.clear()
        farthest = 0.0 if self._shared else _FARTHEST
        self.least, self.most = -farthest, farthest

    def stood_still(self, time: float) -> None:
        """Note that this client's clock stood still for `time` [s], as its machine slept.

        No age is known before the next round trip.
        """
        if time > 0.0 and not self._shared:
            self.most = _FARTHEST

    def note(self, sent: float, hub_time: float, received: float) -> None:
        """Add a round trip: `sent`, answered at `hub_time`, `received` [s]."""
        round_trip = received - sent
        least, most = hub_time - received, hub_time - sent
        if not (0.0 <= round_trip <= _FARTHEST and max(-least, most) <= _FARTHEST):  # even for NaN
            return
        self._round_trips.append(round_trip)
        if self._shared:
            return
        margin = DRIFT * _AHEAD_S
        least, most = least - margin, most + margin
        drift = DRIFT * max(0.0, received - self._noted)
        known_least, known_most = self.least - drift, self.most + drift
        # Two right pairs of bounds overlap. Else a clock stood still, as in a machine that slept.
        if least <= known_most and most >= known_least:
            least, most = max(least, known_least), min(most, known_most)
        self.least, self.most, self._noted = least, most, received
