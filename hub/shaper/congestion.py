"""How many packets of a connection may be on their way at once, as TCP decides it; pure.

| event | window |
| --- | --- |
| begin | 10 packets |
| an answer, below the threshold | 1 packet more: it doubles in a round trip |
| an answer, above the threshold | 0.53 packets more in a round trip |
| an answer to what was sent before the last loss showed | no change |
| a loss that a later packet showed | 0.7 of it, once in a window; that is the threshold |
| a time-out | 1 packet; half of the window is the threshold |
| a pause longer than the time-out | 10 packets at most |

This is CUBIC where it follows Reno (RFC 9438, 4.3), as it does on thin and lossy links. The window
grows only while it limits what is sent.
"""

from __future__ import annotations

import math

_BEGIN, _LEAST = 10.0, 2.0
_AFTER_LOSS, _AFTER_TIME_OUT = 0.7, 0.5
_GROWTH = 3.0 * (1.0 - _AFTER_LOSS) / (1.0 + _AFTER_LOSS)
"""Packets in a round trip with which the factor after a loss gives the mean window of Reno."""


class CongestionWindow:
    """The window of one connection in one direction.

    Attributes:
        size: Packets that may be on their way.
    """

    __slots__ = ("_reduced", "_threshold", "_used", "size")

    def __init__(self) -> None:
        self.size = _BEGIN
        self._threshold = math.inf
        self._reduced = self._used = -math.inf

    def answered(self, on_their_way: int, sent: float) -> None:
        """An answer came for one of the packets on their way, which was sent at a time [s]."""
        if sent > self._reduced and 2 * on_their_way >= self.size:
            self.size += 1.0 if self.size < self._threshold else _GROWTH / self.size

    def showed_loss(self, sent: float, now: float) -> None:
        """A later packet showed that one is lost, which was sent at a time [s]."""
        if sent > self._reduced:
            self.size = self._threshold = max(_LEAST, _AFTER_LOSS * self.size)
            self._reduced = now

    def timed_out(self) -> None:
        """No answer came to a packet."""
        self._threshold = max(_LEAST, _AFTER_TIME_OUT * self.size)
        self.size = 1.0

    def use(self, now: float, time_out: float) -> None:
        """A packet is sent; after a pause the window is that of the begin at most."""
        if now - self._used > time_out:
            self.size = min(self.size, _BEGIN)
        self._used = now
