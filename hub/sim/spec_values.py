"""Values that several tables of an arena file share: colours, textures, directions, places."""

from __future__ import annotations

import re
from collections.abc import Mapping

from hub.nearest import did_you_mean
from hub.sim.geometry import Colour, Side
from hub.toml_reader import RefusedError, shorten

COLOURS: Mapping[str, Colour] = {
    "white": (236, 236, 230),
    "grey": (150, 150, 150),
    "black": (32, 32, 34),
    "red": (214, 40, 40),
    "orange": (240, 130, 20),
    "yellow": (240, 208, 40),
    "green": (40, 160, 72),
    "cyan": (40, 180, 200),
    "blue": (40, 86, 208),
    "violet": (134, 62, 190),
    "pink": (232, 110, 170),
    "brown": (140, 94, 56),
    "sand": (208, 186, 144),
    "brick": (176, 92, 70),
    "slate": (104, 116, 130),
}
SURFACE_TEXTURES = ("plain", "brick", "panel", "wood", "concrete", "fabric", "checker")
FACINGS = {side.name.lower(): side for side in (Side.EAST, Side.NORTH, Side.WEST, Side.SOUTH)}

Point = tuple[float, float]

FARTHEST = 50.0
"""Largest distance from the origin in x or y [m]."""


def read_colour(value: object) -> Colour:
    """Read the name of a colour, or "#rrggbb"."""
    if isinstance(value, str) and re.fullmatch("#[0-9a-fA-F]{6}", value):
        red, green, blue = bytes.fromhex(value[1:])
        return red, green, blue
    if isinstance(value, str) and value in COLOURS:
        return COLOURS[value]
    hint = did_you_mean(value, COLOURS)
    reason = f"{shorten(value)} is neither '#rrggbb' nor one of {', '.join(COLOURS)}{hint}"
    raise RefusedError(reason)
