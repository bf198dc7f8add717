"""The ranges that an autopilot reports, as the groups of a robot file; pure."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.body import RangeGroup
from hub.robots.mavlink.vehicle.telemetry import Obstacles, Telemetry

_FRESH_S: Final = 1.0
"""Age from which on a range counts as not measured [s]."""


def ranges_of(group: RangeGroup, read: Telemetry, now: float) -> npt.NDArray[np.float32]:
    """What the autopilot says in the directions of a group's beams [m], shape (beams,).

    A sensor ahead fills the beams whose cones look ahead. Directions count from ahead: the frames
    of the groups have the vehicle's own axes.

    Args:
        group: The group.
        read: The vehicle's telemetry.
        now: Monotonic time [s].
    """
    ranges = np.full(group.beams, math.nan, np.float32)
    for place in range(group.beams):
        direction = math.remainder(group.first + group.step * place, math.tau)
        if read.obstacles is not None and now - read.obstacles_at <= _FRESH_S:
            ranges[place] = _obstacle(read.obstacles, direction)
        elif (
            now - read.ahead_at <= _FRESH_S
            and abs(direction) <= max(group.opening, abs(group.step)) / 2.0 + 1e-9
        ):
            ranges[place] = read.ahead
    return ranges


def _obstacle(obstacles: Obstacles, direction: float) -> float:
    """What the sector of a direction says [m]; NaN: there is none."""
    turned = (direction - obstacles.first) * math.copysign(1.0, obstacles.step) % math.tau
    size = abs(obstacles.step)
    sector = round(turned / size)
    if sector >= len(obstacles.distances) and math.tau - turned <= size / 2.0:
        sector = 0
    return obstacles.distances[sector] if sector < len(obstacles.distances) else math.nan
