"""The ground that a round body covers at constant velocities."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from rune_tui.model.sightings import Floats

_STEP: Final = math.radians(4.0)
"""Change of heading between corners of a drawn arc [rad]."""
_TURN: Final = 2.0 * math.pi


def swept_edges(
    radius: float, linear: float, angular: float, seconds: float
) -> tuple[Floats, Floats]:
    """The paths of the leftmost and the rightmost point of the body.

    A body with constant velocities drives a circular arc or a straight line. Its chord has a
    closed form (Thrun, Burgard, Fox: Probabilistic Robotics, 5.3). The path ends after a full
    turn, because it repeats.

    Args:
        radius: Of the body [m].
        linear: Velocity forward [m/s]; negative backwards, 0 on the spot.
        angular: Turn rate [rad/s], counter-clockwise.
        seconds: Duration of the motion [s].

    Returns:
        The left and the right edge in the robot's frame now [m], each of shape (n, 2), n >= 2,
        in the order of time.
    """
    turned = angular * seconds
    share = min(1.0, _TURN / abs(turned)) if turned else 1.0
    count = max(2, math.ceil(abs(turned * share) / _STEP) + 1)
    time = np.linspace(0.0, seconds * share, count)
    half = angular * time / 2.0
    # numpy's sinc(x) is sin(pi x) / (pi x): the chord over the arc.
    chord = linear * time * np.sinc(half / math.pi)
    centre = np.stack((chord * np.cos(half), chord * np.sin(half)), axis=1)
    beside = radius * np.stack((-np.sin(2.0 * half), np.cos(2.0 * half)), axis=1)
    return centre + beside, centre - beside
