"""Paints the map that the robot makes itself into the grid, in the place of scans."""

from __future__ import annotations

import logging

from hub.bucket import Bucket
from hub.gcm.occupancy_map import OccupancyMap
from hub.modules.mapping.grid import LOADED, OccupancyGrid
from hub.robots.interfaces import OwnMap

_logger = logging.getLogger(__name__)

_WARNINGS_PER_S, _WARNINGS_AT_ONCE = 1.0 / 60.0, 3.0


class PaintedMap:
    """The robot's own map in one grid.

    Attributes:
        counts: Whether there is one, so that scans change nothing.
    """

    def __init__(self, own: OwnMap, grid: OccupancyGrid) -> None:
        self._own, self._grid = own, grid
        self.counts = False
        self._newest: OccupancyMap | None = None
        self._fault = ""
        self._warnings = Bucket(_WARNINGS_PER_S, _WARNINGS_AT_ONCE)
        self._too_large = False

    def follow(self, now: float) -> bool:
        """Read the robot's map; returns whether the grid has changed [s, monotonic]."""
        self._own.advance(now)
        newer = self._own.take()
        if self._own.fault != self._fault:
            self._fault = self._own.fault
            if self._fault and self._warnings.take(1.0, now):
                _logger.warning("%s", self._fault)
        if newer is None:
            return False
        self._newest, self.counts = newer, True
        self.paint()
        return True

    def paint(self) -> None:
        """Paint the newest map, for example into a cleared grid."""
        if self._newest is None:
            return
        lost = self._grid.paint(self._newest, LOADED)
        if lost and not self._too_large:
            _logger.warning("%d cells lie outside of the map: see [mapping], key 'size'", lost)
        self._too_large = bool(lost)

    def close(self) -> None:
        """Release the robot's map."""
        self._own.close()
