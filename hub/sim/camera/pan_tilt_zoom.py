"""A pan/tilt/zoom head within the limits of its camera, as fast as that of the Sony EVI-D30."""

from __future__ import annotations

import math

PAN_SPEED = math.radians(80.0)
TILT_SPEED = math.radians(50.0)
ZOOM_SPEED = 0.5
"""Zoom from wide to tele takes 2 s [1/s]."""

_SPEED = (PAN_SPEED, TILT_SPEED, ZOOM_SPEED)


def horizontal_fov(zoom: float, wide: float, tele: float) -> float:
    """Field of view from left to right at a zoom of 0 to 1, linear between the two ends [rad]."""
    return wide + (tele - wide) * zoom


class PanTiltZoom:
    """The position and the target of the head: pan [rad], tilt [rad], zoom [0 to 1]."""

    def __init__(
        self,
        pan_limit: float,
        tilt_lowest: float,
        tilt_highest: float,
        *,
        zooms: bool = True,
    ) -> None:
        """Look straight ahead.

        Args:
            pan_limit: Largest pan to either side [rad].
            tilt_lowest: Lowest tilt [rad].
            tilt_highest: Highest tilt [rad].
            zooms: Whether it has a zoom.
        """
        self._low = (-pan_limit, tilt_lowest, 0.0)
        self._high = (pan_limit, tilt_highest, 1.0 if zooms else 0.0)
        self._now = [0.0, 0.0, 0.0]
        self._goal = [0.0, 0.0, 0.0]

    @property
    def pan(self) -> float:
        """Angle from straight ahead [rad], positive left."""
        return self._now[0]

    @property
    def tilt(self) -> float:
        """Angle from the horizontal [rad], positive up."""
        return self._now[1]

    @property
    def zoom(self) -> float:
        """0 (wide) to 1 (tele)."""
        return self._now[2]

    @property
    def slewing(self) -> bool:
        """Whether it still moves to where it was sent."""
        return self._now != self._goal

    def go_to(self, pan: float, tilt: float, zoom: float) -> None:
        """Set the target, within the limits; NaN leaves an amount unchanged."""
        wanted = (pan, tilt, zoom)
        self._goal = [
            old if math.isnan(new) else max(low, min(high, new))
            for old, new, low, high in zip(self._goal, wanted, self._low, self._high, strict=True)
        ]

    def go_by(self, pan: float, tilt: float, zoom: float) -> None:
        """Go on by these amounts from where it was last sent, so that quick presses add up."""
        self.go_to(*(goal + by for goal, by in zip(self._goal, (pan, tilt, zoom), strict=True)))

    def advance(self, seconds: float) -> None:
        """Move for some time [s]."""
        for index, (now, goal, speed) in enumerate(zip(self._now, self._goal, _SPEED, strict=True)):
            way = speed * max(0.0, seconds)
            self._now[index] = (
                goal if abs(goal - now) <= way else now + math.copysign(way, goal - now)
            )
