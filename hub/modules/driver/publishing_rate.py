"""When a state is published: at each change, and again after a while; pure."""

from __future__ import annotations

import math


class PublishingRate:
    """The times of one message."""

    def __init__(self, slow: float, fast: float = 10.0) -> None:
        """Start with nothing published.

        Args:
            slow: Rate without changes [Hz].
            fast: Largest rate with changes [Hz].
        """
        self._longest, self._shortest = 1.0 / slow, 1.0 / fast
        self._key: object = None
        self._at = -math.inf

    def due(self, key: object, now: float) -> bool:
        """Whether a state is published at `now` [s]; `key` has what counts as a change of it."""
        since = now - self._at
        if since < self._longest and (since < self._shortest or key == self._key):
            return False
        self._key, self._at = key, now
        return True
