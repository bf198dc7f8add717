"""A height map with a ramp, posts, a hill and stairs, made without tables of a file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Arena
from hub.sim.geometry import Surface
from hub.sim.ground.height_field import HeightField

CELL = 0.025
SURFACES = (
    Surface(texture="checker", colour=(150, 150, 150)),
    Surface(texture="wood", colour=(200, 150, 90)),
    Surface(texture="plain", colour=(190, 150, 100)),
    Surface(texture="concrete", colour=(150, 150, 160)),
)


def on(ground: HeightField, arena: Arena) -> Arena:
    """The arena with this ground."""
    return replace(arena, ground=ground)


def rough_ground(origin: tuple[float, float] = (0.0, 0.0)) -> HeightField:
    """10 by 10 m: a ramp of 15 degrees, posts of 10 cm, a hill of them, stairs of 20 cm."""
    heights = np.zeros((400, 400), dtype=np.float32)
    appearance = np.zeros((400, 400), dtype=np.uint16)
    x = (np.arange(400, dtype=np.float32) + 0.5) * CELL
    heights[40:100, 120:216] = (x[120:216] - 3.0) * 0.268  # a ramp that rises to the east
    random = np.random.default_rng(3)
    posts = random.integers(0, 4, (24, 24)).astype(np.float32) * 0.1
    heights[150:246, 60:156] = np.kron(posts, np.ones((4, 4), dtype=np.float32))
    appearance[40:100, 120:216] = 1
    appearance[150:246, 60:156] = 2
    rows, columns = np.indices((11, 11))
    hill = 0.4 - 0.1 * np.minimum(np.abs(columns - 5), 4) + 0.05 * ((rows + columns) % 2)
    heights[260:304, 200:244] = np.kron(hill, np.ones((4, 4))).astype(np.float32)
    appearance[260:304, 200:244] = 2
    for step in range(5):
        heights[150:200, 260 + 10 * step : 330] = 0.2 * (step + 1)
    appearance[150:200, 260:330] = 3
    return height_field(heights, appearance, origin)


def height_field(
    heights: npt.NDArray[np.float32],
    appearance: npt.NDArray[np.uint16],
    origin: tuple[float, float] = (0.0, 0.0),
    surfaces: tuple[Surface, ...] = SURFACES,
) -> HeightField:
    """Level cells of these heights."""
    return HeightField(
        heights=heights,
        east=np.zeros_like(heights),
        north=np.zeros_like(heights),
        cell=CELL,
        origin=origin,
        grip=np.ones_like(heights),
        appearance=appearance,
        surfaces=surfaces,
    )
