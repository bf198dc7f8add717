"""Distances from many points at once to what stands in an arena."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Footprints

Floats = npt.NDArray[np.float64]


def distances(footprints: Footprints, x: Floats, y: Floats) -> Floats:
    """From each point to the nearest thing [m], of the shape of `x` and `y`; 0: inside of it."""
    nearest = np.full(x.shape, np.inf)
    for low, high in zip(footprints.low, footprints.high, strict=True):
        across = np.maximum(np.maximum(low[0] - x, x - high[0]), 0.0)
        along = np.maximum(np.maximum(low[1] - y, y - high[1]), 0.0)
        nearest = np.minimum(nearest, np.hypot(across, along))
    for centre, radius in zip(footprints.centre, footprints.radius, strict=True):
        nearest = np.minimum(nearest, np.hypot(x - centre[0], y - centre[1]) - radius)
    return np.maximum(nearest, 0.0)
