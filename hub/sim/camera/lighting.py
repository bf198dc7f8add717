"""Light in an arena: ambient light, and the headlight beside the camera."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.sim.camera.view import CameraFrame
from hub.values import dataclass

_LAMP = 0.9
"""Light of the full headlight on very near surfaces, as a share of full daylight."""
_HALF_DISTANCE = 2.0
"""Distance at which half of the headlight's light is left [m]."""
_SPREAD = 0.6
"""Tangent of the angle from the middle of the beam at which half of the light is left."""
_MOST = 1.2
"""Share of light beyond which nothing gets brighter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lighting:
    """The light in a picture.

    Attributes:
        ambient: Light that is everywhere, 0 (none) to 1.
        headlight: Brightness of the headlight, 0 (off) to 1; it has the camera's direction.
    """

    ambient: float = 1.0
    headlight: float = 0.0

    @property
    def plain(self) -> bool:
        """Whether everything is lit fully and alike."""
        return self.ambient == 1.0 and self.headlight == 0.0

    def share(self, frame: CameraFrame, depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Share of full light that each pixel's thing gets, shape (height, width).

        Args:
            frame: The aimed camera.
            depth: Distance along the optical axis [m], shape (height, width).
        """
        if self.headlight == 0.0:
            return np.full_like(depth, self.ambient)
        # A ray is (across, up, 1), so its squared length is 1 + aside.
        aside = (frame.across**2).astype(np.float32) + (frame.up**2).astype(np.float32)[:, None]
        share = np.square(depth)
        share *= 1.0 + aside
        share *= 1.0 / _HALF_DISTANCE**2
        share += 1.0
        aside *= 1.0 / _SPREAD**2
        aside += 1.0
        share *= aside
        np.divide(_LAMP * self.headlight, share, out=share)
        share += self.ambient
        return np.minimum(share, _MOST, out=share)


FULL = Lighting()
"""Daylight."""
