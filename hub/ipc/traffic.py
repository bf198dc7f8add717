"""What central counts of the broadcasts that pass: messages, bytes, and what subscribers missed."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from hub.errors import FrameError
from hub.ipc import control, frames
from hub.ipc.ring import Place

_MAX_PUBLISHERS = 1024
_MAX_JUMP = 1 << 24
_RECENT_REPORTS = 16


@dataclass(slots=True)
class Traffic:
    """The broadcasts of one message.

    Attributes:
        messages: How many.
        bytes: How long together, with what went through shared memory [bytes].
        lost: How many subscribers missed, by the sequence numbers.
        expired: How many subscribers dropped because they were too old.
    """

    messages: int = 0
    bytes: int = 0
    lost: int = 0
    expired: int = 0
    _seen: float = -math.inf
    _sequences: dict[int, int] = field(default_factory=dict)
    _oldest: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT_REPORTS))

    def passed(self, frame: frames.Frame, size: int, now: float) -> None:
        """A copy of a broadcast of `size` bytes was seen.

        Under a flood central sees a part of the broadcasts only; their sequence numbers tell how
        many there were.
        """
        if frame.kind == frames.NO_RING:
            return
        try:
            size += _in_ring(frame)
        except FrameError:
            return
        several = frame.kind in (frames.BATCH, frames.RING_BATCH)
        held = frames.count(frame.payload) if several else 1
        newest = frame.sequence + held - 1
        last = self._sequences.get(frame.publisher, frame.sequence - 1)
        count = newest - last
        if count > _MAX_JUMP:  # a damaged number; it counts for itself
            count = held = 1
        elif count <= 0:  # it goes both ways, or its publisher begins again
            count = 0
        elif len(self._sequences) >= _MAX_PUBLISHERS:
            self._sequences.clear()
        self._sequences[frame.publisher] = max(last, newest)
        self.messages += count
        self.bytes += count * size // max(held, 1)
        self._seen = now

    def reported(self, entry: control.Received) -> None:
        """A subscriber told what it has had; nonsense is left out."""
        if max(entry.lost, entry.expired) > _MAX_JUMP or not 0.0 <= entry.oldest_s < math.inf:
            return
        self.lost += entry.lost
        self.expired += entry.expired
        self._oldest.append(entry.oldest_s)

    def silent(self, now: float) -> float:
        """Time since the last broadcast [s]; infinite if there was none."""
        return now - self._seen

    @property
    def oldest(self) -> float:
        """Largest age that subscribers told of lately [s]."""
        return max(self._oldest, default=0.0)


def _in_ring(frame: frames.Frame) -> int:
    """How long the payloads in shared memory are that a frame describes [bytes].

    Raises:
        FrameError: It describes none.
    """
    if frame.kind == frames.IN_RING:
        return Place.unpack(frame.payload).length
    if frame.kind == frames.RING_BATCH:
        return sum(Place.unpack(each).length for _, each in frames.items(frame.payload))
    return 0
