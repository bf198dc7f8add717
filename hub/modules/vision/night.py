"""Night mode: the gain of pictures, and the headlight; pure."""

from __future__ import annotations

import math

from hub.gcm.vision import NightCommand

MOST_GAIN = 16.0
"""Largest gain; above it, only noise gets brighter."""
WANTED_BRIGHTNESS = 90.0
"""Mean brightness of pictures with gain, of 255."""
SMOOTHING_S = 0.4
"""Time constant of the gain [s], so that pictures do not flicker."""
_DARKEST = 0.25
"""Below this mean brightness a picture counts as black."""


class NightMode:
    """The state of night mode and its gain.

    Attributes:
        gain: Factor of the brightness; 1: unchanged.
    """

    def __init__(self) -> None:
        self._on = False
        self._wanted = 1.0
        self._lit = 0.0
        self._seen = -math.inf
        self.gain = 1.0

    @property
    def headlight(self) -> float:
        """Brightness of the headlight now, 0 (off) to 1."""
        return self._lit

    def command(self, command: NightCommand) -> None:
        """Switch night mode on or off, and set the brightness of the headlight."""
        self._on = command.on != 0
        # The zeros in a command to switch off are no setting for the next time.
        if self._on and not math.isnan(command.headlight):
            self._wanted = max(0.0, min(1.0, command.headlight))
        self._lit = self._wanted if self._on else 0.0
        if not self._on:
            self.gain = 1.0
            self._seen = -math.inf

    def light(self, brightness: float) -> None:
        """Set the headlight alone, 0 (off) to 1; night mode stays as it is."""
        self._lit = max(0.0, min(1.0, brightness))
        if self._lit > 0.0:
            self._wanted = self._lit

    def see(self, brightness: float, now: float) -> float:
        """The gain for a picture with this mean brightness (0 to 255) at `now` [s]."""
        if self._on:
            self.gain = next_gain(self.gain, brightness, now - self._seen)
            self._seen = now
        return self.gain


def next_gain(gain: float, brightness: float, seconds: float) -> float:
    """The gain for the next picture, 1 to MOST_GAIN.

    The logarithm of the gain approaches its target exponentially in time, so the rate of pictures
    does not matter.

    Args:
        gain: Of the picture before.
        brightness: Mean of the new picture before the gain, 0 to 255.
        seconds: Time between the two [s].
    """
    wanted = WANTED_BRIGHTNESS / max(_DARKEST, brightness)
    wanted = max(1.0, min(MOST_GAIN, wanted))
    way = -math.expm1(-max(0.0, seconds) / SMOOTHING_S)
    return max(1.0, min(MOST_GAIN, gain * math.pow(wanted / gain, way)))
