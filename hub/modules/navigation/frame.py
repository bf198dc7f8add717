"""The frame of `map`: it survives a restart of navigation, and changes when the place is lost.

| remembered | dead reckoning now | frame |
| --- | --- | --- |
| the same dead reckoning | any | the remembered one, with the transform of `odom` |
| another one, or nothing | at its begin | new: named by its origin, if it has one |
| another one, or nothing | elsewhere | new and random: it may have been corrected before |
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import secrets
from dataclasses import field
from pathlib import Path

from hub import files
from hub.gcm.navigation import DriveState
from hub.pose import Pose
from hub.values import dataclass

_logger = logging.getLogger(__name__)

AT_BEGINNING = 0.01
"""Dead reckoning within this of its origin is at its begin [m, rad]."""
_MAX_BYTES = 1000
_FARTHEST = 1e6
_MOST = 2**32 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFrame:
    """The transform of a dead reckoning to `map`.

    Attributes:
        reckoning: Number of the dead reckoning; 0: the driver does not report one.
        number: Number of the frame `map`; 0: not known.
        odom: The origin of `odom` in `map`.
    """

    reckoning: int = 0
    number: int = 0
    odom: Pose = field(default_factory=Pose)


def chosen(drive: DriveState, remembered: MapFrame) -> MapFrame:
    """The frame of a dead reckoning that is new; pure."""
    if drive.reckoning == 0:
        return MapFrame()
    if drive.reckoning == remembered.reckoning:
        return remembered
    apart = (drive.x, drive.y, drive.theta)
    if max(map(abs, apart)) <= AT_BEGINNING:
        return MapFrame(reckoning=drive.reckoning, number=drive.origin or drive.reckoning)
    return MapFrame(reckoning=drive.reckoning, number=secrets.randbelow(_MOST) + 1)


class FrameMemory:
    """Remembers the frame in a file, for the next process.

    Attributes:
        frame: The present one.
    """

    def __init__(self, path: Path) -> None:
        """Read the file of the process before, if there is one."""
        self.frame = MapFrame()
        self._path = path
        self._before = _read(path)

    def reported(self, drive: DriveState) -> MapFrame | None:
        """Take a report of the driver; returns the frame if it changed."""
        if drive.reckoning == self.frame.reckoning:
            return None
        self.frame = chosen(drive, self._before)
        self._save()
        return self.frame

    def corrected(self, odom: Pose) -> None:
        """Remember a new origin of `odom` in `map`."""
        if odom != self.frame.odom:
            self.frame = MapFrame(
                reckoning=self.frame.reckoning, number=self.frame.number, odom=odom
            )
            self._save()

    def _save(self) -> None:
        frame, odom = self.frame, self.frame.odom
        self._before = frame
        values = [frame.reckoning, frame.number, odom.x, odom.y, odom.theta]
        try:
            # No fsync: the robot drives meanwhile, and another boot has another dead reckoning.
            files.replace(self._path, json.dumps(values).encode(), sync=False)
        except OSError as fault:
            _logger.warning("%s cannot be written: %s", self._path, fault.strerror or fault)


def _read(path: Path) -> MapFrame:
    """The frame in a file; none if another user wrote it, or if it is not valid."""
    with contextlib.suppress(OSError, ValueError, TypeError, OverflowError, RecursionError):
        reckoning, number, x, y, theta = json.loads(files.read_own(path, _MAX_BYTES))
        numbers = all(type(each) is int and 0 < each <= _MOST for each in (reckoning, number))
        places = all(math.isfinite(each) and abs(each) <= _FARTHEST for each in (x, y, theta))
        if numbers and places:
            odom = Pose(x=float(x), y=float(y), theta=float(theta))
            return MapFrame(reckoning=reckoning, number=number, odom=odom)
    return MapFrame()
