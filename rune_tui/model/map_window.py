"""The part of the world frame `map` that a picture shows, its scale and its direction."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.model.sightings import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class MapWindow:
    """A picture of the ground from above.

    Attributes:
        x: The place in its middle, in `map` [m].
        y: The place in its middle, in `map` [m].
        metres_per_pixel: Its scale; pixels are square.
        width: Its width [px].
        height: Its height [px].
        up: The direction in `map` that is up in it [rad]: a quarter turn for north, the robot's
            heading for a picture that turns with it.
    """

    x: float
    y: float
    metres_per_pixel: float
    width: int
    height: int
    up: float = math.pi / 2.0

    def pixels(self, points: npt.ArrayLike) -> Floats:
        """Pixels of points of `map` [m], x right and y down, shape (..., 2) both."""
        x, y = np.moveaxis(np.asarray(points, np.float64), -1, 0)
        x, y = (x - self.x) / self.metres_per_pixel, (y - self.y) / self.metres_per_pixel
        cos, sin = math.cos(self.up), math.sin(self.up)
        return np.stack(
            (self.width / 2.0 + x * sin - y * cos, self.height / 2.0 - x * cos - y * sin), axis=-1
        )

    def points(self, pixels: npt.ArrayLike) -> Floats:
        """The reverse of `pixels`."""
        column, row = np.moveaxis(np.asarray(pixels, np.float64), -1, 0)
        right = (column - self.width / 2.0) * self.metres_per_pixel
        upward = (self.height / 2.0 - row) * self.metres_per_pixel
        cos, sin = math.cos(self.up), math.sin(self.up)
        return np.stack(
            (self.x + right * sin + upward * cos, self.y - right * cos + upward * sin), axis=-1
        )
