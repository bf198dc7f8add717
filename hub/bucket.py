"""Bounds how often something is done: a token bucket; pure."""

from __future__ import annotations


class Bucket:
    """A rate with room for bursts: it fills up with time, and what is done takes from it."""

    __slots__ = ("_filled", "_level", "_most", "_rate")

    def __init__(self, rate: float, most: float) -> None:
        """A full one.

        Args:
            rate: What comes back each second.
            most: What it holds.
        """
        self._rate = rate
        self._most = self._level = most
        self._filled = 0.0

    def take(self, amount: float, now: float) -> bool:
        """Take so much if there is so much."""
        level = min(self._most, self._level + (now - self._filled) * self._rate)
        self._filled = now
        enough = amount <= level
        self._level = level - amount if enough else level
        return enough
