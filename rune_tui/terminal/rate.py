"""The exactness of pictures, so that the operator sees the present; pure.

The terminal's acknowledgements measure the line to it, and so the time of a frame under way. If
that is too long, the picture gets coarser colours, then a lower rate, and last coarser pixels.
Where nothing moves it becomes exact.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import Final

from hub.values import dataclass
from rune_tui.terminal.pacing import Acknowledgement, SentFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class Coarseness:
    """A step of coarseness.

    Attributes:
        tolerance: How far colours may be off that neighbours share, 0 to 127.
        threshold: Largest error of a pixel before it is drawn again, 0 to 255.
        grain: Edge of the squares of one colour [pixels].
        longest: A frame should not be under way for longer [s]; if it is, the next coarser way is
            better than fewer frames.
    """

    tolerance: int
    threshold: int
    grain: int
    longest: float


LADDER: Final = (
    Coarseness(tolerance=0, threshold=0, grain=1, longest=1 / 25),
    Coarseness(tolerance=2, threshold=4, grain=1, longest=1 / 25),
    Coarseness(tolerance=4, threshold=6, grain=1, longest=1 / 20),
    Coarseness(tolerance=8, threshold=10, grain=1, longest=1 / 15),
    Coarseness(tolerance=12, threshold=16, grain=1, longest=1 / 8),
    Coarseness(tolerance=16, threshold=20, grain=1, longest=1 / 4),
    Coarseness(tolerance=16, threshold=20, grain=2, longest=1 / 4),
    Coarseness(tolerance=16, threshold=20, grain=4, longest=math.inf),
)
"""Steps of coarseness, from exact to almost unrecognisable."""
_FIRST: Final = 3
"""The first step, on an unknown line."""
_STEP: Final = 2.2
"""Usual growth of frames by a finer step."""
_TOO_LONG: Final = 2.0
"""A frame that would take this multiple of the longest time is drawn again, coarser."""
_MEASURING_BYTES: Final = 2000
"""Least size of a frame that measures the speed of the line, not its delay."""
_SAMPLES: Final = 5
_TRIPS_S: Final = 10.0
"""How long the shortest round trip is remembered [s]."""
_LEAST_TRIP_S: Final = 0.001


class RateController:
    """Chooses how pictures are drawn; used with one `FramePacer`.

    Attributes:
        most_bytes: Longest frame [bytes]; a multiplexer drops longer ones.
        level: Number of the present step, 0 is exact.
    """

    def __init__(self, round_trip: float = 0.0, most_bytes: float = math.inf) -> None:
        """Begin in the middle.

        Args:
            round_trip: How long the terminal takes to answer when it has nothing to draw [s].
            most_bytes: See the attribute.
        """
        self.most_bytes = most_bytes
        self._round_trip = round_trip
        self.level = _FIRST
        self._widths: deque[float] = deque(maxlen=_SAMPLES)
        self._trips: deque[tuple[float, float]] = deque()

    @property
    def way(self) -> Coarseness:
        """How to draw pictures now."""
        return LADDER[self.level]

    @property
    def width(self) -> float:
        """Speed of the line to the terminal [bytes/s]; infinite: not known yet."""
        if not self._widths:
            return math.inf
        return sorted(self._widths)[len(self._widths) // 2]

    @property
    def round_trip(self) -> float:
        """Time of the shortest frames under way [s]."""
        return min((trip for _, trip in self._trips), default=self._round_trip)

    def acknowledged(self, now: float, answer: Acknowledgement) -> None:
        """The terminal shows a frame."""
        short = answer.size < _MEASURING_BYTES
        if short or answer.age < self.round_trip:
            self._round_trip = min(answer.age, self.round_trip)
            self._trips.append((now, answer.age))
        while self._trips and now - self._trips[0][0] > _TRIPS_S:
            self._round_trip = self._trips.popleft()[1]
        took = answer.age - self.round_trip
        if not math.isnan(answer.gap):
            took = min(took, answer.gap)
        width = answer.size / max(took, _LEAST_TRIP_S)
        if not short or width > self.width:
            self._widths.append(width)

    def under_way(self, size: float) -> float:
        """Time to send this number of bytes, without the round trip [s]."""
        return size / self.width

    def may_follow(self, now: float, frames: Iterable[SentFrame]) -> bool:
        """Whether another frame may follow those under way.

        It may after their expected arrival, even before their answers.
        """
        through = -math.inf
        for frame in frames:
            if not self._widths:
                return False
            through = max(through, frame.sent) + self.under_way(frame.size)
        return through <= now

    def room(self, now_under_way: float = 0.0) -> float:
        """How long the next frame should be at most [bytes]."""
        return min(self.most_bytes, max(0.0, self.way.longest * self.width - now_under_way))

    def too_long(self, size: float) -> bool:
        """Whether a frame of this size should rather be drawn again, coarser; takes the step."""
        if self.level + 1 == len(LADDER) or not self._exceeds(size, _TOO_LONG):
            return False
        self.level += 1
        return True

    def drawn(self, size: float) -> None:
        """Take the size of a moving picture, which adapts the coarseness of the next one."""
        last = self.level + 1 == len(LADDER)
        if not last and self._exceeds(size, 1.0):
            self.level += 1
        elif self.level:
            finer = LADDER[self.level - 1]
            grown = size * _STEP
            if grown <= self.most_bytes and self.under_way(grown) <= finer.longest:
                self.level -= 1

    def _exceeds(self, size: float, factor: float) -> bool:
        return size > self.most_bytes or self.under_way(size) > factor * self.way.longest
