"""Places in the world, as a viewport shows them."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldPoint:
    """A place on the ground.

    Attributes:
        x: In `map` [m].
        y: In `map` [m].
        uncertainty: How far off it may be [m], as `hub.gcm.mapping.InterestPoint` means it.
        distance: How far from the robot it was seen [m]; NaN if that is not known.
    """

    x: float
    y: float
    uncertainty: float
    distance: float = float("nan")


def metres_text(metres: float, decimals: int) -> str:
    """A length [m] in digits; empty if it is not known."""
    return f"{metres:.{decimals}f}" if math.isfinite(metres) else ""
