"""The place of a click on the picture: the end of its line of sight, and the source of it.

The line begins at the camera. It ends at the floor, or before at an obstacle of the map or of the
range sensors. The first row that applies decides:

| on the line | source | error, besides that of the pose |
| --- | --- | --- |
| a hit of a narrow beam along it | RANGES | its noise |
| an occupied cell of the map | MAP | diagonal of a cell, width of the pixel |
| an echo of a wide beam before ground that is not free on the map | RANGES | half the cone |
| nothing before the floor | FLOOR | ground that the pixel covers |
| nothing, and the line does not meet the floor | none: there is no place | |

An obstacle behind the floor's place does not count. The line may pass over an obstacle, if it is
there higher than the known height of obstacles. Then the floor behind is possible too, and the
error is as large as the distance to it.

The floor before a robot that stands tilted may be the plane under its wheels, or level. The error
is as large as the distance between these two places.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.occupancy_map import OccupancyMap
from hub.values import dataclass
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.pose import Pose
from rune_tui.model.robot_ranges import RobotRanges
from rune_tui.model.world import DistanceSource, WorldPoint

FARTHEST_M: Final = 12.0
"""Obstacles that are farther away do not count [m]."""
SURE_HEIGHT_M: Final = 0.4
"""Obstacles of the map and the range sensors have at least this height [m]."""
OCCUPIED: Final = 65
"""Least value of an occupied cell, as in ROS's map_server."""

_AT_FOOT_M: Final = 0.15
"""Largest distance between an obstacle and the floor's place if the click is at its foot [m]."""
_NARROW_OFF_M: Final = 0.04
_STANDARD_DEVIATIONS: Final = 2.0
"""Standard deviations of the pose that count, because the other errors are bounds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """The surroundings of a picture.

    Attributes:
        pose: The robot's pose.
        grid: The map; None: there is none.
        ranges: The robot's ranges, from about the same moment and place; None: none.
        position_off: Standard deviation of the robot's position [m]; 0: not known.
        heading_off: Standard deviation of its heading [rad]; 0: not known.
    """

    pose: Pose
    grid: OccupancyMap | None = None
    ranges: RobotRanges | None = None
    position_off: float = 0.0
    heading_off: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Obstacle:
    """An obstacle on the line.

    Attributes:
        way: Horizontal distance from the camera [m].
        off: Its error [m].
        source: Its source.
    """

    way: float
    off: float
    source: DistanceSource


def place_of_pixel(
    geometry: PictureGeometry, pixel: tuple[float, float], coarse: float, around: Surroundings
) -> WorldPoint | None:
    """The place in `map` that a pixel shows; None: its distance is not known.

    Args:
        geometry: The picture as it is shown, and its camera.
        pixel: The pixel in it [px].
        coarse: Size of a pixel of the picture on the screen [px], at least 1.
        around: The surroundings.
    """
    bearing, elevation = geometry.mount_angles(geometry.image_angles(pixel)).tolist()
    drop = math.tan(elevation)
    floor = geometry.mount_height / -drop if drop < 0.0 else math.inf
    floor = floor if geometry.ground_point(*pixel) is not None else math.inf
    pixel_m = 2.0 * geometry.half_width / geometry.width * coarse
    obstacle = _obstacle(geometry.mount, bearing, min(floor, FARTHEST_M), pixel_m, around)
    if obstacle is not None and obstacle.way < floor - _AT_FOOT_M:
        way, off, source = obstacle.way, obstacle.off, obstacle.source
        height = geometry.mount_height + way * drop
        if height > SURE_HEIGHT_M and math.isfinite(floor):
            off = max(off, floor - way)
    else:
        spread = geometry.spread(*pixel)
        if spread is None or not math.isfinite(floor):
            return None
        way, off, source = (
            floor,
            coarse * math.hypot(spread.along, spread.across),
            DistanceSource.FLOOR,
        )
        height = 0.0
    ahead = geometry.mount_forward + way * math.cos(bearing)
    left = geometry.mount_left + way * math.sin(bearing)
    x, y = around.pose.to_map((ahead, left)).tolist()
    away = math.hypot(ahead, left)
    pose_off = math.hypot(around.position_off, around.heading_off * away)
    return WorldPoint(
        x=x,
        y=y,
        height=height,
        uncertainty=math.hypot(off, _STANDARD_DEVIATIONS * pose_off),
        distance=away,
        source=source,
    )


def unsure(place: WorldPoint, level: WorldPoint | None) -> WorldPoint:
    """A place on the floor before a tilted robot, as uncertain as where the floor goes on.

    Args:
        place: The place by the plane under the robot's wheels.
        level: The place by level ground; None: the pixel shows none.
    """
    if place.source is not DistanceSource.FLOOR:
        return place
    off = math.hypot(place.x - level.x, place.y - level.y) if level else place.distance
    return dataclasses.replace(place, uncertainty=max(place.uncertainty, off))


def hidden(
    place: WorldPoint, pose: Pose, camera: tuple[float, float], grid: OccupancyMap | None
) -> bool:
    """Whether a wall of the map hides a place in `map` from a camera."""
    if grid is None:
        return False
    ahead, left = pose.from_map((place.x, place.y)).tolist()
    ahead, left = ahead - camera[0], left - camera[1]
    far, bearing = math.hypot(ahead, left), math.atan2(left, ahead)
    line = _cells(camera, bearing, far, pose, grid)
    occupied = np.flatnonzero(line >= OCCUPIED)
    return bool(len(occupied)) and occupied[0] * _step(grid) < far - 2.0 * _AT_FOOT_M


def _obstacle(
    camera: tuple[float, float], bearing: float, reach: float, pixel_m: float, around: Surroundings
) -> _Obstacle | None:
    """The first obstacle on a line from the camera."""
    narrow, wide = _hits(camera, bearing, around.ranges)
    if narrow is not None and narrow.way < reach:
        return narrow
    mapped, free = None, 0.0
    if around.grid is not None:
        line = _cells(camera, bearing, reach, around.pose, around.grid)
        step = _step(around.grid)
        occupied = np.flatnonzero(line >= OCCUPIED)
        if len(occupied):
            way = float(occupied[0]) * step
            off = math.hypot(around.grid.resolution * math.sqrt(2.0), way * pixel_m)
            mapped = _Obstacle(way=way, off=off, source=DistanceSource.MAP)
        not_free = np.flatnonzero((line < 0) | (line >= OCCUPIED))
        free = float(not_free[0] if len(not_free) else len(line)) * step
    if mapped is not None and free >= mapped.way - _AT_FOOT_M:
        return mapped
    if wide is not None and free < wide.way + _AT_FOOT_M and wide.way < reach:
        return wide if mapped is None or wide.way < mapped.way else mapped
    return mapped


def _hits(
    camera: tuple[float, float], bearing: float, ranges: RobotRanges | None
) -> tuple[_Obstacle | None, _Obstacle | None]:
    """The nearest hit of a narrow beam and the nearest echo of a wide one along a line, if any.

    The line `c + w d` meets the circle of radius r around a beam's origin at
    `w = -b + sqrt(r^2 - |c|^2 + b^2)` with `b = c d`, if c counts from that origin.
    """
    if ranges is None:
        return None, None
    of, beams = ranges.of, ranges.of.beams
    radius = np.hypot(ranges.x - beams.x, ranges.y - beams.y)
    ahead, left = math.cos(bearing), math.sin(bearing)
    from_x, from_y = camera[0] - beams.x, camera[1] - beams.y
    along = from_x * ahead + from_y * left
    room = radius**2 - from_x**2 - from_y**2 + along**2
    way = np.maximum(0.0, np.sqrt(np.maximum(room, 0.0)) - along)
    there = np.arctan2(from_y + way * left, from_x + way * ahead)
    beside = np.abs((there - beams.bearing + np.pi) % math.tau - np.pi)
    met = np.isfinite(ranges.room) & (room >= 0.0) & (beside <= of.half)
    found: list[_Obstacle | None] = []
    for wanted in (~of.wide, of.wide):
        ways = np.where(met & wanted, way, np.inf)
        number = int(ways.argmin()) if len(ways) else -1
        if number < 0 or math.isinf(ways[number]):
            found.append(None)
            continue
        nearest = float(ways[number])
        off = nearest * math.sin(of.half[number]) if of.wide[number] else _NARROW_OFF_M
        found.append(_Obstacle(way=nearest, off=off, source=DistanceSource.RANGES))
    return found[0], found[1]


def _step(grid: OccupancyMap) -> float:
    """Distance between samples of a line [m]."""
    return grid.resolution / 2.0


def _cells(
    camera: tuple[float, float], bearing: float, reach: float, pose: Pose, grid: OccupancyMap
) -> npt.NDArray[np.int8]:
    """The map's values along a line from the camera, one each step; -1 outside of the map."""
    ways = np.arange(max(1, math.ceil(min(reach, FARTHEST_M) / _step(grid)))) * _step(grid)
    points = pose.to_map(
        np.stack((ways * math.cos(bearing), ways * math.sin(bearing)), axis=1) + camera
    )
    corner = np.array((grid.origin_x, grid.origin_y))
    columns, rows = np.floor((points - corner) / grid.resolution).astype(np.int64).T
    height, width = grid.cells.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    values = np.full(len(ways), -1, np.int8)
    values[inside] = grid.cells[rows[inside], columns[inside]]
    return values
