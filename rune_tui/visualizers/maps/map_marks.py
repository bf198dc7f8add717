"""Marks over a map: the robot, its trail and path, found victims, scale and north."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from hub.gcm.body import RobotBody
from hub.gcm.mapping import InterestPoint, PointKind
from rune_tui.model.body import corners, largest_radius
from rune_tui.model.console_state import Ghost
from rune_tui.model.map_window import MapWindow
from rune_tui.model.pose import Pose
from rune_tui.model.sightings import Floats
from rune_tui.model.theme import Theme
from rune_tui.model.view_cones import ViewCone
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import Pen, Point, drawing, toward
from rune_tui.visualizers.parts.severity import Severity, ink_of

_GLOW, _FAINT_GLOW = 90, 30
"""Brightness of the ground in the view of the chosen camera, and of another, of 255."""
_FAINT_LINE: Final = 110
"""Opacity of the sides of another camera's view, of 255."""
_DART_BACK: Final = math.radians(150.0)
"""Angle at a dart's middle between its tip and its other corners [rad]."""
_DART_NOTCH: Final = 0.8
"""Distance of its notch behind its middle, as a share of its reach."""
_SMOOTHING: Final = 4
_LEAST_ROBOT: Final = 5.0
"""Least radius of a drawn robot, on a map of any scale [pixels]."""
_SCALES: Final = tuple(step * 10.0**power for power in range(-2, 4) for step in (1.0, 2.0, 5.0))
_LEAST_COLUMNS, _LEAST_ROWS = 16, 4
"""Smaller maps have no scale and no north."""


def draw_trail(pen: Pen, window: MapWindow, pieces: Sequence[Floats], theme: Theme) -> None:
    """A thin line along the robot's trail."""
    for piece in pieces:
        if len(piece) > 1:
            pen.line(_points(window.pixels(piece)), theme.faint)


def draw_route(pen: Pen, window: MapWindow, route: Floats, theme: Theme) -> None:
    """A dashed line along the robot's path."""
    if len(route) > 1:
        pen.dashes(_points(window.pixels(route)), theme.good, dash=2.0, gap=2.0)


def draw_cone(canvas: Canvas, window: MapWindow, pose: Pose, cone: ViewCone, theme: Theme) -> None:
    """A camera's view, as a glow on the ground; walls stay unchanged."""
    seen = window.pixels(pose.to_map(np.concatenate((cone.outline, cone.sides))))
    low = np.maximum(np.floor(seen.min(axis=0)), 0.0).astype(int)
    high = np.ceil(seen.max(axis=0)).astype(int) + 1
    around = canvas.pixels[low[1] : max(0, high[1]), low[0] : max(0, high[0])]
    if not around.size:
        return
    lit = Canvas.blank(around.shape[1], around.shape[0])
    edge = _points(seen - low)
    count = len(cone.outline)
    glow, line = (_GLOW, 255) if cone.chosen else (_FAINT_GLOW, _FAINT_LINE)
    with drawing(lit) as pen:
        pen.polygon(edge[:count], (*theme.cone[:3], glow))
        pen.line(edge[count:], (*theme.cone[:3], line))
    wall = (around == theme.wall).all(axis=2)
    alpha = np.where(wall, 0, lit.pixels[..., 3])[..., None].astype(np.uint16)
    around[..., :3] = (lit.pixels[..., :3] * alpha + around[..., :3] * (255 - alpha)) // 255


def draw_robot(
    canvas: Canvas, window: MapWindow, pose: Pose, body: RobotBody | None, theme: Theme
) -> None:
    """The robot's footprint with an arrow, or only an arrow if the footprint is small."""
    x, y = _point(window.pixels((pose.x, pose.y)))
    radius = largest_radius(body) / window.metres_per_pixel
    reach = max(radius, _LEAST_ROBOT)
    left, top = (max(0, math.floor(at - reach - 1.0)) for at in (x, y))
    right, bottom = (max(0, math.ceil(at + reach + 1.0)) for at in (x, y))
    around = canvas.pixels[top:bottom, left:right]
    if not around.size:
        return
    # Smooth, so that the direction is clear; only here, because it takes time.
    patch = Canvas.blank(around.shape[1], around.shape[0])
    patch.pixels[...] = around
    centre = x - left, y - top
    with drawing(patch, smoothing=_SMOOTHING) as pen:
        if radius > _LEAST_ROBOT:
            footprint = corners(body)
            if len(footprint):
                edge = _points(window.pixels(pose.to_map(footprint)) - (left, top))
                pen.polygon(edge, theme.panel)
                pen.line([*edge, edge[0]], theme.robot)
            else:
                pen.circle(centre, radius, fill=theme.panel, rim=theme.robot)
        _draw_dart(pen, centre, reach, pose.theta - window.up, theme)
    around[...] = patch.pixels


def _draw_dart(pen: Pen, centre: Point, reach: float, direction: float, theme: Theme) -> None:
    """A dart with its tip ahead and a dark rim, so that its heading is visible on any ground."""
    shape = ((0.0, 1.0), (_DART_BACK, 1.0), (math.pi, _DART_NOTCH), (-_DART_BACK, 1.0))
    for size, colour in ((reach + 1.0, theme.ground), (reach, theme.robot)):
        corners_px = [toward(centre, size * far, direction + turn) for turn, far in shape]
        pen.polygon(corners_px, colour)


def mark_word(mark: InterestPoint, theme: Theme) -> tuple[str, Colour]:
    """The letter of a mark (V: victim, L: landmark) with its number, and their colour."""
    victim = mark.kind is PointKind.VICTIM
    return f"{'V' if victim else 'L'}{mark.number}", theme.warning if victim else theme.good


def write_points(
    canvas: Canvas, window: MapWindow, points: Sequence[InterestPoint], theme: Theme
) -> None:
    """The word of each mark at its place."""
    for point in points:
        word, ink = mark_word(point, theme)
        write_at(canvas, _point(window.pixels((point.x, point.y))), word, ink, theme)


def write_ghost(canvas: Canvas, window: MapWindow, ghost: Ghost, theme: Theme) -> None:
    """A letter with a question mark at the place of an unconfirmed mark."""
    word = "V?" if ghost.kind is PointKind.VICTIM else "L?"
    spot = _point(window.pixels((ghost.place.x, ghost.place.y)))
    write_at(canvas, spot, word, theme.warning, theme)


def write_goal(
    canvas: Canvas,
    window: MapWindow,
    place: tuple[float, float],
    word: str,
    severity: Severity,
    theme: Theme,
) -> None:
    """A letter at the robot's goal, and the outcome; nothing without a word."""
    if word:
        write_at(canvas, _point(window.pixels(place)), word, ink_of(severity, theme), theme)


def write_north(canvas: Canvas, window: MapWindow, theme: Theme) -> None:
    """An N at the edge that is north."""
    if canvas.width < _LEAST_COLUMNS or canvas.rows < _LEAST_ROWS:
        return
    north = math.pi / 2.0 - window.up
    right, down = -math.sin(north), -math.cos(north)
    half = canvas.width / 2.0 - 1.0, canvas.height / 2.0 - 2.0
    reach = 1.0 / max(abs(right) / half[0], abs(down) / half[1])
    spot = canvas.width / 2.0 + right * reach, canvas.height / 2.0 + down * reach
    write_at(canvas, spot, "N", theme.ink, theme)


def write_scale(canvas: Canvas, window: MapWindow, theme: Theme) -> None:
    """A bar of a round length, with the length, in the lower left corner."""
    if canvas.width < _LEAST_COLUMNS or canvas.rows < _LEAST_ROWS:
        return
    room = canvas.width / 4.0 * window.metres_per_pixel
    length = max((scale for scale in _SCALES if scale <= room), default=_SCALES[0])
    pixels = max(1, min(canvas.width - 2, round(length / window.metres_per_pixel)))
    row = canvas.rows - 1
    bar = f"├{'─' * (pixels - 2)}┤" if pixels > 1 else "│"
    words = f"{bar} {length:g} m"
    canvas.pixels[2 * row :, : len(words) + 2] = theme.panel
    canvas.text(1, row, words, theme.soft)


def write_at(canvas: Canvas, point: Point, string: str, ink: Colour, theme: Theme) -> None:
    """Words on a plate that begin at a point, if the point is inside."""
    column, row = math.floor(point[0]), math.floor(point[1] / 2.0)
    if 0 <= column < canvas.width and 0 <= row < canvas.rows:
        column = max(0, min(column, canvas.width - len(string)))
        canvas.pixels[2 * row : 2 * row + 2, column : column + len(string)] = theme.panel
        canvas.text(column, row, string, ink)


def _point(pixel: Floats) -> Point:
    x, y = pixel.tolist()
    return x, y


def _points(pixels: Floats) -> list[Point]:
    return [(x, y) for x, y in np.asarray(pixels).tolist()]
