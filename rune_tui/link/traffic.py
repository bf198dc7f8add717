"""Measures the traffic of a link; used by the link's thread."""

from __future__ import annotations


class Traffic:
    """Counts messages and bytes."""

    def __init__(self, now: float) -> None:
        """Start at `now` [s] with no traffic."""
        self._messages = self._bytes = 0
        self._before = now, 0, 0

    def add(self, size: int = 0) -> None:
        """Add a message of this size [bytes]; 0: the size does not matter."""
        self._messages += 1
        self._bytes += size

    def rates(self, now: float) -> dict[str, float]:
        """Messages and bytes a second since the last call, as `LinkState` names them."""
        then, messages, size = self._before
        self._before = now, self._messages, self._bytes
        if now <= then:
            return {}
        return {
            "messages_per_s": (self._messages - messages) / (now - then),
            "bytes_per_s": (self._bytes - size) / (now - then),
        }
