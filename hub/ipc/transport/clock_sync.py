"""The hub's clock at a client: central's monotonic clock, estimated over the bus.

All stamps on the bus are on this clock, so an age is a difference of two stamps on any machine.
Processes on central's machine share its clock. Another machine measures the offset as NTP does:
request and answer carry their times of sending. The estimate is the middle of the round trip, and
its error is half of that at most. The best round trip counts, and older ones count less, because
clocks drift (RFC 5905, section 10). So messages on a busy link never seem younger than they are.
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
_DRIFT = 1e-4
"""Fastest drift between two clocks: bad quartzes, or a clock that is being set slowly."""
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
    """The offset between this process's monotonic clock and the hub's.

    Attributes:
        offset: Hub's time minus own time [s].
        machine: This client's number of its machine; 0: its clock is not the machine's.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.offset = 0.0
        self.machine = this_machine() if clock is time.monotonic else 0
        self._shared = False
        self._error, self._noted = math.inf, 0.0
        self._round_trips: deque[float] = deque(maxlen=_ROUND_TRIPS)

    @property
    def round_trip(self) -> float:
        """The shortest of the last round trips [s]; NaN before the first."""
        return min(self._round_trips, default=math.nan)

    def begin(self, hub_machine: int) -> None:
        """Start at a central on the machine of this number."""
        self._shared = self.machine != 0 and hub_machine == self.machine
        self._round_trips.clear()
        self._error = math.inf
        self.offset = 0.0

    def note(self, sent: float, hub_time: float, received: float) -> None:
        """Add a round trip: `sent`, answered at `hub_time`, `received` [s]."""
        round_trip = received - sent
        offset, error = hub_time - (sent + received) / 2, round_trip / 2
        if not (0.0 <= round_trip <= _FARTHEST and abs(offset) <= _FARTHEST):  # even for NaN
            return
        self._round_trips.append(round_trip)
        if self._shared:
            return
        known = self._error + _DRIFT * (received - self._noted)
        # Two right estimates overlap. Else a clock has stood still, as in a machine that slept.
        if error <= known or abs(offset - self.offset) > error + known:
            self.offset, self._error, self._noted = offset, error, received
