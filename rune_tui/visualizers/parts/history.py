"""A number of a message by its path, and its history in bounded memory."""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Iterator
from dataclasses import fields
from typing import Self

import numpy as np

from hub.values import dataclass

SLOTS = 1024
"""Number of slots of the kept time; few terminals have more columns."""

_PLAIN = (int, float, np.number, np.bool_)


def number_at(value: object, path: str) -> float | None:
    """The number at a path such as `linear`, `scans[0].ranges[3]` or `points[2].x`; None: none."""
    found = value
    for step in path.replace("[", ".[").split("."):
        found = _element(found, step) if step.startswith("[") else _field(found, step)
    return float(found) if isinstance(found, _PLAIN) else None


def _field(value: object, name: str) -> object:
    if not dataclasses.is_dataclass(value) or name not in {f.name for f in fields(value)}:
        return None
    return getattr(value, name)


def _element(value: object, step: str) -> object:
    digits = step[1:-1]
    if not (isinstance(value, tuple | np.ndarray) and step.endswith("]") and digits.isdecimal()):
        return None
    return value[int(digits)] if int(digits) < len(value) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """The values of a number during a short time.

    Attributes:
        begin: When the first value of it was measured, on the console's monotonic clock [s].
        end: When the last one was.
        first: The first value.
        last: The last one.
        low: The lowest.
        high: The highest.
        joined: Whether there is no gap before this slot.
    """

    begin: float
    end: float
    first: float
    last: float
    low: float
    high: float
    joined: bool


class History:
    """The newest seconds of a number."""

    def __init__(self, seconds: float, gap: float) -> None:
        """Prepare.

        Args:
            seconds: Length of the history [s].
            gap: Least time between two values that makes a gap [s].
        """
        self._seconds = seconds
        self._gap = gap
        self._slots: deque[Slot] = deque(maxlen=SLOTS)
        self._broken = False
        self.count = 0
        """Number of values so far."""

    def __copy__(self) -> Self:
        """A history with the same values, which grows by itself."""
        twin = object.__new__(type(self))
        vars(twin).update(vars(self), _slots=self._slots.copy())
        return twin

    def add(self, when: float, value: float) -> None:
        """Add a value; one that is not finite leaves a gap."""
        self.count += 1
        if not math.isfinite(value):
            self._broken = True
            return
        newest = self._slots[-1] if self._slots else None
        joined = newest is not None and not self._broken and 0.0 <= when - newest.end <= self._gap
        self._broken = False
        if newest is not None and joined and self._place(newest.begin) == self._place(when):
            self._slots[-1] = dataclasses.replace(
                newest,
                end=when,
                last=value,
                low=min(newest.low, value),
                high=max(newest.high, value),
            )
            return
        self._slots.append(
            Slot(
                begin=when,
                end=when,
                first=value,
                last=value,
                low=value,
                high=value,
                joined=joined,
            )
        )

    def since(self, when: float) -> Iterator[Slot]:
        """All slots from this time on [s]."""
        return (slot for slot in self._slots if slot.end >= when)

    def _place(self, when: float) -> int:
        return int(when * SLOTS / self._seconds)
