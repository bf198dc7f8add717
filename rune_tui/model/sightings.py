"""Results of the geometry of pixels and ground points; NaN where unknown."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.values import dataclass

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundPoints:
    """Points of the ground at pixels.

    Attributes:
        points: In the robot's frame [m], shape (..., 2); NaN where `on_ground` is false.
        on_ground: Whether the pixel is below the horizon, shape (...).
    """

    points: Floats
    on_ground: Bools


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenPoints:
    """Pixels of points.

    Attributes:
        pixels: x and y [px], shape (..., 2); NaN where `in_front` is false.
        in_front: Whether the point is ahead of the camera, shape (...).
        inside: Whether it is within the picture, shape (...).
    """

    pixels: Floats
    in_front: Bools
    inside: Bools


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """The ground that one pixel covers, which is the error of a point.

    Attributes:
        along: Toward and away from the camera [m].
        across: Sideways as seen from the camera [m].
    """

    along: float
    across: float
