"""A number that was found in data, with its interval, or the reason why there is none."""

from __future__ import annotations

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
