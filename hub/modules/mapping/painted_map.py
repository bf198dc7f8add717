"""Paints the map that the robot makes itself into the grid, in the place of scans."""

from __future__ import annotations

import logging

from hub.bucket import Bucket
from hub.gcm.diagnostics import Diagnostics, DiagnosticStatus, Severity
from hub.gcm.occupancy_map import OccupancyMap
from hub.modules.mapping.grid import LOADED, OccupancyGrid
from hub.robots.interfaces import OwnMap

_logger = logging.getLogger(__name__)

_LONGEST = 500
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
        self._lost = 0

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

    def problems(self) -> Diagnostics:
        """Why the robot's map is not used, or has parts that are not."""
        texts = [self._fault] if self._fault else []
        texts += [f"{self._lost} cells of the robot's own map lie outside"] if self._lost else []
        return Diagnostics(
            status=tuple(
                DiagnosticStatus(level=Severity.WARN, name="own map", message=text[:_LONGEST])
                for text in texts
            )
        )

    def paint(self) -> None:
        """Paint the newest map, for example into a cleared grid."""
        if self._newest is None:
            return
        before, self._lost = self._lost, self._grid.paint(self._newest, LOADED)
        if self._lost and not before:
            text = "%d cells lie outside of the map: see [mapping], key 'size'"
            _logger.warning(text, self._lost)

    def close(self) -> None:
        """Release the robot's map."""
        self._own.close()
