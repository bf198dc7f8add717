"""A number that was found in data, with its interval, or the reason why there is none."""

from __future__ import annotations

import dataclasses
import math

from hub.values import dataclass

LEVEL = 0.95
"""Confidence level of all intervals that do not name another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A number that was found in data, or the reason why it cannot be known.

    Attributes:
        value: The number; NaN where there is none. Infinity is a number: "never".
        low: Lower end of its interval; NaN: it has none.
        high: Upper end of its interval; NaN: it has none.
        n: Observations that it stands on.
        why: Why there is no number; empty where there is one.
        censored: Whether the value is only a bound: the event was not seen up to then.
        note: What a reader must know beside it, such as the bound of a restricted mean.
    """

    value: float
    low: float = math.nan
    high: float = math.nan
    n: int = 0
    censored: bool = False
    why: str = ""
    note: str = ""

    @property
    def known(self) -> bool:
        """Whether there is a number."""
        return not self.why

    @property
    def has_interval(self) -> bool:
        """Whether there is a number with an interval."""
        return self.known and not (math.isnan(self.low) or math.isnan(self.high))


def unknown(why: str, n: int = 0) -> Estimate:
    """An estimate without a number.

    Args:
        why: The reason, as the end of a sentence: "no victim is known".
        n: Observations there are.
    """
    return Estimate(value=math.nan, n=n, why=why)


def within(estimate: Estimate, least: float, most: float) -> Estimate:
    """An estimate whose interval ends where the number does; a note says so.

    Args:
        estimate: The number, with its interval.
        least: Smallest number that it can be.
        most: Largest number that it can be.
    """
    low, high = max(estimate.low, least), min(estimate.high, most)
    if not estimate.has_interval or (low, high) == (estimate.low, estimate.high):
        return estimate
    ends = [f"{least:g}"] if estimate.low < least else []
    ends += [f"{most:g}"] if estimate.high > most else []
    note = f"its interval is cut at {' and '.join(ends)}, the limit of what it can be"
    notes = "; ".join(filter(None, (estimate.note, note)))
    return dataclasses.replace(estimate, low=low, high=high, note=notes)
