"""Sound and carbon dioxide of victims where a robot is; pure.

Both fall with the square of the distance. Solids between them damp the sound and keep breath back.
"""

from __future__ import annotations

import math

import numpy as np

from hub.sim.arena import Arena
from hub.sim.solids import solids_of

QUIET_DB = 35.0
"""Sound of a quiet room [dB]."""
FRESH_PPM = 420.0
"""Carbon dioxide of fresh air [ppm]."""
WALL_DB = 20.0
"""Sound that a solid between takes away [dB]."""
MOST_PPM = 40_000.0
"""Carbon dioxide of breath itself [ppm]."""
_NEAREST = 0.1
"""Nearer than this neither grows further [m]."""
_OWN = 0.5
"""What the line to a mouth meets this near to it is the victim itself [m]."""


class VictimSenses:
    """A microphone and a sensor of carbon dioxide among the victims of an arena."""

    def __init__(self, arena: Arena) -> None:
        self._victims = arena.victims
        self._solids = solids_of(arena)

    def at(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Sound level [dB] and carbon dioxide [ppm] at a place [m]."""
        power, co2 = 10.0 ** (QUIET_DB / 10.0), FRESH_PPM
        for victim in self._victims:
            way = np.array((victim.x - x, victim.y - y, victim.z - z))
            away = max(float(np.linalg.norm(way)), _NEAREST)
            hit, _ = self._solids.hits(np.array([(x, y, z)]), way[None] / away)
            is_hidden = bool(hit[0] < away - _OWN)
            if victim.sound:
                level = victim.sound - 20.0 * math.log10(away) - WALL_DB * is_hidden
                power += 10.0 ** (level / 10.0)
            if not is_hidden:
                co2 += victim.co2 / (away * away)
        return 10.0 * math.log10(power), min(co2, MOST_PPM)
