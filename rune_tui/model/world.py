"""Places in the world, as a viewport shows them."""

from __future__ import annotations

import enum
import math

from hub.gcm.fields import FARTHEST_M, LONGEST_M
from hub.values import dataclass


class DistanceSource(enum.Enum):
    """The source of the distance of a place.

    Attributes:
        OPERATOR: The operator pointed at it on the map.
        FLOOR: The picture shows floor there.
        MAP: The line of sight ends at an obstacle of the map.
        RANGES: The line of sight ends at an obstacle of the range sensors.
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
        uncertainty: Its error [m], as in `hub.gcm.mapping.InterestPoint`.
        distance: Its distance from the robot when it was seen [m]; NaN: not known.
        height: Above the ground [m].
        source: The source of its distance.
    """

    x: float
    y: float
    uncertainty: float
    distance: float = float("nan")
    height: float = 0.0
    source: DistanceSource = DistanceSource.OPERATOR

    @property
    def in_range(self) -> bool:
        """Whether it is in the range of messages."""
        near = max(abs(self.x), abs(self.y)) <= FARTHEST_M
        return near and not (self.uncertainty > LONGEST_M or self.distance > LONGEST_M)


def metres_text(metres: float, decimals: int) -> str:
    """A length [m] in digits; empty: not known."""
    return f"{metres:.{decimals}f}" if math.isfinite(metres) else ""
