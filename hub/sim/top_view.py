"""Draws an arena from above, north up, for those who write arenas and those who search them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from hub.gcm.body import USUAL_HEIGHT, USUAL_RADIUS
from hub.sim.arena import LOWEST_OBSTACLE, Arena
from hub.sim.arena_specs import WATER_TYPES
from hub.sim.camera.ground_light import ground_light
from hub.sim.geometry import Box, Colour, Cylinder, Side
from hub.sim.top_view_canvas import BLACK, WHITE, Canvas, Point

_MARGIN = 0.6
"""Around everything [m]."""
_START: Colour = (20, 120, 40)
_BERTH: Colour = (20, 80, 200)
_VICTIM: Colour = (200, 20, 30)
_MARK_SIZE = 0.16
_RIM = 0.45
"""Light on the rim of a solid."""
_GRID = 0.94
"""Share of light on the lines of the grid, a metre apart."""
_SEE_THROUGH = 0.4
"""Share of a solid that hangs above the robot; the floor below shows."""
_SHADOW = 0.75
_SHADOW_LENGTH = 0.12
"""Of a solid, a metre for each metre of height [m]."""
_WATER_SHARE = 0.5
_WATER_PATH = 4.0
"""Length of the way through water that gives it its colour [m]."""


def draw_top_view(
    arena: Arena, victims: Sequence[Point] = (), longest_px: int = 720
) -> npt.NDArray[np.uint8]:
    """The picture, shape (height, width, 3).

    It shows solids, rough ground, water, signs, rings, the start, berths and a scale bar.
    Solids that hang above the robot are see-through.

    Args:
        arena: What is drawn.
        victims: Where there are any [m]; they get numbers from 1.
        longest_px: Length of the longer side.
    """
    low, high = _extent(arena)
    canvas = Canvas(low, high, longest_px, arena.floor.colour)
    _draw_ground(canvas, arena)
    for line in range(math.ceil(low[0]), math.floor(high[0]) + 1):
        canvas.shade((line - 0.01, low[1]), (line + 0.01, high[1]), _GRID)
    for line in range(math.ceil(low[1]), math.floor(high[1]) + 1):
        canvas.shade((low[0], line - 0.01), (high[0], line + 0.01), _GRID)
    surface = math.inf if arena.water is None else arena.water.surface
    solids = sorted(_solids(arena), key=_top)
    for solid in solids:
        if _top(solid) <= surface:
            _draw_solid(canvas, solid, _share(arena, solid))
    if arena.water is not None:
        loss = np.array(WATER_TYPES[arena.water.type])
        colour = 255.0 * np.exp(-loss * _WATER_PATH)
        area = arena.water.area or (low, high)
        canvas.fill(*area, tuple(colour.tolist()), _WATER_SHARE)
    for solid in solids:
        if _top(solid) > surface:
            _draw_solid(canvas, solid, _share(arena, solid))
    _draw_marks(canvas, arena, victims)
    canvas.scale_bar()
    return canvas.picture()


def _solids(arena: Arena) -> Iterator[Box | Cylinder]:
    yield from arena.boxes
    yield from arena.cylinders


def _extent(arena: Arena) -> tuple[Point, Point]:
    """Corners of what is drawn [m]."""
    points = [(arena.start.x, arena.start.y), *(berth.at for berth in arena.berths)]
    for box in arena.boxes:
        points += [box.low[:2], box.high[:2]]
    for item in arena.cylinders:
        points += _square(item)
    if arena.ground is not None:
        rows, columns = np.nonzero(arena.ground.heights)
        (x, y), cell = arena.ground.origin, arena.ground.cell
        if len(rows):
            points.append((x + cell * float(columns.min()), y + cell * float(rows.min())))
            points.append((x + cell * float(columns.max()), y + cell * float(rows.max())))
    if arena.water is not None and arena.water.area is not None:
        points += arena.water.area
    x_values, y_values = zip(*points, strict=True)
    return (
        (min(x_values) - _MARGIN, min(y_values) - _MARGIN),
        (max(x_values) + _MARGIN, max(y_values) + _MARGIN),
    )


def _draw_ground(canvas: Canvas, arena: Arena) -> None:
    """Each cell in the colour of its surface: higher ones are brighter, slopes as they are lit."""
    ground = arena.ground
    if ground is None:
        return
    colours = np.array([surface.colour for surface in ground.surfaces], dtype=np.float32)
    light = ground_light(ground.heights, ground.cell)
    light *= 0.85 + 0.3 * ground.heights / max(float(ground.heights.max()), 0.1)
    steps = np.abs(np.diff(ground.heights, axis=1, append=ground.heights[:, -1:]))
    steps += np.abs(np.diff(ground.heights, axis=0, append=ground.heights[-1:]))
    light[steps > 0.5 * ground.cell + 0.02] *= 0.7
    shown = (ground.heights > 0.0) | (ground.appearance > 0)
    canvas.cells(colours[ground.appearance] * light[..., None], shown, ground.cell, ground.origin)


def _top(solid: Box | Cylinder) -> float:
    return solid.high[2] if isinstance(solid, Box) else solid.high


def _share(arena: Arena, solid: Box | Cylinder) -> float:
    """Share of a solid's colour: those that hang above the robot are see-through."""
    if isinstance(solid, Box):
        x, y = (solid.low[0] + solid.high[0]) / 2, (solid.low[1] + solid.high[1]) / 2
        bottom = solid.low[2]
    else:
        x, y, bottom = solid.x, solid.y, solid.low
    below = 0.0
    if arena.ground is not None:
        below = arena.ground.height(x, y, bottom + LOWEST_OBSTACLE)
    return _SEE_THROUGH if bottom >= below + USUAL_HEIGHT else 1.0


def _draw_solid(canvas: Canvas, solid: Box | Cylinder, share: float) -> None:
    """Its shadow, its rim and its top, the brighter the higher."""
    top = _top(solid)
    bright = min(0.75 + 0.2 * top, 1.1)
    surface = solid.surface
    length = _SHADOW_LENGTH * min(top, 2.0)
    if isinstance(solid, Cylinder):
        middle = (solid.x, solid.y)
        if share == 1.0:
            canvas.round_shadow(middle, solid.radius, length, _SHADOW)
        canvas.disc(middle, solid.radius, _lit(surface.colour, _RIM), share)
        canvas.disc(middle, solid.radius - canvas.pixel, _lit(surface.colour, bright), share)
        return
    low, high = solid.low[:2], solid.high[:2]
    if share == 1.0:
        canvas.shadow(low, high, length, _SHADOW)
    if solid.picture_side is Side.UP and solid.picture is not None:
        surface = solid.picture
    canvas.fill(low, high, _lit(surface.colour, _RIM), share)
    inner = canvas.pixel
    if min(high[0] - low[0], high[1] - low[1]) > 3 * inner:
        low, high = (low[0] + inner, low[1] + inner), (high[0] - inner, high[1] - inner)
    canvas.fill(low, high, _lit(surface.colour, bright), share)


def _square(item: Cylinder) -> tuple[Point, Point]:
    """Corners of the square around a cylinder [m]."""
    x, y, radius = item.x, item.y, item.radius
    return (x - radius, y - radius), (x + radius, y + radius)


def _lit(colour: Colour, light: float) -> tuple[float, ...]:
    return tuple(min(255.0, part * light) for part in colour)


def _draw_marks(canvas: Canvas, arena: Arena, victims: Sequence[Point]) -> None:
    """Draw what is not solid, or too thin to be seen.

    Signs are diamonds of their colour, and rings are rings. The start is a robot with its
    heading, berths are arrows, victims are numbered discs.
    """
    for box in arena.boxes:
        if box.picture is None or box.picture_side is None or box.picture.texture == "face":
            continue
        axis, sign = box.picture_side.axis, box.picture_side.sign
        middle = [(box.low[0] + box.high[0]) / 2, (box.low[1] + box.high[1]) / 2]
        middle[axis] += sign * _MARK_SIZE
        at = (middle[0], middle[1])
        if box.picture.texture == "sign":
            canvas.diamond(at, _MARK_SIZE, WHITE)
            canvas.diamond(at, 0.7 * _MARK_SIZE, box.picture.colour)
        else:
            for share, tone in ((0.75, WHITE), (0.55, BLACK), (0.3, WHITE)):
                canvas.disc(at, share * _MARK_SIZE, tone)
    start = (arena.start.x, arena.start.y)
    canvas.disc(start, USUAL_RADIUS, WHITE)
    canvas.disc(start, USUAL_RADIUS - 2 * canvas.pixel, _START)
    canvas.arrow(start, arena.start.theta, USUAL_RADIUS, WHITE)
    for berth in arena.berths:
        canvas.arrow(berth.at, berth.heading, 2.2 * _MARK_SIZE, WHITE)
        canvas.arrow(berth.at, berth.heading, 1.7 * _MARK_SIZE, _BERTH)
    for number, place in enumerate(victims, start=1):
        canvas.disc(place, _MARK_SIZE + 2 * canvas.pixel, WHITE)
        canvas.disc(place, _MARK_SIZE, _VICTIM)
        canvas.text(str(number), place, 1.3 * _MARK_SIZE, WHITE)
