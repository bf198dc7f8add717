"""Pauses of this process: it was suspended, got no processor, or its machine slept.

Old input waits to be read after a pause. The times at which it was given are not known, so it must
not drive.

| event | meaning |
| --- | --- |
| more than `longest_s` between two looks | the process paused |
| input within `stale_s` after that | it may be from before or during the pause |
"""

from __future__ import annotations

import math

from hub.machine_sleep import MachineSleep


class OwnPauses:
    """Detects pauses of the process that it runs in; the first look finds none.

    Attributes:
        seen: Time of the last look [s].
    """

    def __init__(
        self, longest_s: float, *, stale_s: float = 0.0, sleep: MachineSleep | None = None
    ) -> None:
        self._longest_s = longest_s
        self._stale_s = stale_s
        self.seen = math.inf
        self._sleep = sleep or MachineSleep()
        self._stale_until = -math.inf

    def look(self, now: float) -> float:
        """How long the process paused just before `now` [s]; 0: it did not."""
        away = now - self.seen + self._sleep.look()
        self.seen = now
        if away <= self._longest_s:
            return 0.0
        self._stale_until = now + self._stale_s
        return away

    def is_stale(self, now: float) -> bool:
        """Whether input at `now` may be from before or during a pause."""
        return now < self._stale_until
