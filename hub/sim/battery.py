"""A lead-acid battery that empties with time and load; pure arithmetic."""

from __future__ import annotations

from hub.values import dataclass

CAPACITY = 7.2 * 3600.0
"""Charge of the full battery [A s]."""
IDLE_CURRENT = 1.5
"""Current of computer and sensors [A]."""
CURRENT_PER_SPEED = 4.0
"""Current of driving [A per m/s]."""
CURRENT_PER_TURN_RATE = 1.0
"""Current of turning [A per rad/s]."""
FULL_VOLTAGE = 25.4
EMPTY_VOLTAGE = 22.0
RESISTANCE = 0.12
"""Inner resistance [ohm]."""


@dataclass(frozen=True, slots=True)
class Battery:
    """Two 12 V lead-acid batteries in a row.

    Attributes:
        fraction: Charge left, 0 to 1.
        voltage: At the terminals, under the present load [V].
    """

    fraction: float = 1.0
    voltage: float = FULL_VOLTAGE - IDLE_CURRENT * RESISTANCE

    def after(self, seconds: float, linear: float, angular: float) -> Battery:
        """The battery after some time [s] at these velocities [m/s, rad/s]."""
        current = (
            IDLE_CURRENT + CURRENT_PER_SPEED * abs(linear) + CURRENT_PER_TURN_RATE * abs(angular)
        )
        fraction = max(0.0, self.fraction - current * seconds / CAPACITY)
        resting = EMPTY_VOLTAGE + (FULL_VOLTAGE - EMPTY_VOLTAGE) * fraction
        return Battery(fraction, resting - current * RESISTANCE)
