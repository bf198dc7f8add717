"""The base of links to a vehicle: nothing waits, and a lost link is opened again.

| state | event | action |
| --- | --- | --- |
| closed | a second since the last attempt | open it |
| open | bytes | return them |
| open | a fault | close it, and keep the reason |
| any | a frame that cannot leave now | drop it, and count it |

A late velocity is worse than none. Only the rest of a frame is kept whose first part has left.
"""

from __future__ import annotations

import abc
import errno
import math
from collections.abc import Callable
from typing import Final

from hub.robots.refusals import Refusals
from hub.values import dataclass

RETRY_S: Final = 1.0
"""Time between two attempts to open a link [s]."""
_UNHEARD_S: Final = 5.0
"""How long a sender counts whose datagrams are dropped [s]."""
MOST_READ: Final = 1 << 14
"""About the most bytes that one `read` returns; the rest waits. A flood leaves the driver time."""
AT_ONCE: Final = 1 << 14
"""Most bytes of one call of the system; no vehicle sends a longer datagram."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ByteLinkState:
    """What a link does.

    Attributes:
        up: Whether it is open.
        why: The last fault in words; empty: there was none.
        refused_since: Since when its host refuses connections [s, monotonic]; inf: it does not.
        openings: How often it was opened.
        dropped: Frames that could not leave at once.
        received: Bytes that came.
        sent: Bytes that left.
        unheard: Another sender, whose datagrams are dropped; empty: there is none.
    """

    up: bool
    why: str
    refused_since: float
    openings: int
    dropped: int
    received: int
    sent: int
    unheard: str = ""


class ByteLink(abc.ABC):
    """Bytes to and from a vehicle; used by one thread.

    Attributes:
        peers: How often it was another one that sends.
        closing: Called before its file descriptor is closed.
    """

    datagrams = False
    """Whether each piece that `read` returns is a datagram; else pieces of a stream."""

    def __init__(self) -> None:
        self._up = False
        self._retry_at = -math.inf
        self._now = -math.inf
        self._why = ""
        self._openings = self._dropped = self._received = self._sent = 0
        self._rest = b""
        self._refusals = Refusals()
        self._unheard, self._unheard_at = "", -math.inf
        self.peers = 0
        self.closing: Callable[[], None] = lambda: None

    @property
    def file(self) -> int:
        """Its file descriptor; -1: it is closed."""
        return self._file() if self._up else -1

    @property
    def state(self) -> ByteLinkState:
        """What it does now."""
        return ByteLinkState(
            up=self._up,
            why=self._why,
            refused_since=math.inf if self._up else self._refusals.since,
            openings=self._openings,
            dropped=self._dropped,
            received=self._received,
            sent=self._sent,
            unheard=self._unheard if self._now - self._unheard_at < _UNHEARD_S else "",
        )

    def read(self, now: float) -> list[bytes]:
        """The bytes that came; opens the link if it is closed.

        Args:
            now: Monotonic time [s].
        """
        self._now = now
        if not self._up and now >= self._retry_at:
            self._retry_at = now + RETRY_S
            self._open_now()
        pieces: list[bytes] = []
        size = 0
        while self._up and size < MOST_READ:
            try:
                piece = self._receive()
            except BlockingIOError:
                break
            except OSError as fault:
                self._lose(fault)
                break
            pieces.append(piece)
            size += len(piece) + 1
            self._received += len(piece)
        return pieces

    def write(self, frame: bytes) -> bool:
        """Send a frame at once, or drop it; returns whether it left."""
        self._rest = self._rest[self._leave(self._rest) :] if self._rest else b""
        left = 0 if self._rest else self._leave(frame)
        if left:
            self._rest = frame[left:]
        else:
            self._dropped += 1
        return bool(left)

    def close(self) -> None:
        """Close it; a later `read` opens it again."""
        self.closing()
        self._shut()
        self._up, self._rest = False, b""

    def _open_now(self) -> None:
        try:
            self._open()
        except OSError as fault:
            self._lose(fault)
            return
        self._up = True
        self._openings += 1

    def _leave(self, data: bytes) -> int:
        """Send what leaves at once; returns the number of bytes."""
        if not self._up:
            return 0
        try:
            sent = self._send(data)
        except BlockingIOError:
            return 0
        except OSError as fault:
            self._lose(fault)
            return 0
        self._sent += sent
        return sent

    def _lose(self, fault: OSError) -> None:
        self._why = fault.strerror or str(fault) or type(fault).__name__
        self._refusals.attempt(self._now, refused=fault.errno == errno.ECONNREFUSED)
        self.close()

    @abc.abstractmethod
    def _open(self) -> None:
        """Open it without waiting."""

    @abc.abstractmethod
    def _receive(self) -> bytes:
        """The next piece; `BlockingIOError`: there is none yet."""

    @abc.abstractmethod
    def _send(self, data: bytes) -> int:
        """Send without waiting; returns the number of bytes that left."""

    @abc.abstractmethod
    def _file(self) -> int:
        """The file descriptor of the open link."""

    @abc.abstractmethod
    def _shut(self) -> None:
        """Close it, also if it is not open."""
