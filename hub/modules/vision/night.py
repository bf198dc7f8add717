"""Seeing in the dark: how much pictures are brightened, and the headlight; pure."""

from __future__ import annotations

import math

from hub.gcm.vision import NightCommand

MOST_GAIN = 16.0
"""Brighter than this, noise is all that comes out."""
WANTED_BRIGHTNESS = 90.0
"""Mean brightness that pictures are brought to, of 255."""
SMOOTHING_S = 0.4
"""Time in which the gain goes two thirds of its way [s], so that pictures do not flicker."""
_DARKEST = 0.25
"""Below this mean brightness a picture counts as black."""


class NightMode:
    """Whether pictures are brightened, and how much; every method is told what it has to know.

    Attributes:
        gain: How much brighter pictures are made than they come; 1 as they come.
    """

    def __init__(self) -> None:
        self._on = False
        self._headlight = 1.0
        self._seen = -math.inf
        self.gain = 1.0

    @property
    def headlight(self) -> float:
        """How bright the headlight shall be now, 0 (off) to 1."""
        return self._headlight if self._on else 0.0

    def command(self, command: NightCommand) -> None:
        """Somebody switches it on, and may choose the headlight's brightness, or off."""
        self._on = command.on != 0
        # Who switches it off and leaves zero in the rest does not mean the next time.
        if self._on and not math.isnan(command.headlight):
            self._headlight = max(0.0, min(1.0, command.headlight))
        if not self._on:
            self.gain = 1.0
            self._seen = -math.inf

    def see(self, brightness: float, now: float) -> float:
        """The gain for a picture that comes with this mean brightness (0 to 255) at `now` [s]."""
        if self._on:
            self.gain = next_gain(self.gain, brightness, now - self._seen)
            self._seen = now
        return self.gain


def next_gain(gain: float, brightness: float, seconds: float) -> float:
    """The gain for the next picture, 1 to MOST_GAIN.

    The way from one gain to another is even in ratios, as eyes see it, and exponential in time, so
    that it does not matter how often pictures are taken.

    Args:
        gain: Of the picture before.
        brightness: Mean of the picture as it comes, 0 to 255.
        seconds: Time between the two [s].
    """
    wanted = WANTED_BRIGHTNESS / max(_DARKEST, brightness)
    wanted = max(1.0, min(MOST_GAIN, wanted))
    way = -math.expm1(-max(0.0, seconds) / SMOOTHING_S)
    return max(1.0, min(MOST_GAIN, gain * math.pow(wanted / gain, way)))
