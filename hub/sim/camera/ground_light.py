"""The light on each cell of rough ground: by its slope, and on level ground by its height."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

_TONES = (0.94, 1.04, 0.98, 1.08, 0.9)
"""Shares of light on the tops of neighbouring heights, so that steps show."""
_TONE_HEIGHT = 0.05
"""Difference of height from one tone to the next [m]."""
_SLOPE_LIGHT = 0.45
"""Growth of light with the slope toward the light, which comes from the east and the north."""
_SLOPE = 0.6
"""Tangent of a slope beyond which two cells are a step, not a slope."""


def ground_light(heights: npt.NDArray[np.float32], cell: float) -> npt.NDArray[np.float32]:
    """Share of light that each cell gets, shape (rows, columns).

    Args:
        heights: Height of each cell [m], shape (rows, columns).
        cell: Side of a cell [m].
    """
    light = np.ones(heights.shape, dtype=np.float32)
    level = np.ones(heights.shape, dtype=np.bool_)
    for axis in (0, 1):
        if heights.shape[axis] < 2:
            continue
        slope = np.gradient(heights, cell, axis=axis)
        slope[np.abs(slope) > _SLOPE] = 0.0
        level &= slope == 0.0
        light -= np.float32(_SLOPE_LIGHT) * slope
    steps = np.rint(heights / _TONE_HEIGHT).astype(np.intp) % len(_TONES)
    light[level] *= np.array(_TONES, dtype=np.float32)[steps[level]]
    return light
