"""Lithium batteries that empty with the power taken; pure arithmetic."""

from __future__ import annotations

from hub.values import dataclass

FULL_CELL = 4.2
EMPTY_CELL = 3.3
"""Voltages of a cell at rest [V]; between them it is linear in the charge, our choice."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LithiumBattery:
    """A battery of cells in a row.

    Attributes:
        cells: Number of cells.
        energy: When full [J].
        resistance: Of all cells [ohm].
        fraction: Charge left, 0 to 1.
        power: Power that is taken now [W].
    """

    cells: int
    energy: float
    resistance: float
    fraction: float = 1.0
    power: float = 0.0

    @property
    def voltage(self) -> float:
        """At the terminals, under the present load [V]."""
        resting = self.cells * (EMPTY_CELL + (FULL_CELL - EMPTY_CELL) * self.fraction)
        return resting - self.resistance * self.power / resting

    def after(self, seconds: float, power: float) -> LithiumBattery:
        """The battery after some time [s] at this power [W]."""
        return LithiumBattery(
            cells=self.cells,
            energy=self.energy,
            resistance=self.resistance,
            fraction=max(0.0, self.fraction - power * seconds / self.energy),
            power=power,
        )
