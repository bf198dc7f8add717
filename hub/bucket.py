"""Bounds a rate: a token bucket; pure."""

from __future__ import annotations


class Bucket:
    """A rate with room for bursts: time fills it, and each use takes from it."""

    __slots__ = ("_filled", "_level", "_most", "_rate")

    def __init__(self, rate: float, most: float) -> None:
        """Start full.

        Args:
            rate: Amount that returns each second.
            most: Its capacity.
        """
        self._rate = rate
        self._most = self._level = most
        self._filled = 0.0

    def take(self, amount: float, now: float) -> bool:
        """Take an amount, if it is there."""
        level = min(self._most, self._level + (now - self._filled) * self._rate)
        self._filled = now
        enough = amount <= level
        self._level = level - amount if enough else level
        return enough
