"""Floods of subscriptions: central ends a connection that makes one.

ZeroMQ (4.3.5) accepts any number of subscriptions from a connection, forwards each to all
publishers, and withdraws all of them when the connection ends. It counts them in total, but not per
connection. Central reads them slowly (see `sockets`), so a flood waits in front of it, and the
system knows the waiting bytes of each connection.
"""

from __future__ import annotations

import array
import contextlib
import fcntl
import math
import termios
from collections import Counter

import zmq

from hub.bucket import Bucket
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.file_descriptors import hang_up, received
from hub.values import dataclass

_EXAMINE_FROM = 200
"""Examine connections from this many new subscriptions since the last check."""
MAX_AT_ONCE = 3 * 4096
"""Most subscriptions that one connection may add at once: 4096 messages, their marks, and more."""
_RATE_CHECK_S = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """Limits for subscribers with keys.

    Attributes:
        topics: Different topics of all of them together.
        bytes_per_s: Bytes of one connection, which sends only subscriptions [B/s].
        bytes_at_once: The same, in one burst after a rest [B].
        harmless: An address below this is never ended for too many topics [B].
    """

    topics: int = 1024
    bytes_per_s: float = 1024.0
    bytes_at_once: float = float(192 << 10)
    harmless: int = 96 << 10


@dataclass(slots=True)
class _Sender:
    """One connection: its address, its bytes so far, and its remaining allowance."""

    address: str
    allowance: Bucket
    sent: int = 0


class FloodWatch:
    """Watches the subscribers' connections to one socket."""

    def __init__(
        self,
        outward: sockets.Socket,
        where: str,
        faults: FaultCounter,
        bounds: Bounds | None = None,
    ) -> None:
        """Start to watch.

        Args:
            outward: The socket (XPUB), open while `check` is called. Only the number of its
                subscriptions is read, which ZeroMQ allows to any thread.
            where: Its name in the log.
            faults: Counts floods.
            bounds: Limits in the long run; None: no such limit.
        """
        self._outward = outward
        self._where = where
        self._faults = faults
        self._known = 0
        self._added: dict[int, float] = {}
        self._bounds = bounds
        self._senders: dict[int, _Sender] = {}
        self._next_rate_check = -math.inf

    def connected(self, descriptor: int, address: str = "") -> None:
        """Watch a new connection from this address."""
        self._added[descriptor] = 0.0
        if self._bounds is not None:
            allowance = Bucket(self._bounds.bytes_per_s, self._bounds.bytes_at_once)
            self._senders[descriptor] = _Sender(address, allowance)

    def disconnected(self, descriptor: int) -> None:
        """Forget a connection that ended."""
        self._added.pop(descriptor, None)
        self._senders.pop(descriptor, None)

    def check(self, now: float) -> None:
        """End connections that add too many subscriptions; call it about ten times a second.

        Args:
            now: The time [s].
        """
        if self._bounds is not None and now >= self._next_rate_check:
            self._next_rate_check = now + _RATE_CHECK_S
            self._check_rates(self._bounds, now)
        known = int(self._outward.getsockopt(zmq.TOPICS_COUNT))
        new, self._known = known - self._known, known
        if new < _EXAMINE_FROM:
            if any(self._added.values()):
                self._added = dict.fromkeys(self._added, 0.0)
            return
        waiting = [descriptor for descriptor in self._added if _unread(descriptor)]
        self._added = {
            descriptor: added + new / len(waiting) if descriptor in waiting else 0.0
            for descriptor, added in self._added.items()
        }
        for descriptor in waiting:
            if self._added[descriptor] > MAX_AT_ONCE:
                self._end(descriptor, f"after about {MAX_AT_ONCE} in one go")

    def _check_rates(self, bounds: Bounds, now: float) -> None:
        """End connections that send too much; with too many topics, one of the busiest address."""
        for descriptor, sender in list(self._senders.items()):
            sent = received(descriptor)
            new, sender.sent = sent - sender.sent, sent
            if new > 0 and not sender.allowance.take(new, now):
                self._end(descriptor, f"after {sent >> 10} KiB of subscriptions")
        if self._known <= bounds.topics:
            return
        sent_from: Counter[str] = Counter()
        for sender in self._senders.values():
            sent_from[sender.address] += sender.sent
        for address, sent in sent_from.most_common(1):
            if sent > bounds.harmless:
                most = max(
                    (each for each in self._senders if self._senders[each].address == address),
                    key=lambda each: self._senders[each].sent,
                )
                self._end(most, f"as there are {self._known} topics, most of them of {address}")

    def _end(self, descriptor: int, why: str) -> None:
        text = f"a connection to {self._where} is ended {why}"
        self._faults.count("flood of subscriptions", text)
        self.disconnected(descriptor)
        hang_up(descriptor)


def _unread(descriptor: int) -> int:
    """Received bytes of a connection that wait for a read."""
    count = array.array("i", [0])
    with contextlib.suppress(OSError):  # it has ended by itself
        fcntl.ioctl(descriptor, termios.FIONREAD, count)
    return count[0]
