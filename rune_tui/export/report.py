"""An HTML page of a robot's marks: the map, and a table with pictures; one file, pure."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Iterator, Sequence

import numpy as np
from PIL import Image

from hub.gcm.mapping import InterestPoint, PointKind
from hub.gcm.occupancy_map import OccupancyMap
from hub.plain_text import markup
from rune_tui.export.points import moment, thumbnail_text
from rune_tui.model.world import metres_text

_STYLE = """
body { font: 16px/1.4 system-ui, sans-serif; margin: 2em auto; max-width: 60em; color: #181c22 }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; padding: .3em .6em; border-bottom: 1px solid #c4c8cc }
td.number { text-align: right }
svg { width: 100%; max-height: 80vh; background: #b0b4b8 }
@media print { svg { max-height: 16cm } }
"""
_UNKNOWN = 176
"""Grey of unknown cells."""
_ROOM = 1.0
"""Margin around the drawing [m]."""
_MARK = 0.18
"""Half the size of a mark in a drawing ten metres wide [m]."""


def html_page(
    robot: str, points: Sequence[InterestPoint], grid: OccupancyMap | None, made: str
) -> str:
    """The page.

    Args:
        robot: The robot's name.
        points: Its marks.
        grid: Its map; None if it has none.
        made: Time of the page, in words.
    """
    shown = [point for point in points if math.isfinite(point.x) and math.isfinite(point.y)]
    victims = sum(point.kind is PointKind.VICTIM for point in shown)
    counted = f"Victims: {victims}, landmarks: {len(shown) - victims}"
    rows = "\n".join(map(_row, shown))
    heading = markup(f"What {robot} found")
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{heading}</title><style>{_STYLE}</style></head>
<body>
<h1>{heading}</h1>
<p>{counted}. Made {markup(made)}.</p>
{drawing(shown, grid)}
<p>Circles with a number are victims, squares are landmarks. Coordinates are metres in the
robot's map, x to the right and y up; ± is their error, where it is known.</p>
<table>
<tr><th>No.</th><th>what</th><th>x [m]</th><th>y [m]</th><th>± [m]</th><th>seen from [m]</th>
<th>when</th><th>by</th><th>note</th><th>picture</th></tr>
{rows}
</table>
</body>
</html>
"""


def _row(point: InterestPoint) -> str:
    picture = thumbnail_text(point)
    image = f'<img alt="" src="data:image/jpeg;base64,{picture}">' if picture else ""
    place = (f"{point.x:.2f}", f"{point.y:.2f}")
    sure = (metres_text(point.uncertainty, 2), metres_text(point.distance, 1))
    numbers = "".join(f'<td class="number">{text}</td>' for text in (*place, *sure))
    words = (moment(point.stamp), point.by, point.note)
    cells = "".join(f"<td>{markup(text)}</td>" for text in words)
    return (
        f'<tr><td class="number">{point.number}</td><td>{point.kind.name.lower()}</td>'
        f"{numbers}{cells}<td>{image}</td></tr>"
    )


def drawing(
    points: Sequence[InterestPoint],
    grid: OccupancyMap | None,
    trail: Sequence[tuple[float, float]] = (),
) -> str:
    """The map, the robot's way and its marks as SVG, in metres; y is negated, as SVG points down.

    Args:
        points: The marks; each has a finite place.
        grid: The map; None if there is none.
        trail: Places in `map` that the robot was at [m], in their order.
    """
    left, bottom, right, top = _extent([*((p.x, p.y) for p in points), *trail], grid)
    size = _MARK * max(right - left, top - bottom) / 10.0
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" '
        f'viewBox="{left:.3f} {-top:.3f} {right - left:.3f} {top - bottom:.3f}">'
    ]
    if grid is not None and grid.cells.size:
        rows, columns = grid.cells.shape
        width, height = columns * grid.resolution, rows * grid.resolution
        parts.append(
            f'<image x="{grid.origin_x:.3f}" y="{-(grid.origin_y + height):.3f}" '
            f'width="{width:.3f}" height="{height:.3f}" style="image-rendering: pixelated" '
            f'href="data:image/png;base64,{_grid_text(grid)}"/>'
        )
    if len(trail) > 1:
        places = " ".join(f"{x:.2f},{-y:.2f}" for x, y in trail)
        parts.append(
            f'<polyline points="{places}" fill="none" stroke="#1464aa" '
            f'stroke-width="{size / 4:.3f}"/>'
        )
    parts += [_mark(point, size) for point in points]
    return "\n".join([*parts, "</svg>"])


def _mark(point: InterestPoint, size: float) -> str:
    x, y = point.x, -point.y
    if point.kind is PointKind.VICTIM:
        shape = f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{size:.3f}" fill="#c81818"/>'
    else:
        corner = f'x="{x - size:.3f}" y="{y - size:.3f}"'
        shape = f'<rect {corner} width="{2 * size:.3f}" height="{2 * size:.3f}" fill="#1464aa"/>'
    place = f'x="{x:.3f}" y="{y + 0.4 * size:.3f}" font-size="{1.1 * size:.3f}"'
    return f'{shape}<text {place} text-anchor="middle" fill="#fff">{point.number}</text>'


def _extent(
    places: Sequence[tuple[float, float]], grid: OccupancyMap | None
) -> tuple[float, float, float, float]:
    """Least x, least y, greatest x, greatest y of the drawing, with its margin [m]."""
    corners = [*places, *_known_corners(grid)] or [(0.0, 0.0)]
    xs, ys = zip(*corners, strict=True)
    return min(xs) - _ROOM, min(ys) - _ROOM, max(xs) + _ROOM, max(ys) + _ROOM


def _known_corners(grid: OccupancyMap | None) -> Iterator[tuple[float, float]]:
    """Two corners around the known cells of a map [m]; none if all are unknown."""
    if grid is None:
        return
    rows, columns = np.nonzero(grid.cells >= 0)
    if len(rows):
        for row, column in ((rows.min(), columns.min()), (rows.max() + 1, columns.max() + 1)):
            yield (
                grid.origin_x + float(column) * grid.resolution,
                grid.origin_y + float(row) * grid.resolution,
            )


def _grid_text(grid: OccupancyMap) -> str:
    """The map as a PNG file in base64: black is occupied, white is free."""
    occupied = np.clip(grid.cells, 0, 100).astype(np.int32)
    grey = np.where(grid.cells < 0, _UNKNOWN, 255 - occupied * 255 // 100).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(grey[::-1])).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()
