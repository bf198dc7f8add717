"""The track of the robot: poses in a file, written at intervals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from hub.errors import MissionFileError
from hub.missions.journal_file import JournalFile

APART = 0.1
"""Least distance [m] and turn [rad] between two poses."""
APART_RAD = math.radians(15.0)
MAX_WAITING = 5000
"""Largest number of pending poses; further ones are left out."""


class Track:
    """The track of one mission."""

    def __init__(self, path: Path) -> None:
        """Start; the file is opened at the first write."""
        self._path = path
        self._file: JournalFile | None = None
        self._waiting: list[dict[str, Any]] = []
        self._last = (math.inf, math.inf, 0.0, 0)

    def at(self, x: float, y: float, theta: float, sheet: int, stamp: float) -> None:
        """Add a pose [m, m, rad] on a sheet of the map [s since the epoch]."""
        if not all(map(math.isfinite, (x, y, theta))) or len(self._waiting) >= MAX_WAITING:
            return
        last_x, last_y, heading, last_sheet = self._last
        turned = abs(math.remainder(theta - heading, math.tau))
        stands = math.hypot(x - last_x, y - last_y) < APART and turned < APART_RAD
        if stands and sheet == last_sheet:
            return
        self._last = (x, y, theta, sheet)
        pose = {"t": round(stamp, 2), "x": round(x, 3), "y": round(y, 3), "h": round(theta, 3)}
        self._waiting.append({**pose, "s": sheet})

    def save(self) -> None:
        """Write the pending poses.

        Raises:
            MissionFileError: They cannot be written; they are kept.
        """
        if not self._waiting:
            return
        if self._file is None:
            self._file = JournalFile(self._path, sync=False)
        self._file.append(self._waiting)
        self._waiting.clear()
        self._file.sync()

    def close(self) -> None:
        """Write the pending poses, if possible, and close the file."""
        try:
            self.save()
        except MissionFileError:
            self._waiting.clear()
        if self._file is not None:
            self._file.close()
            self._file = None
