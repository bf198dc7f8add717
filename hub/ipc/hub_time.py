"""The hub's clock as a client sees it: central's monotonic clock, estimated over the bus.

All stamps on the bus are on this clock, so that an age is a difference of two of its times, on
whatever machine. Processes on central's own machine share its clock; another machine measures the
offset as NTP does: a question and its answer carry the times at which they left, the offset is
taken to lie in the middle of the round trip, and the fastest of the last round trips counts,
because its error is the smallest: at most half of it (RFC 5905, section 8).
"""

from __future__ import annotations

import functools
import hashlib
import os
import sys
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

_SAMPLES = 20
"""Round trips remembered: those of the last ten seconds."""


@functools.cache
def this_machine() -> int:
    """A number for this machine since it was started; 0 where the system does not tell.

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


class HubTime:
    """The offset between this process's monotonic clock and the hub's.

    Attributes:
        offset: Hub's time minus own time [s].
        uncertainty: How wrong the offset may be [s].
        machine: What this client says its machine is; 0 if its clock is not the machine's.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.offset = 0.0
        self.uncertainty = 0.0
        self.machine = this_machine() if clock is time.monotonic else 0
        self._shared = False
        self._samples: deque[tuple[float, float]] = deque(maxlen=_SAMPLES)

    def begin(self, hub_machine: int) -> None:
        """A central on the machine of this number has welcomed us."""
        self._shared = self.machine != 0 and hub_machine == self.machine
        self._samples.clear()
        self.offset = self.uncertainty = 0.0

    def note(self, sent: float, hub_time: float, received: float) -> None:
        """A question left at `sent`, was answered at `hub_time`; that came at `received` [s]."""
        if self._shared or received < sent:
            return
        self._samples.append((received - sent, hub_time - (sent + received) / 2))
        round_trip, self.offset = min(self._samples)
        self.uncertainty = round_trip / 2
