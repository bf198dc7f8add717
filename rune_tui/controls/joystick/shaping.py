"""From the raw numbers of an axis to -1..1: range, rest, dead zone, saturation, expo; pure."""

from __future__ import annotations

import math

from hub.values import dataclass

DEAD_ZONE = 0.10
"""Default dead zone of an axis without calibration; worn pads rest up to 0.13 off the centre."""
CALIBRATED_DEAD_ZONE = 0.05
LEVER_DEAD_ZONE = 0.05
"""Default dead zone of an axis that rests at one end: triggers and levers."""
SATURATION = 0.02
"""How much short of its end an axis counts as fully moved."""
STICK_EXPO = 0.3
LARGEST_REST = 0.25
"""Largest offset of an axis at the start that counts as its rest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisRange:
    """The raw numbers of an axis [device units]; low <= rest_low <= rest_high <= high.

    From `rest_low` to `rest_high` the axis rests. If the rest was measured once only, they are
    that number and the middle of the range: if a hand held it then, it still rests when released.

    Attributes:
        low: The least.
        rest_low: The least at rest; `low` for an axis that rests at its lower end.
        rest_high: The largest at rest.
        high: The largest.
    """

    low: float
    rest_low: float
    rest_high: float
    high: float

    @classmethod
    def centred(cls, low: float, high: float) -> AxisRange:
        """That of an axis that rests in the middle."""
        middle = (low + high) / 2.0
        return cls(low=low, rest_low=middle, rest_high=middle, high=high)

    @classmethod
    def lever(cls, low: float, high: float, *, down: bool = False) -> AxisRange:
        """That of an axis that rests at its lower end, or at its upper if `down`."""
        rest = high if down else low
        return cls(low=low, rest_low=rest, rest_high=rest, high=high)

    def resting_at(self, raw: float) -> AxisRange:
        """This range, with the first number of the axis as its rest, if that is near the middle.

        Not for levers, which may rest anywhere.
        """
        raw = min(max(raw, self.low), self.high)
        if abs(self.share(raw)) > LARGEST_REST:
            return self
        return AxisRange(
            low=self.low,
            rest_low=min(self.rest_low, raw),
            rest_high=max(self.rest_high, raw),
            high=self.high,
        )

    def share(self, raw: float) -> float:
        """Its deflection, -1 to 1; each side by its own length."""
        if raw < self.rest_low:
            return max(-1.0, (raw - self.rest_low) / (self.rest_low - self.low or math.inf))
        if raw > self.rest_high:
            return min(1.0, (raw - self.rest_high) / (self.high - self.rest_high or math.inf))
        return 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """The shaping of the position of an axis, as a share of its range.

    Attributes:
        inverted: Whether the sign is inverted.
        dead_zone: Shares up to this count as rest.
        expo: Weight of x^3 in the curve, 0 to 1; 0 is a straight line.
        saturation: Distance from its end at which it counts as fully moved.
    """

    inverted: bool = False
    dead_zone: float = DEAD_ZONE
    expo: float = STICK_EXPO
    saturation: float = SATURATION

    def turned(self, share: float) -> float:
        """A share with the layout's sign."""
        return -share if self.inverted else share

    def shaped(self, share: float) -> float:
        """A share, already turned, beyond the dead zone and on the curve, -1 to 1."""
        return self.curved(math.copysign(self._beyond_rest(abs(share)), share))

    def shaped_pair(self, x: float, y: float) -> tuple[float, float]:
        """Shares of a stick's two axes; the dead zone is a circle, so no direction sticks."""
        far = math.hypot(x, y)
        if far <= self.dead_zone:
            return 0.0, 0.0
        scale = self._beyond_rest(far) / far
        return self.curved(x * scale), self.curved(y * scale)

    def curved(self, moved: float) -> float:
        """On the curve `expo * x^3 + (1 - expo) * x`, -1 to 1."""
        moved = max(-1.0, min(1.0, moved))
        return self.expo * moved**3 + (1.0 - self.expo) * moved

    def _beyond_rest(self, far: float) -> float:
        """0 up to the dead zone, 1 where it counts as fully moved; more beyond it."""
        room = 1.0 - self.dead_zone - self.saturation
        return max(0.0, far - self.dead_zone) / max(room, 1e-6)
