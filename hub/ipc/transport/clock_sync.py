"""The hub's clock as a client sees it: central's monotonic clock, estimated over the bus.

All stamps on the bus are on this clock, so that an age is a difference of two of its times, on
whatever machine. Processes on central's own machine share its clock; another machine measures the
offset as NTP does: a question and its answer carry the times at which they left, and the offset is
taken to lie in the middle of the round trip, which is wrong by half of it at most. The best of all
round trips counts, each the worse the longer ago it was, because clocks drift (RFC 5905, section
10). So a link that is busy for minutes does not make what comes through it look younger.
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
"""Round trips remembered: those of the last ten seconds."""
_DRIFT = 1e-4
"""How fast two clocks may come apart: bad quartzes, or one that is being set slowly."""
_FARTHEST = 1e9
"""No machine has run for longer than 31 years: what is farther apart is a damaged message [s]."""


@functools.cache
def this_machine() -> int:
    """A number for this machine since it was started; 0 where the system has none.

    Processes with the same number share CLOCK_MONOTONIC.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_bytes()
        # Containers may have monotonic clocks of their own (time_namespaces(7)).
        offsets = Path("/proc/self/timens_offsets")
        boot += offsets.read_bytes() if offsets.exists() else b""
    except OSError:
        return 0
    return int.from_bytes(hashlib.blake2b(boot, digest_size=8).digest(), "little")


@functools.cache
def this_neighbourhood() -> int:
    """A number for all processes that reach this one through abstract Unix sockets, or 0.

    They run on this machine, in this network namespace and as this user: whatever else could
    connect is refused.
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
        machine: What this client says its machine is; 0 if its clock is not the machine's.
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
        """The client is connected to a central on the machine of this number."""
        self._shared = self.machine != 0 and hub_machine == self.machine
        self._round_trips.clear()
        self._error = math.inf
        self.offset = 0.0

    def note(self, sent: float, hub_time: float, received: float) -> None:
        """A question left at `sent`, was answered at `hub_time`; that came at `received` [s]."""
        round_trip = received - sent
        offset, error = hub_time - (sent + received) / 2, round_trip / 2
        if not (0.0 <= round_trip <= _FARTHEST and abs(offset) <= _FARTHEST):  # also of NaN
            return
        self._round_trips.append(round_trip)
        if self._shared:
            return
        known = self._error + _DRIFT * (received - self._noted)
        # Both can only be right if they overlap; else a clock has stood still, as in a machine
        # that slept.
        if error <= known or abs(offset - self.offset) > error + known:
            self.offset, self._error, self._noted = offset, error, received
