"""Floods of subscriptions: who makes one is seen and disconnected.

ZeroMQ (4.3.5) takes any number of subscriptions from a connection, hands each on to all publishers,
and takes all of them back at once when the connection ends. It tells how many there are, and not
whose. But central takes them in so slowly (see `sockets`) that a flood piles up in front of
it, and how much waits is known of each connection.
"""

from __future__ import annotations

import array
import contextlib
import fcntl
import termios

import zmq

from hub.ipc import sockets
from hub.ipc.complaints import Complaints
from hub.ipc.descriptors import hang_up

_SUSPICIOUS = 200
"""So many more subscriptions from one look to the next are looked into."""
MOST = 3 * 4096
"""What one connection may add in one go: its 4096 messages, a mark for each, and some more."""


class FloodWatch:
    """Watches the connections of one socket that subscribers connect to."""

    def __init__(self, outward: sockets.Socket, where: str, complaints: Complaints) -> None:
        """Watch from now on.

        Args:
            outward: The socket (XPUB); only the number of its subscriptions is read, which ZeroMQ
                lets any thread do. It has to be open as long as `look` is called.
            where: What it is called in the log.
            complaints: Where floods are counted.
        """
        self._outward = outward
        self._where = where
        self._complaints = complaints
        self._known = 0
        self._added: dict[int, float] = {}

    def connected(self, descriptor: int) -> None:
        """A connection has come."""
        self._added[descriptor] = 0.0

    def disconnected(self, descriptor: int) -> None:
        """A connection has ended."""
        self._added.pop(descriptor, None)

    def look(self) -> None:
        """See what was added; to be called ten times a second or so."""
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
                self._complaints.count(
                    "flood of subscriptions",
                    f"a connection to {self._where} is ended after about {MOST} in one go",
                )
                del self._added[descriptor]
                hang_up(descriptor)


def _unread(descriptor: int) -> int:
    """Bytes that have come in on a connection and wait to be read."""
    count = array.array("i", [0])
    with contextlib.suppress(OSError):  # it has gone by itself
        fcntl.ioctl(descriptor, termios.FIONREAD, count)
    return count[0]
