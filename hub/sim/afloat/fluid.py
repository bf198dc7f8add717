"""The fluid around a body: air with drafts and wind, water with a surface."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.afloat.attitude import Vector
from hub.sim.arena_specs import AirSpec
from hub.sim.steps import GRAVITY

AIR_DENSITY = 1.2
"""[kg/m^3], at 20 degrees Celsius."""
AIR_PRESSURE = 101_325.0
"""[Pa], the standard atmosphere."""
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


def pressure_at(depth: float) -> float:
    """The pressure in the sea at a depth [m], in Pa."""
    return AIR_PRESSURE + SEA_WATER_DENSITY * GRAVITY * depth


def submerged(depth: float) -> float:
    """Share of the underwater robot that is in water, 0 to 1, at the depth of its middle [m]."""
    return max(0.0, min(1.0, 0.5 + depth / HULL_HEIGHT))


def thrust_share(depth: float) -> float:
    """Share of its thrust that is left, 0 to 1: near the surface propellers draw air."""
    return max(0.0, min(1.0, depth / AIRLESS_DEPTH))


class Drafts:
    """Drafts around a steady wind: an Ornstein-Uhlenbeck process for each axis.

    Attributes:
        flow: The velocity of the air in the world [m/s].
    """

    def __init__(self, air: AirSpec, seed: np.random.SeedSequence) -> None:
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
