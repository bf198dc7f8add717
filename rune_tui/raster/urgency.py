"""Order in which a slow terminal gets the cells."""

from __future__ import annotations

import enum

import numpy as np
import numpy.typing as npt


class Urgency(enum.IntEnum):
    """Content of cells, in the order of sending."""

    ALARM = 0
    """Stops, alarms and questions to the operator."""
    DRIVE = 1
    """Motion of the robot and the source of its commands."""
    RANGES = 2
    """Distances to obstacles."""
    OTHER = 3
    VIDEO = 4
    """A camera's picture, which may be late and coarse."""


Urgencies = npt.NDArray[np.uint8]
"""The urgency of each cell, shape (rows, columns)."""
