"""The place of a click on the picture: the end of its line of sight, and the source of it.

The line begins at the camera. It ends at the floor, or before at an obstacle of the map or of the
range sensors. The first row that applies decides:

| on the line | source | error, besides that of the pose |
| --- | --- | --- |
| a hit of an infrared sensor along it | RANGES | its noise |
| an occupied cell of the map | MAP | diagonal of a cell, width of the pixel |
| a sonar's echo before ground that is not free on the map | RANGES | half the cone's width |
| nothing before the floor | FLOOR | ground that the pixel covers |
| nothing, and the line does not meet the floor | none: there is no place | |

An obstacle behind the floor's place does not count. The line may pass over an obstacle, if it is
there higher than the known height of obstacles. Then the floor behind is possible too, and the
error is as large as the distance to it.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import RobotState as NavigationState
from hub.gcm.occupancy_map import OccupancyMap
from hub.values import dataclass
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.pose import Pose
from rune_tui.model.world import DistanceSource, WorldPoint

FARTHEST_M: Final = 12.0
"""Obstacles that are farther away do not count [m]."""
SURE_HEIGHT_M: Final = 0.4
"""Obstacles of the map and the range sensors have at least this height [m]."""
OCCUPIED: Final = 65
"""Least value of an occupied cell, as in ROS's map_server."""

_AT_FOOT_M: Final = 0.15
"""Largest distance between an obstacle and the floor's place if the click is at its foot [m]."""
_INFRARED_HALF: Final = math.radians(4.0)
_INFRARED_OFF_M: Final = 0.04
_STANDARD_DEVIATIONS: Final = 2.0
"""Standard deviations of the pose that count, because the other errors are bounds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """The surroundings of a picture.

    Attributes:
        pose: The robot's pose.
        grid: The map; None: there is none.
        navigation: The robot's ranges, from about the same moment and place; None: none.
        position_off: Standard deviation of the robot's position [m]; 0: not known.
        heading_off: Standard deviation of its heading [rad]; 0: not known.
    """

    pose: Pose
    grid: OccupancyMap | None = None
    navigation: NavigationState | None = None
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
    obstacle = _obstacle(geometry.mount_forward, bearing, min(floor, FARTHEST_M), pixel_m, around)
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
    ahead, left = geometry.mount_forward + way * math.cos(bearing), way * math.sin(bearing)
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


def hidden(place: WorldPoint, pose: Pose, camera_forward: float, grid: OccupancyMap | None) -> bool:
    """Whether a wall of the map hides a place in `map` from a camera."""
    if grid is None:
        return False
    ahead, left = pose.from_map((place.x, place.y)).tolist()
    ahead -= camera_forward
    far, bearing = math.hypot(ahead, left), math.atan2(left, ahead)
    line = _cells(camera_forward, bearing, far, pose, grid)
    occupied = np.flatnonzero(line >= OCCUPIED)
    return bool(len(occupied)) and occupied[0] * _step(grid) < far - 2.0 * _AT_FOOT_M


def _obstacle(
    forward: float, bearing: float, reach: float, pixel_m: float, around: Surroundings
) -> _Obstacle | None:
    """The first obstacle on a line from the camera."""
    infrared, sonar = _ranges(forward, bearing, around.navigation)
    if infrared is not None and infrared.way < reach:
        return infrared
    mapped, free = None, 0.0
    if around.grid is not None:
        line = _cells(forward, bearing, reach, around.pose, around.grid)
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
    if sonar is not None and free < sonar.way + _AT_FOOT_M and sonar.way < reach:
        return sonar if mapped is None or sonar.way < mapped.way else mapped
    return mapped


def _ranges(
    forward: float, bearing: float, navigation: NavigationState | None
) -> tuple[_Obstacle | None, _Obstacle | None]:
    """The hit of the infrared sensor and the echo of the sonar along a line, if any."""
    if navigation is None:
        return None, None
    count = len(navigation.sonar)
    opening = math.tau / count
    number = round(bearing / opening)
    beside = abs(bearing - number * opening)
    echo, seen = float(navigation.sonar[number % count]), float(navigation.infrared[number % count])
    infrared = sonar = None
    if math.isfinite(seen) and beside <= _INFRARED_HALF:
        way = max(0.0, seen - forward * math.cos(bearing))
        infrared = _Obstacle(way=way, off=_INFRARED_OFF_M, source=DistanceSource.RANGES)
    if math.isfinite(echo):
        way = max(0.0, echo - forward * math.cos(bearing))
        sonar = _Obstacle(way=way, off=way * math.sin(opening / 2.0), source=DistanceSource.RANGES)
    return infrared, sonar


def _step(grid: OccupancyMap) -> float:
    """Distance between samples of a line [m]."""
    return grid.resolution / 2.0


def _cells(
    forward: float, bearing: float, reach: float, pose: Pose, grid: OccupancyMap
) -> npt.NDArray[np.int8]:
    """The map's values along a line from the camera, one each step; -1 outside of the map."""
    ways = np.arange(max(1, math.ceil(min(reach, FARTHEST_M) / _step(grid)))) * _step(grid)
    points = pose.to_map(
        np.stack((forward + ways * math.cos(bearing), ways * math.sin(bearing)), axis=1)
    )
    corner = np.array((grid.origin_x, grid.origin_y))
    columns, rows = np.floor((points - corner) / grid.resolution).astype(np.int64).T
    height, width = grid.cells.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    values = np.full(len(ways), -1, np.int8)
    values[inside] = grid.cells[rows[inside], columns[inside]]
    return values
