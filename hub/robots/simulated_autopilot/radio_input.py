"""The radio channels of a simulated autopilot; pure.

| event | channels |
| --- | --- |
| a frame of the receiver | those that a station overrides have its values, the others the middle |
| no receiver, a new override | the overridden ones have the new values, the others stay |
| no receiver, no new override | all stay: an override that expired changes nothing |
"""

from __future__ import annotations

from typing import Final

MIDDLE_US: Final = 1500
CHANNELS: Final = 8
_LEAVE: Final = 65535


class RadioInput:
    """Channels 1 to 8 [us].

    Attributes:
        channels: The present values.
        heard: Monotonic time of the last frame or new override [s].
    """

    def __init__(self, now: float) -> None:
        self.channels = [MIDDLE_US] * CHANNELS
        self.heard = now
        self._overrides = [(0, 0.0)] * CHANNELS
        self._new = False

    def override(self, channel: int, value: int, now: float) -> None:
        """Override a channel, counted from 1; 0 releases it, and 65535 leaves it as it is."""
        if 1 <= channel <= CHANNELS and value != _LEAVE:
            self._overrides[channel - 1] = value, now
            self._new = True

    def overridden(self, now: float, lasting: float) -> bool:
        """Whether any override is valid; they last for a time [s], and below 0 without an end."""
        return any(_valid(each, now, lasting) for each in self._overrides)

    def release(self) -> None:
        """End all overrides."""
        self._overrides = [(0, 0.0)] * CHANNELS

    def center(self) -> None:
        """Set all channels to the middle, until the next frame."""
        self.channels = [MIDDLE_US] * CHANNELS

    def step(self, now: float, lasting: float, *, receiver: bool) -> bool:
        """Read the channels; returns whether there was anything new.

        Args:
            now: Monotonic time [s].
            lasting: Time for which an override is valid [s].
            receiver: Whether a receiver sends frames.
        """
        if not (receiver or self._new):
            return False
        self._new = False
        self.heard = now
        for place, override in enumerate(self._overrides):
            if _valid(override, now, lasting):
                self.channels[place] = override[0]
            elif receiver:
                self.channels[place] = MIDDLE_US
        return True

    def share(self, channel: int, dead: float, travel: float = 500.0) -> float:
        """Deflection of a channel, -1 to 1, without its dead zone [us]; 0: there is none."""
        if not 1 <= channel <= CHANNELS or travel <= dead:
            return 0.0
        off = self.channels[channel - 1] - MIDDLE_US
        beyond = max(0.0, abs(off) - dead) / (travel - dead)
        return min(1.0, beyond) * (1.0 if off > 0 else -1.0)


def _valid(override: tuple[int, float], now: float, lasting: float) -> bool:
    value, since = override
    return value != 0 and (lasting < 0.0 or now - since < lasting)
