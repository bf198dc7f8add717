"""What is drawn over a map: the robot, its trail and way, what was found, scale and north."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from hub.gcm.body import RobotBody
from hub.gcm.mapping import InterestPoint, PointKind
from hub.gcm.vision import CameraState
from rune_tui.model.body import corners, largest_radius
from rune_tui.model.map_window import MapWindow
from rune_tui.model.pose import Pose
from rune_tui.model.sightings import Floats
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import Pen, Point, drawing

_CONE_M: Final = 2.0
_SMOOTHING: Final = 4
_LEAST_ROBOT: Final = 4.0
"""However small the map, a robot reaches at least so far from its centre [pixels]."""
_SCALES: Final = tuple(step * 10.0**power for power in range(-2, 4) for step in (1.0, 2.0, 5.0))
_LEAST_COLUMNS, _LEAST_ROWS = 16, 4
"""Smaller maps have no scale and no north."""


def draw_trail(pen: Pen, window: MapWindow, pieces: Sequence[Floats], theme: Theme) -> None:
    """A thin line where the robot has been."""
    for piece in pieces:
        if len(piece) > 1:
            pen.line(_points(window.pixels(piece)), theme.faint)


def draw_route(pen: Pen, window: MapWindow, route: Floats, theme: Theme) -> None:
    """A dashed line where the robot wants to go."""
    if len(route) > 1:
        pen.dashes(_points(window.pixels(route)), theme.good, dash=2.0, gap=2.0)


def draw_cone(pen: Pen, window: MapWindow, pose: Pose, camera: CameraState, theme: Theme) -> None:
    """Both edges of what the camera sees."""
    middle, half = camera.pan, camera.horizontal_fov / 2.0
    if not math.isfinite(middle + half):
        return
    for side in (middle - half, middle + half):
        end = (_CONE_M * math.cos(side), _CONE_M * math.sin(side))
        edge = window.pixels(pose.to_map([(0.0, 0.0), end]))
        pen.dashes(_points(edge), theme.ink, dash=1.0, gap=2.0)


def draw_robot(
    canvas: Canvas, window: MapWindow, pose: Pose, body: RobotBody | None, theme: Theme
) -> None:
    """The ground that the robot covers with an arrow on it, or an arrow where that is small."""
    x, y = _point(window.pixels((pose.x, pose.y)))
    radius = largest_radius(body) / window.metres_per_pixel
    reach = max(radius, _LEAST_ROBOT)
    left, top = (max(0, math.floor(at - reach - 1.0)) for at in (x, y))
    right, bottom = (max(0, math.ceil(at + reach + 1.0)) for at in (x, y))
    around = canvas.pixels[top:bottom, left:right]
    if not around.size:
        return
    # Smooth, as its direction must be seen; only here, as that takes time.
    patch = Canvas.blank(around.shape[1], around.shape[0])
    patch.pixels[...] = around
    centre = x - left, y - top
    with drawing(patch, smoothing=_SMOOTHING) as pen:
        if radius > _LEAST_ROBOT:
            footprint = corners(body)
            if len(footprint):
                edge = _points(window.pixels(pose.to_map(footprint)) - (left, top))
                pen.polygon(edge, theme.panel)
                pen.line([*edge, edge[0]], theme.ink)
            else:
                pen.circle(centre, radius, fill=theme.panel, rim=theme.ink)
        pen.arrow(centre, reach, pose.theta - window.up, theme.accent)
    around[...] = patch.pixels


def write_points(
    canvas: Canvas, window: MapWindow, points: Sequence[InterestPoint], theme: Theme
) -> None:
    """A letter for what was found, V for victims and L for landmarks, and its number."""
    for point in points:
        victim = point.kind is PointKind.VICTIM
        word = f"{'V' if victim else 'L'}{point.number}"
        ink = theme.warning if victim else theme.good
        write_at(canvas, _point(window.pixels((point.x, point.y))), word, ink, theme)


def write_goal(canvas: Canvas, window: MapWindow, route: Floats, theme: Theme) -> None:
    """A letter where the route ends."""
    if len(route):
        write_at(canvas, _point(window.pixels(route[-1])), "G", theme.good, theme)


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
    """A bar of a round length and how long it is, in the lower left corner."""
    if canvas.width < _LEAST_COLUMNS or canvas.rows < _LEAST_ROWS:
        return
    room = canvas.width / 4.0 * window.metres_per_pixel
    length = max((scale for scale in _SCALES if scale <= room), default=_SCALES[0])
    pixels = max(1, min(canvas.width - 2, round(length / window.metres_per_pixel)))
    row = canvas.rows - 1
    words = f"{length:g} m"
    canvas.pixels[2 * row :, : pixels + 3 + len(words)] = theme.panel
    canvas.pixels[2 * row, 1 : 1 + pixels] = theme.ink
    canvas.pixels[2 * row :, [1, pixels]] = theme.ink
    canvas.text(pixels + 2, row, words, theme.ink)


def write_at(canvas: Canvas, point: Point, string: str, ink: Colour, theme: Theme) -> None:
    """Words on a plate that begin at a point; nothing if that is outside."""
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
