"""Places in the world, as a viewport shows them."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from hub.gcm.fields import FARTHEST_M, LONGEST_M


class SaidBy(enum.Enum):
    """What says how far away a place is.

    Attributes:
        OPERATOR: Who pointed at it on the map.
        FLOOR: The picture, as it shows floor there.
        MAP: The map, as the line of sight ends at something there.
        RANGES: The range sensors, likewise.
    """

    OPERATOR = "by hand"
    FLOOR = "on the floor"
    MAP = "at a wall of the map"
    RANGES = "at what the sensors see"


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldPoint:
    """A place in the world.

    Attributes:
        x: In `map` [m].
        y: In `map` [m].
        uncertainty: How far off it may be [m], as `hub.gcm.mapping.InterestPoint` means it.
        distance: How far from the robot it was seen [m]; NaN if that is not known.
        height: Above the ground [m].
        said_by: What says how far away it is.
    """

    x: float
    y: float
    uncertainty: float
    distance: float = float("nan")
    height: float = 0.0
    said_by: SaidBy = SaidBy.OPERATOR

    @property
    def sayable(self) -> bool:
        """Whether a message may name it: messages have a range."""
        near = max(abs(self.x), abs(self.y)) <= FARTHEST_M
        return near and not (self.uncertainty > LONGEST_M or self.distance > LONGEST_M)


def metres_text(metres: float, decimals: int) -> str:
    """A length [m] in digits; empty if it is not known."""
    return f"{metres:.{decimals}f}" if math.isfinite(metres) else ""
