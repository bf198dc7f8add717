"""The fluid around a body: still air with drafts and wind, water with a current."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.afloat.attitude import Vector
from hub.values import dataclass

AIR_DENSITY = 1.2
"""[kg/m^3], at 20 degrees Celsius."""
SEA_WATER_DENSITY = 1026.0
"""[kg/m^3], von Benzon et al. 2022."""
DRAFT_MEMORY = 4.0
"""Time over which a draft forgets its speed [s]; our choice."""
VERTICAL_SHARE = 0.5
"""Vertical drafts relative to horizontal ones; our choice."""
AIRLESS_DEPTH = 0.1
"""Propellers in the middle of the robot draw no air below this depth [m]; our choice."""
HULL_HEIGHT = 0.254
"""Height of the underwater robot [m]; as it leaves the water, it displaces less."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Air:
    """The air of a hall.

    Attributes:
        draft: Standard deviation of drafts along x and along y [m/s]: 0.04 in a still room, 0.15
            in a drafty one; rooms have 0.05 to 0.40 m/s (Fanger 1988).
        wind: Steady wind along x and y [m/s].
    """

    draft: float = 0.04
    wind: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Water:
    """The water of a pool.

    Attributes:
        surface: Height of the surface above the pool's floor [m].
        current: Steady current along x and y [m/s].
    """

    surface: float
    current: tuple[float, float] = (0.0, 0.0)

    def submerged(self, height: float) -> float:
        """Share of the robot that is in water, 0 to 1, at the height of its middle [m]."""
        return max(0.0, min(1.0, 0.5 + (self.surface - height) / HULL_HEIGHT))

    def thrust_share(self, height: float) -> float:
        """Share of its thrust that is left, 0 to 1: near the surface propellers draw air."""
        return max(0.0, min(1.0, (self.surface - height) / AIRLESS_DEPTH))


class Drafts:
    """Drafts around a steady wind: an Ornstein-Uhlenbeck process for each axis.

    Attributes:
        flow: The velocity of the air in the world [m/s].
    """

    def __init__(self, air: Air, seed: np.random.SeedSequence) -> None:
        self._random = np.random.default_rng(seed)
        self._wind = (*air.wind, 0.0)
        self._deviations = (air.draft, air.draft, VERTICAL_SHARE * air.draft)
        self._drafts: Vector = (0.0, 0.0, 0.0)
        self.flow: Vector = self._wind

    def advance(self, seconds: float) -> None:
        """Let the drafts change for some time [s]."""
        kept = math.exp(-seconds / DRAFT_MEMORY)
        fresh = math.sqrt(1.0 - kept * kept)
        noise = self._random.standard_normal(3).tolist()
        x, y, z = (
            kept * draft + fresh * deviation * each
            for draft, deviation, each in zip(self._drafts, self._deviations, noise, strict=True)
        )
        self._drafts = (x, y, z)
        self.flow = (self._wind[0] + x, self._wind[1] + y, z)
