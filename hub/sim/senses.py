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
        here = np.array((x, y, z))
        mouths = np.array([(each.x, each.y, each.z) for each in self._victims]).reshape(-1, 3)
        ways = mouths - here
        away = np.maximum(np.linalg.norm(ways, axis=1), _NEAREST)
        hit, _ = self._solids.hits(np.broadcast_to(here, ways.shape), ways / away[:, None])
        hidden = hit < away - _OWN
        for victim, far, is_hidden in zip(
            self._victims, away.tolist(), hidden.tolist(), strict=True
        ):
            if victim.sound:
                level = victim.sound - 20.0 * math.log10(far) - WALL_DB * is_hidden
                power += 10.0 ** (level / 10.0)
            if not is_hidden:
                co2 += victim.co2 / (far * far)
        return 10.0 * math.log10(power), min(co2, MOST_PPM)
