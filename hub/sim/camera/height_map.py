"""The ground of an arena as a camera sees it: columns with level tops, a height for each cell."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.sim.geometry import Surface
from hub.values import dataclass

GROUND_SIDES = 3
"""A surface of the ground is drawn as three things: tops, sides that face x, sides that face y."""
_TONES = (0.94, 1.04, 0.98, 1.08, 0.9)
"""Shares of light on the tops of neighbouring heights, so that steps show."""
_TONE_HEIGHT = 0.05
"""Difference of height from one tone to the next [m]."""
_SLOPE_LIGHT = 0.45
"""Growth of light with the slope toward the light, which comes from the east and the south."""
_SLOPE = 0.6
"""Tangent of a slope beyond which two cells are a step, not a slope."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeightMap:
    """Heights above the floor; cells of height 0 show the floor itself.

    Attributes:
        heights: Height of each cell, 0 or more [m], float32, shape (rows, columns); rows grow
            with y, columns with x.
        cell: Side of a cell [m].
        origin: x and y of the corner with the least of both [m].
        surface: Number of each cell's surface, shape (rows, columns).
        surfaces: The surfaces.
    """

    heights: npt.NDArray[np.float32]
    cell: float
    origin: tuple[float, float]
    surface: npt.NDArray[np.uint8]
    surfaces: tuple[Surface, ...]

    def light(self) -> npt.NDArray[np.float32]:
        """Share of light that each cell gets by its slope and its height, shape (rows, columns)."""
        heights = self.heights
        rows, columns = heights.shape
        light = np.ones((rows, columns), dtype=np.float32)
        steps = np.rint(heights / _TONE_HEIGHT).astype(np.intp) % len(_TONES)
        level = np.ones((rows, columns), dtype=np.bool_)
        for axis, toward in ((0, -1.0), (1, 1.0)):
            if heights.shape[axis] < 2:
                continue
            slope = np.gradient(heights, self.cell, axis=axis)
            slope[np.abs(slope) > _SLOPE] = 0.0
            level &= slope == 0.0
            light -= np.float32(_SLOPE_LIGHT * toward) * slope
        light[level] *= np.array(_TONES, dtype=np.float32)[steps[level]]
        return light
