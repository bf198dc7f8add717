"""Whether the states of a robot come at the low rate, because the line falls behind; pure.

A line that is too thin for all states keeps the oldest of them in its buffers: even the youngest
state is late then. The youngest counts, because a single message may be measured long before.

| states come | what is seen | then |
| --- | --- | --- |
| at the full rate | the youngest of 1 s is late | the low rate |
| at the low rate | none is late for the trial time | the full rate |
| at the full rate | late within 30 s after a trial | the low rate; the trial time doubles |
"""

from __future__ import annotations

import math

LATE_S = 0.5
"""Age of the youngest state from which on the line falls behind, beside its usual delay [s]."""
_WINDOW_S = 1.0
_FIRST_TRIAL_S, _LONGEST_TRIAL_S = 10.0, 160.0
_RELAPSE_S = 30.0
_MOST_NUMBERS = 4096
_MOST_LEFT_OUT = 1 << 20
_REORDERED = 1000


class ThinChoice:
    """Chooses the rate from the ages of states.

    Attributes:
        thin: Whether the low rate is chosen.
    """

    def __init__(self) -> None:
        """Begin at the full rate."""
        self.thin = False
        self._trial = _FIRST_TRIAL_S
        self._youngest = math.inf
        self._due = -math.inf
        self._since = -math.inf

    def note(self, age: float) -> None:
        """A state came with this age [s]."""
        self._youngest = min(self._youngest, age)

    def look(self, now: float, delay: float) -> bool:
        """Choose, about twice a second; returns whether the low rate is chosen.

        Args:
            now: Monotonic time [s].
            delay: Usual delay of the line in one direction [s].
        """
        if now < self._due:
            return self.thin
        self._due = now + _WINDOW_S
        youngest, self._youngest = self._youngest, math.inf
        if math.isinf(youngest):
            return self.thin
        late = youngest > LATE_S + delay
        if not self.thin:
            if late:
                relapsed = now - self._since < _RELAPSE_S
                self._trial = min(2 * self._trial, _LONGEST_TRIAL_S) if relapsed else _FIRST_TRIAL_S
                self.thin, self._since = True, now
        elif late:
            self._since = now
        elif now - self._since >= self._trial:
            self.thin, self._since = False, now
        return self.thin


class LeftOutNumbers:
    """Sequence numbers without the messages that the low rate leaves out: those are not lost."""

    def __init__(self) -> None:
        """Know none yet."""
        self._known: dict[tuple[str, int], tuple[int, int]] = {}

    def knows(self, name: str, publisher: int) -> bool:
        """Whether it has seen a message of this publisher."""
        return (name, publisher) in self._known

    def number(self, name: str, publisher: int, sequence: int, *, thin: bool) -> int:
        """The number of a message for its receivers here.

        Args:
            name: Of the message.
            publisher: Number of its publisher.
            sequence: Its number there.
            thin: Whether it came at the low rate.
        """
        key = name, publisher
        last, left_out = self._known.get(key, (sequence - 1, 0))
        gap = sequence - last - 1
        if gap > _MOST_LEFT_OUT or gap < -_REORDERED or sequence <= left_out:
            left_out, last = 0, sequence  # the publisher counts from another start
        elif thin and gap > 0:
            left_out += gap
        if key not in self._known and len(self._known) >= _MOST_NUMBERS:
            self._known.clear()
        self._known[key] = max(last, sequence), left_out
        return sequence - left_out
