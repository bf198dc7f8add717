"""The patterns on surfaces: square pictures, each kept at several degrees of smoothing.

Drawing a far wall from the sharp picture would flicker with every step of the robot; a smoother
one is taken the more texels fall on one pixel (Williams, Pyramidal Parametrics, 1983).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from hub.sim.geometry import Surface
from hub.values import dataclass

SIDE = 64
"""Texels along one side of a texture; a power of two."""
LEVELS = 6
"""Degrees of smoothing; at level n, blocks of 2**n texels have one colour."""

_RING_BLACK = 16.0

Pattern = npt.NDArray[np.float64]
"""Brightness of each texel relative to the surface's colour, shape (SIDE, SIDE), or its red, green
and blue, 0 to 255, shape (SIDE, SIDE, 3); row 0 is on top."""


@dataclass(frozen=True, slots=True)
class Texture:
    """How a texture is drawn, and how many metres of a surface it covers before it repeats."""

    draw: Callable[[Surface], Pattern]
    tile: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Atlas:
    """All textures of an arena side by side.

    The texel of material m, level l, row r, column c:
    `((m * LEVELS + l) * SIDE + r) * SIDE + c`.

    Attributes:
        planes: Red, green, blue of every texel, three of shape (texels,), 0 to 255.
        tile: Metres one texture covers, for each material, shape (materials,).
        index: Number of the material of each surface.
    """

    planes: tuple[npt.NDArray[np.uint16], npt.NDArray[np.uint16], npt.NDArray[np.uint16]]
    tile: npt.NDArray[np.float64]
    index: Mapping[Surface, int]


def make_atlas(surfaces: Sequence[Surface]) -> Atlas:
    """Draw every surface once, in the order given; equal ones share their material."""
    distinct = tuple(dict.fromkeys(surfaces))
    texels = np.empty((len(distinct), LEVELS, SIDE, SIDE, 3), dtype=np.uint16)
    for material, surface in enumerate(distinct):
        for level, picture in enumerate(_levels(_coloured(surface))):
            texels[material, level] = np.clip(np.rint(picture), 0, 255)
    red, green, blue = (np.ascontiguousarray(texels[..., channel].ravel()) for channel in range(3))
    return Atlas(
        planes=(red, green, blue),
        tile=np.array([TEXTURES[surface.texture].tile for surface in distinct]),
        index={surface: material for material, surface in enumerate(distinct)},
    )


def _coloured(surface: Surface) -> Pattern:
    pattern = TEXTURES[surface.texture].draw(surface)
    return pattern if pattern.ndim == 3 else pattern[..., None] * np.array(surface.colour, float)


def _levels(picture: Pattern) -> list[Pattern]:
    made = []
    for level in range(LEVELS):
        block = 1 << level
        count = SIDE // block
        means = picture.reshape(count, block, count, block, 3).mean(axis=(1, 3))
        made.append(means.repeat(block, axis=0).repeat(block, axis=1))
    return made


def _grid() -> tuple[Pattern, Pattern]:
    """Row and column of every texel."""
    rows, columns = np.mgrid[0:SIDE, 0:SIDE]
    return rows, columns


def _grain(amount: float) -> Pattern:
    """Irregular brightness around 1, the same in every run."""
    return 1.0 + amount * np.random.default_rng(7).uniform(-1.0, 1.0, (SIDE, SIDE))


def _plain(_: Surface) -> Pattern:
    return np.ones((SIDE, SIDE))


def _brick(_: Surface) -> Pattern:
    """Courses of 8 texels, bricks of 16, every other course shifted by half a brick."""
    rows, columns = _grid()
    course = rows // 8
    shifted = (columns + 8 * (course % 2)) % SIDE
    tone = np.random.default_rng(3).uniform(0.82, 1.06, (8, 4))
    bricks = tone[course, shifted // 16] * _grain(0.05)
    mortar = (rows % 8 == 0) | (shifted % 16 == 0)
    return np.where(mortar, 0.62, bricks)


def _panel(_: Surface) -> Pattern:
    """Boards of plywood: a dark joint around, screws in the corners, faint vertical figure."""
    rows, columns = _grid()
    figure = 1.0 + 0.05 * np.sin(columns * (2 * math.pi / 16)) * np.sin(rows * (2 * math.pi / 64))
    board = figure * _grain(0.03)
    joint = (columns == 0) | (rows == 0)
    screw = np.isin(rows, (5, 59)) & np.isin(columns, (5, 59, 32))
    return np.where(joint, 0.55, np.where(screw, 0.45, board))


def _wood(_: Surface) -> Pattern:
    """Four planks with grain along them."""
    rows, columns = _grid()
    plank = rows // 16
    tone = np.array([0.92, 1.04, 0.86, 0.98])[plank]
    grain = 0.06 * np.sin(rows * 1.9 + 1.5 * np.sin(columns * (2 * math.pi / SIDE) + plank))
    return np.where(rows % 16 == 0, 0.6, (tone + grain) * _grain(0.03))


def _concrete(_: Surface) -> Pattern:
    """Blotches of several sizes; wraps around without a seam."""
    rng = np.random.default_rng(11)
    total = np.zeros((SIDE, SIDE))
    for block, amount in ((16, 0.06), (8, 0.05), (4, 0.04), (2, 0.03)):
        count = SIDE // block
        coarse = rng.uniform(-amount, amount, (count, count))
        total += coarse.repeat(block, axis=0).repeat(block, axis=1)
    return 1.0 + total


def _fabric(_: Surface) -> Pattern:
    """Folds and a weave."""
    rows, columns = _grid()
    turn = 2 * math.pi / SIDE
    weave = 0.04 * ((rows // 2 + columns // 2) % 2)
    cloth: Pattern = 0.95 + weave + 0.07 * np.sin(3 * turn * columns + 2 * np.sin(turn * rows))
    return cloth * _grain(0.04)


def _checker(_: Surface) -> Pattern:
    rows, columns = _grid()
    half = SIDE // 2
    light = (rows // half + columns // half) % 2 == 0
    edge = (rows % half == 0) | (columns % half == 0)
    return np.where(light, 1.0, 0.68) * np.where(edge, 0.9, 1.0) * _grain(0.03)


def _ceiling(_: Surface) -> Pattern:
    """A lamp in every tile."""
    rows, columns = _grid()
    lamp = (np.abs(rows - 32) < 5) & (np.abs(columns - 32) < 20)
    joint = (rows % 16 == 0) | (columns % 16 == 0)
    return np.where(lamp, 1.9, np.where(joint, 0.8, 1.0))


def _face(surface: Surface) -> Pattern:
    """Hair, brows, eyes, nose and mouth on skin."""
    rows, columns = _grid()
    x, y = (columns - 31.5) / 32.0, (rows - 31.5) / 32.0
    picture = np.empty((SIDE, SIDE, 3))
    picture[:] = surface.colour
    picture[y < -0.62 + 0.2 * x * x] = (62, 40, 28)
    side = np.abs(np.abs(x) - 0.42)
    picture[(side < 0.22) & (np.abs(y + 0.32) < 0.05)] = (80, 52, 36)
    picture[(side / 0.22) ** 2 + ((y + 0.08) / 0.13) ** 2 < 1] = (244, 244, 240)
    picture[(side / 0.10) ** 2 + ((y + 0.08) / 0.13) ** 2 < 1] = (36, 44, 60)
    picture[(np.abs(x) < 0.07) & (y > 0.0) & (y < 0.3)] = (196, 138, 106)
    picture[(np.abs(x) < 0.36) & (np.abs(y - 0.55) < 0.07)] = (168, 60, 58)
    return picture


def _sign(surface: Surface) -> Pattern:
    """A field of the landmark's colour in a white frame, with a white diamond."""
    rows, columns = _grid()
    x, y = np.abs(columns - 31.5) / 32.0, np.abs(rows - 31.5) / 32.0
    picture = np.empty((SIDE, SIDE, 3))
    picture[:] = surface.colour
    picture[x + y < 0.38] = (246, 246, 246)
    picture[np.maximum(x, y) > 0.9] = (246, 246, 246)
    return picture


def _ring(angle_deg: float) -> Callable[[Surface], Pattern]:
    """A Landolt C (ISO 8596): outer diameter 5 gaps, stroke and gap 1, on a panel of 7 gaps."""

    def draw(surface: Surface) -> Pattern:
        fine = 4
        count = SIDE * fine
        gaps = ((np.arange(count) + 0.5) / count - 0.5) * 7.0
        x, y = np.meshgrid(gaps, -gaps)
        radius = np.hypot(x, y)
        along = x * math.cos(math.radians(angle_deg)) + y * math.sin(math.radians(angle_deg))
        across = y * math.cos(math.radians(angle_deg)) - x * math.sin(math.radians(angle_deg))
        ring = (radius >= 1.5) & (radius <= 2.5) & ~((along > 0) & (np.abs(across) <= 0.5))
        black = ring.reshape(SIDE, fine, SIDE, fine).mean(axis=(1, 3))[..., None]
        panel: Pattern = np.array(surface.colour, float) * (1.0 - black) + _RING_BLACK * black
        return panel

    return draw


TEXTURES: Mapping[str, Texture] = {
    "plain": Texture(_plain),
    "brick": Texture(_brick),
    "panel": Texture(_panel, 1.2),
    "wood": Texture(_wood, 0.8),
    "concrete": Texture(_concrete, 2.0),
    "fabric": Texture(_fabric, 0.5),
    "checker": Texture(_checker, 1.0),
    "ceiling": Texture(_ceiling, 2.0),
    "face": Texture(_face),
    "sign": Texture(_sign),
    "ring right": Texture(_ring(0.0)),
    "ring up-right": Texture(_ring(45.0)),
    "ring up": Texture(_ring(90.0)),
    "ring up-left": Texture(_ring(135.0)),
    "ring left": Texture(_ring(180.0)),
    "ring down-left": Texture(_ring(225.0)),
    "ring down": Texture(_ring(270.0)),
    "ring down-right": Texture(_ring(315.0)),
}
