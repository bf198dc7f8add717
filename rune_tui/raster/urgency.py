"""What an operator has to see first when a terminal takes little."""

from __future__ import annotations

import enum

import numpy as np
import numpy.typing as npt


class Urgency(enum.IntEnum):
    """What cells show, in the order in which they are sent."""

    ALARM = 0
    """Stops, alarms, and what asks the operator for something."""
    DRIVE = 1
    """How the robot moves and what drives it."""
    RANGES = 2
    """How near things are."""
    OTHER = 3
    VIDEO = 4
    """A camera's picture, which may come late and coarser."""


Urgencies = npt.NDArray[np.uint8]
"""The urgency of each cell, shape (rows, columns)."""
