"""After a dropped key, all keys are dropped until none came for a while; pure.

A key can begin what the keys after it end, as Ctrl-P begins the search of an action. Without it,
the letters of the search would be orders. A stop counts in spite of this.

| state | event | next |
| --- | --- | --- |
| OPEN | a key is dropped: it is old, pasted, mutilated or withheld | DROPPING |
| DROPPING | a key, within 0.3 s of the last one | DROPPING |
| DROPPING | no key for 0.3 s | OPEN |

On a terminal that answers, 0.3 s count between its answers. So a slow line cannot shorten them.
"""

from __future__ import annotations

import math

from rune_tui.controls.release_guard import ReleaseGuard
from rune_tui.controls.typing_speed import QUIET_S


class DroppedKeys:
    """Follows the table above; the clock is passed in.

    Attributes:
        dropping: Whether keys are dropped now.
    """

    def __init__(self, guard: ReleaseGuard) -> None:
        """Take what knows how long keys were quiet."""
        self._guard = guard
        self.dropping = False
        self._last = -math.inf

    def drop(self, now: float) -> None:
        """Drop keys from now on; a key was dropped at this time [s]."""
        self.dropping = True
        self._last = max(self._last, now)

    def drops(self, read: float, *, stale: bool) -> bool:
        """Whether a key is dropped.

        Args:
            read: The time at which it was read [s].
            stale: Whether it may have been typed while the console paused.
        """
        self.update(read)
        if stale or self.dropping:
            self.drop(read)
        return self.dropping

    def update(self, now: float) -> None:
        """End the drop if no key came for `QUIET_S`."""
        self.dropping = self.dropping and not self._guard.quiet(self._last, QUIET_S, now)
