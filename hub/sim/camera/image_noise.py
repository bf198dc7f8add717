"""Noise of a camera's sensor, drawn once, with a new crop for every picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

DEVIATION = 1.5
"""Standard deviation of each value [of 255 levels]."""


class SensorNoise:
    """Adds noise to pictures; the same seed gives the same noise in the same order."""

    def __init__(self, largest: int, seed: int) -> None:
        """Draw it.

        Args:
            largest: Values of the largest picture: width times height times 3.
            seed: Of the noise.
        """
        self._random = np.random.default_rng(seed)
        drawn = self._random.normal(0.0, DEVIATION, 2 * largest)
        self._noise = np.rint(drawn).astype(np.int16)

    def added(self, pixels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        """The picture with noise, in the same shape."""
        start = int(self._random.integers(len(self._noise) - pixels.size + 1))
        noisy = self._noise[start : start + pixels.size].reshape(pixels.shape) + pixels
        return np.clip(noisy, 0, 255, out=noisy).astype(np.uint8)
