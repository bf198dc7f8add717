"""The map that the robot's map server has: its arena, seen from above."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from hub.gcm.geometry import Point3D, Pose3D
from hub.gcm.standard import Header
from hub.sim.arena import Arena

_CELL_M: Final = 0.05
_BORDER_M: Final = 0.5
_OCCUPIED: Final = 100


def occupancy_grid(arena: Arena, header: Header) -> dict[str, Any]:
    """The nav_msgs/OccupancyGrid of an arena, in its own frame; what is not taken is free."""
    solids = arena.footprints
    radius = solids.radius[:, None]
    low = np.vstack((solids.low, solids.centre - radius, [[arena.start.x, arena.start.y]]))
    high = np.vstack((solids.high, solids.centre + radius, [[arena.start.x, arena.start.y]]))
    origin = low.min(axis=0) - _BORDER_M
    width, height = np.ceil((high.max(axis=0) + _BORDER_M - origin) / _CELL_M).astype(int)
    x = origin[0] + (np.arange(width) + 0.5) * _CELL_M
    y = (origin[1] + (np.arange(height) + 0.5) * _CELL_M)[:, None]
    cells = np.zeros((height, width), np.int8)
    half = _CELL_M / 2.0  # a wall thinner than a cell takes that cell
    for (left, lower), (right, upper) in zip(solids.low - half, solids.high + half, strict=True):
        cells[(x >= left) & (x <= right) & (y >= lower) & (y <= upper)] = _OCCUPIED
    for (east, north), around in zip(solids.centre, solids.radius + half, strict=True):
        cells[np.hypot(x - east, y - north) <= around] = _OCCUPIED
    info = {
        "map_load_time": header.stamp,
        "resolution": _CELL_M,
        "width": int(width),
        "height": int(height),
        "origin": Pose3D(position=Point3D(x=float(origin[0]), y=float(origin[1]))),
    }
    return {"header": header, "info": info, "data": cells}
