"""Places in the world, as a viewport shows them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldPoint:
    """A place on the ground.

    Attributes:
        x: In `map` [m].
        y: In `map` [m].
        uncertainty: How far off it may be [m].
        distance: How far from the robot it was seen [m]; NaN if that is not known.
    """

    x: float
    y: float
    uncertainty: float
    distance: float = float("nan")
