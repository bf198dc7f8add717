"""The terminal's progress with drawn frames: frames have numbers, and it answers; pure.

Each frame ends with the question for the cursor's place (CSI 6 n). The terminal answers when it has
shown the frame. While too many frames are unanswered nothing is drawn. So the next frame is the
newest, even on a slow line to the terminal.
"""

from __future__ import annotations

from collections import deque
from typing import Final

from hub.values import dataclass
from rune_tui.terminal.input_stream import CursorReport

WINDOW: Final = 2
"""Frames that may be unanswered."""
TIMEOUT_S: Final = 1.0
"""An answer that takes longer may be lost [s]; the next time, it may take twice as long."""
_LONGEST_S: Final = 8.0
_MISSES: Final = 4
"""After this number of unanswered frames in a row, or of wrong answers, the terminal counts as one
without answers."""
_NARROWEST: Final = 8_000.0
"""Least usable speed of a line [bytes/s]."""
_ROW: Final = 2
"""Place of the cursor for the question; in the first row, answers look like keys."""
_NUMBERS: Final = 8
"""Number of columns that number the frames; any terminal has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SentFrame:
    """A frame that the terminal has not answered yet.

    Attributes:
        number: Its number, 0 to 7.
        size: How long it is [bytes].
        sent: When it was handed over [s].
        behind: Whether another one was under way before it.
    """

    number: int
    size: int
    sent: float
    behind: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Acknowledgement:
    """A frame that the terminal shows.

    Attributes:
        frame: Which.
        age: Time from handing it over to the answer [s].
        gap: Time since the answer before, if the terminal was busy in between [s]; NaN if not.
        size: How much it took in that time, or with this frame alone [bytes].
    """

    frame: SentFrame
    age: float
    gap: float
    size: int


class FramePacer:
    """Tracks frames under way; every method gets the time [s].

    The pacer does not wait for a terminal without answers. Then `answers` is False, and the caller
    must find the terminal's speed by other means. The questions continue.
    """

    def __init__(self, *, heard: bool = False) -> None:
        """Begin.

        Args:
            heard: Whether the terminal has ever answered such a question.
        """
        self._under_way: deque[SentFrame] = deque()
        self._number = 0
        self._answered = float("-inf")
        self._timeout = TIMEOUT_S
        self._missed = 0
        self._wrong = 0
        self._proven = False
        self._heard = heard

    @property
    def answers(self) -> bool:
        """Whether the terminal answers."""
        return self._heard

    @property
    def under_way(self) -> tuple[SentFrame, ...]:
        """Frames that are not answered, the oldest first."""
        return tuple(self._under_way)

    def may_send(self, now: float, window: int = WINDOW) -> bool:
        """Whether another frame may follow, given the unanswered ones; late ones are dropped."""
        if self._under_way and now - self._under_way[0].sent >= self._answer_time():
            self._under_way.clear()
            self._timeout = min(_LONGEST_S, 2.0 * self._timeout)
            self._missed += 1
            self._heard = self._proven and self._missed < _MISSES
        return not self.answers or len(self._under_way) < window

    def sent(self, now: float, size: int) -> str:
        """Note a frame of this size [bytes]; returns the question that must follow it."""
        if not self.answers:
            self._under_way.clear()
        frame = SentFrame(number=self._number, size=size, sent=now, behind=bool(self._under_way))
        self._under_way.append(frame)
        self._number = (self._number + 1) % _NUMBERS
        return f"\x1b[{_ROW};{frame.number + 1}H\x1b[6n"

    def answered(self, now: float, report: CursorReport) -> Acknowledgement | None:
        """Take an answer of the terminal; None: it answers no frame under way."""
        number = report.column - 1
        if report.row != _ROW or all(frame.number != number for frame in self._under_way):
            self._wrong += 1
            self._heard = self._heard and self._wrong < _MISSES
            return None
        size = 0
        while True:
            frame = self._under_way.popleft()
            size += frame.size
            if frame.number == number:
                break
        gap = now - self._answered if frame.behind else float("nan")
        self._answered, self._timeout = now, TIMEOUT_S
        self._heard = self._proven = True
        self._missed = self._wrong = 0
        return Acknowledgement(frame=frame, age=now - frame.sent, gap=gap, size=size)

    def _answer_time(self) -> float:
        """Longest wait for the oldest answer [s]; a terminal that answers may have a slow line."""
        more = sum(frame.size for frame in self._under_way) / _NARROWEST
        return self._timeout + min(_LONGEST_S, more)

    def restart(self) -> None:
        """Forget frames under way, after another terminal or an absence."""
        self._under_way.clear()
        self._timeout, self._missed = TIMEOUT_S, 0
