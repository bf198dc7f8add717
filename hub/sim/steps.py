"""What all simulated bodies share: time in whole steps, and gravity; pure."""

from __future__ import annotations

GRAVITY = 9.81
"""[m/s^2]."""
LONGEST_ADVANCE = 5.0
"""Longest advance of one call [s]; more is dropped, for example after a suspended process."""
_ROUNDING = 1e-9


class WholeSteps:
    """Divides time into steps of one length; what is left over counts in the next call."""

    def __init__(self, length: float) -> None:
        """Start with no time left over.

        Args:
            length: Length of a step [s].
        """
        self._length = length
        self._left = 0.0

    def due(self, seconds: float) -> int:
        """Number of steps to make for more time [s]."""
        if not seconds > 0.0:
            return 0
        self._left += min(seconds, LONGEST_ADVANCE)
        steps = 0
        while self._left >= self._length - _ROUNDING:
            self._left -= self._length
            steps += 1
        return steps
