"""An arena as a camera of heat sees it: temperatures in place of colours."""

from __future__ import annotations

import dataclasses

from hub.sim.arena import Arena
from hub.sim.geometry import Box, Colour, Cylinder, Surface

COLDEST_C, WARMEST_C = 10.0, 40.0
"""Temperatures of black and of white [degrees Celsius]."""
_RAMP: tuple[Colour, ...] = ((0, 0, 0), (60, 0, 110), (210, 50, 60), (255, 170, 0), (255, 255, 255))
"""Colours from cold to warm, evenly spaced."""


def in_heat(arena: Arena) -> Arena:
    """The arena in the colours of its temperatures: dark air, bright skin."""
    return dataclasses.replace(
        arena,
        boxes=tuple(map(_box, arena.boxes)),
        waving=tuple(map(_box, arena.waving)),
        cylinders=tuple(map(_cylinder, arena.cylinders)),
        floor=_warm(arena.floor),
        overhead=_warm(arena.overhead),
        light=1.0,
        ground=arena.ground
        and dataclasses.replace(arena.ground, surfaces=tuple(map(_warm, arena.ground.surfaces))),
    )


def heat_colour(temperature: float) -> Colour:
    """The colour of a temperature [degrees Celsius]."""
    share = (temperature - COLDEST_C) / (WARMEST_C - COLDEST_C) * (len(_RAMP) - 1)
    step = min(max(int(share), 0), len(_RAMP) - 2)
    part = min(max(share - step, 0.0), 1.0)
    red, green, blue = (
        round(a + (b - a) * part) for a, b in zip(_RAMP[step], _RAMP[step + 1], strict=True)
    )
    return red, green, blue


def _warm(surface: Surface) -> Surface:
    return dataclasses.replace(surface, texture="plain", colour=heat_colour(surface.temperature))


def _box(box: Box) -> Box:
    picture = None if box.picture is None else _warm(box.picture)
    return dataclasses.replace(box, surface=_warm(box.surface), picture=picture)


def _cylinder(item: Cylinder) -> Cylinder:
    return dataclasses.replace(item, surface=_warm(item.surface))
