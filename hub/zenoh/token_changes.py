"""Tokens that come and go, from the threads of Zenoh to a loop.

Of each key only the newest two changes wait. So a flood of tokens fills no memory, delays no other
call for long, and loses no token that goes.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from hub.zenoh.handover import Work

_logger = logging.getLogger(__name__)

MOST_KEYS = 20_000
"""Most keys whose changes wait; of more keys, only tokens that go are noted."""
_AT_ONCE = 100
"""Most changes in one turn of the loop."""


class TokenChanges:
    """The changes of tokens that the loop has not got yet.

    Attributes:
        dropped: Number of tokens that came and were not noted, because too many waited.
    """

    def __init__(self, post: Callable[[Work], None], changed: Callable[[str, bool], None]) -> None:
        """Begin.

        Args:
            post: Has the loop make a call; any thread may ask.
            changed: Gets each key, and whether its token is there.
        """
        self.dropped = 0
        self._post, self._changed = post, changed
        self._lock = threading.Lock()
        self._waiting: dict[str, tuple[bool, ...]] = {}
        self._posted = False

    def note(self, key: str, there: bool) -> None:  # noqa: FBT001 - Zenoh calls it
        """Note a change; any thread may."""
        with self._lock:
            before = self._waiting.get(key)
            if before is None and there and len(self._waiting) >= MOST_KEYS:
                self.dropped += 1
                return
            self._waiting[key] = (*(before or ())[-1:], there)
            wake, self._posted = not self._posted, True
        if wake:
            self._post(self._run)

    def _run(self) -> None:
        for _ in range(_AT_ONCE):
            with self._lock:
                if not self._waiting:
                    self._posted = False
                    return
                key = next(iter(self._waiting))
                changes = self._waiting.pop(key)
            for there in changes:
                try:
                    self._changed(key, there)
                except Exception:  # one bad call must not stop what waits behind it
                    _logger.exception("a token of a fleet could not be followed")
        self._post(self._run)
