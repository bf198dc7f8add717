"""Whether a vehicle is there and answers: heartbeats, and echoes of TIMESYNC; pure.

A heartbeat says that the vehicle sends. Only an echo says that it receives, and when: not before
the question left. So the age of the newest question that was answered bounds both the silence and
the delay of the link.

| state of the link | questions |
| --- | --- |
| answers come as usual | every 0.2 s |
| it loses more than 5 % of the echoes, or they take 0.3 s | every 0.1 s |
| the next answer is late, since at most 3 s | every 0.05 s |
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

HEARTBEAT_LOST_S: Final = 2.5
"""Silence after which a vehicle is gone [s]."""
ECHO_LOST_S: Final = 1.0
"""Age of the newest answered question from which the vehicle does not receive in time [s]."""
ECHO_BACK_S: Final = 0.8
"""The same age until which a vehicle that was gone is back [s]."""
ECHO_EVERY_S: Final = 0.2
_HURRIED_S: Final = 0.045
"""Time between two questions while an answer is late [s]: at steps of 50 ms, 20 Hz."""
_LOSSY_S: Final = 0.095
"""Time between two questions on a link that loses some [s]."""
_LATE_S: Final = 0.05
_LONGEST_HURRY_S: Final = 3.0
_FIRST_ECHO_S: Final = 3.0
"""Longest time until the first echo [s]."""
_AFTER_PAUSE_S: Final = 0.5
"""Longest time until an echo after a pause of this process [s]."""
_AWAITED_S: Final = 0.1
_LATELY_S: Final = 4.0
_COUNTED_S: Final = 10.0
"""Age of the questions that the loss counts [s]."""
_MOST_QUESTIONS: Final = 256
SLOW_S: Final = 0.3
"""Round trip from which a link is slow [s]."""
_FEWEST_QUESTIONS: Final = 20
"""Fewest questions that say how much is lost."""
_LOSSY: Final = 0.05
"""Share of lost echoes from which a link counts as lossy."""
_NEW: Final = 0.2
"""Share of the newest round trip in their mean."""


class Liveness:
    """The heartbeats and echoes of one vehicle; times are monotonic [s].

    Attributes:
        heard: Time of the last heartbeat.
        answered: When the newest question that was answered left.
        round_trip: Of the last echo [s]; NaN: none came.
        delay: Mean of the last round trips [s]; NaN as above.
        lossy: Whether it loses more than 5 % of the echoes, so that all is sent more often.
    """

    def __init__(self) -> None:
        self.heard = self.answered = -math.inf
        self.round_trip = self.delay = math.nan
        self.lossy = False
        self._came = self._since = self._patient_until = -math.inf
        self._sent: deque[int] = deque(maxlen=_MOST_QUESTIONS)
        self._answers: set[int] = set()
        self._next_echo = -math.inf

    def heartbeat(self, now: float) -> None:
        """Take a heartbeat."""
        if self.heard == -math.inf:
            self._since = now
        self.heard = now

    def paused(self, now: float) -> None:
        """This process paused: that the last question is old says nothing of the vehicle."""
        self._patient_until = now + _AFTER_PAUSE_S

    def echo_due(self, now: float) -> int:
        """The stamp of an echo to send now [ns]; 0: none."""
        if now < self._next_echo:
            return 0
        self.lossy = self.lost(now) > _LOSSY
        every = _LOSSY_S if self.lossy or self.delay > SLOW_S else ECHO_EVERY_S
        late = now - self.answered - (0.0 if math.isnan(self.delay) else self.delay)
        if every + _LATE_S < late < _LONGEST_HURRY_S:
            every = _HURRIED_S
        self._next_echo = now + every
        stamp = int(now * 1e9)
        while self._sent and (len(self._sent) == _MOST_QUESTIONS or self._is_old(now)):
            self._answers.discard(self._sent.popleft())
        self._sent.append(stamp)
        return stamp

    def echo(self, stamp: int, now: float) -> bool:
        """Take an echo; whether it answers a question of this station for the first time."""
        if stamp not in self._sent or stamp in self._answers:
            return False
        self._answers.add(stamp)
        self._came = now
        self.answered = max(self.answered, stamp / 1e9)
        self.round_trip = max(0.0, now - stamp / 1e9)
        known = self.round_trip if math.isnan(self.delay) else self.delay
        self.delay = known + _NEW * (self.round_trip - known)
        return True

    def awaits(self, now: float) -> bool:
        """Whether an echo is on its way; a late one is no longer waited for."""
        return bool(self._sent) and self._sent[-1] / 1e9 > max(self.answered, now - _AWAITED_S)

    def lost(self, now: float) -> float:
        """Share of the echoes of the last 10 s that did not come back; NaN: not known."""
        due = [each for each in self._sent if now - each / 1e9 > ECHO_LOST_S]
        if len(due) < _FEWEST_QUESTIONS:
            return math.nan
        return sum(each not in self._answers for each in due) / len(due)

    def answered_lately(self, now: float) -> bool:
        """Whether its mode is known, and it answered a short while ago."""
        return self._beats(now) and now - self.answered <= _LATELY_S

    def gone(self, now: float, *, was: bool = False) -> str:
        """Why the vehicle is gone; empty: it is there, and answers.

        Args:
            now: The time.
            was: Whether it was gone until now.
        """
        if not self._beats(now):
            return f"no heartbeat for {now - self.heard:.0f} s"
        first = self._since + _FIRST_ECHO_S - ECHO_LOST_S
        most = ECHO_BACK_S if was else ECHO_LOST_S
        if now - max(self.answered, first) <= most or now < self._patient_until:
            return ""
        if now - self._came <= ECHO_LOST_S:
            return (
                f"its answers take {self.delay:.1f} s, and it is driven up to {ECHO_BACK_S:g} s "
                "only: it would obey and stop too late"
            )
        return "it does not answer, so it may not receive commands"

    def _beats(self, now: float) -> bool:
        return now - self.heard <= HEARTBEAT_LOST_S

    def _is_old(self, now: float) -> bool:
        return now - self._sent[0] / 1e9 > _COUNTED_S
