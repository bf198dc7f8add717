"""Floods of subscriptions: a connection that makes one is ended.

ZeroMQ (4.3.5) takes any number of subscriptions from a connection, hands each on to all publishers,
and takes all of them back at once when the connection ends. It says how many there are, but not
of which connection. But central takes them in slowly (see `sockets`), so a flood waits in front of
it, and the system knows how much waits of each connection.
"""

from __future__ import annotations

import array
import contextlib
import fcntl
import math
import termios
from collections import Counter
from dataclasses import dataclass

import zmq

from hub.bucket import Bucket
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.file_descriptors import hang_up, received

_SUSPICIOUS = 200
"""When there are this many more subscriptions than at the last look, connections are examined."""
MOST = 3 * 4096
"""What one connection may add in one go: its 4096 messages, a mark for each, and some more."""
_LOOK_CLOSELY_S = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """What subscribers with keys may do.

    Attributes:
        topics: Different topics that all of them together subscribe to.
        bytes_per_s: What one connection may send, which is nothing but subscriptions [B/s].
        bytes_at_once: The same, in one burst after a rest [B].
        modest: An address that has sent no more than this is not ended for too many topics [B].
    """

    topics: int = 1024
    bytes_per_s: float = 1024.0
    bytes_at_once: float = float(192 << 10)
    modest: int = 96 << 10


@dataclass(slots=True)
class _Sender:
    """What one connection has sent: from where, bytes in all, and what it may send now."""

    address: str
    allowance: Bucket
    sent: int = 0


class FloodWatch:
    """Watches the connections of one socket that subscribers connect to."""

    def __init__(
        self,
        outward: sockets.Socket,
        where: str,
        faults: FaultCounter,
        bounds: Bounds | None = None,
    ) -> None:
        """Watch from now on.

        Args:
            outward: The socket (XPUB); only the number of its subscriptions is read, which ZeroMQ
                lets any thread do. It has to be open as long as `look` is called.
            where: What it is called in the log.
            faults: Where floods are counted.
            bounds: What a connection may do in the long run; None for no such limit.
        """
        self._outward = outward
        self._where = where
        self._faults = faults
        self._known = 0
        self._added: dict[int, float] = {}
        self._bounds = bounds
        self._senders: dict[int, _Sender] = {}
        self._next_look = -math.inf

    def connected(self, descriptor: int, address: str = "") -> None:
        """A connection has come from this address."""
        self._added[descriptor] = 0.0
        if self._bounds is not None:
            allowance = Bucket(self._bounds.bytes_per_s, self._bounds.bytes_at_once)
            self._senders[descriptor] = _Sender(address, allowance)

    def disconnected(self, descriptor: int) -> None:
        """A connection has ended."""
        self._added.pop(descriptor, None)
        self._senders.pop(descriptor, None)

    def look(self, now: float) -> None:
        """See what was added; to be called ten times a second or so.

        Args:
            now: The time [s].
        """
        if self._bounds is not None and now >= self._next_look:
            self._next_look = now + _LOOK_CLOSELY_S
            self._look_closely(self._bounds, now)
        known = int(self._outward.getsockopt(zmq.TOPICS_COUNT))
        new, self._known = known - self._known, known
        if new < _SUSPICIOUS:
            if any(self._added.values()):
                self._added = dict.fromkeys(self._added, 0.0)
            return
        waiting = [descriptor for descriptor in self._added if _unread(descriptor)]
        self._added = {
            descriptor: added + new / len(waiting) if descriptor in waiting else 0.0
            for descriptor, added in self._added.items()
        }
        for descriptor in waiting:
            if self._added[descriptor] > MOST:
                self._end(descriptor, f"after about {MOST} in one go")

    def _look_closely(self, bounds: Bounds, now: float) -> None:
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
            if sent > bounds.modest:
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
    """Bytes that have come in on a connection and wait to be read."""
    count = array.array("i", [0])
    with contextlib.suppress(OSError):  # it has gone by itself
        fcntl.ioctl(descriptor, termios.FIONREAD, count)
    return count[0]
