"""Which frame `map` is: the same after navigation began anew, another when the place is lost.

| what is remembered | the dead reckoning | the frame |
| --- | --- | --- |
| the same dead reckoning | any | as remembered, and how `odom` lies in it |
| another one, or nothing | at its beginning | new: its origin, or it where it has none |
| another one, or nothing | elsewhere | new and random: it may have been corrected before |
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import os
import secrets
from dataclasses import dataclass, field
from pathlib import Path

from hub import files
from hub.gcm.navigation import DriveState
from hub.pose import Pose

_logger = logging.getLogger(__name__)

AT_BEGINNING = 0.01
"""Dead reckoning that is no farther from its origin [m, rad] has not been corrected yet."""
_MAX_BYTES = 1000
_FARTHEST = 1e6
_MOST = 2**32 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFrame:
    """How a dead reckoning lies in `map`.

    Attributes:
        odometry: Number of the dead reckoning; 0: the driver does not tell.
        number: Number of the frame `map`; 0: not known.
        odom: The origin of `odom` in `map`.
    """

    odometry: int = 0
    number: int = 0
    odom: Pose = field(default_factory=Pose)


def chosen(drive: DriveState, remembered: MapFrame) -> MapFrame:
    """The frame in which a dead reckoning begins that was not heard of before; pure."""
    if drive.odometry == 0:
        return MapFrame()
    if drive.odometry == remembered.odometry:
        return remembered
    apart = (drive.x, drive.y, drive.theta)
    if max(map(abs, apart)) <= AT_BEGINNING:
        return MapFrame(odometry=drive.odometry, number=drive.origin or drive.odometry)
    return MapFrame(odometry=drive.odometry, number=secrets.randbelow(_MOST) + 1)


class FrameMemory:
    """Remembers the frame in a file, for this process's successor.

    Attributes:
        frame: The present one.
    """

    def __init__(self, path: Path) -> None:
        """Read what the process before has left, if anything."""
        self.frame = MapFrame()
        self._path = path
        self._before = _read(path)

    def reported(self, drive: DriveState) -> MapFrame | None:
        """The driver has reported; returns the new frame if there is one."""
        if drive.odometry == self.frame.odometry:
            return None
        self.frame = chosen(drive, self._before)
        self._save()
        return self.frame

    def corrected(self, odom: Pose) -> None:
        """`odom` lies so in `map`."""
        if odom != self.frame.odom:
            self.frame = MapFrame(odometry=self.frame.odometry, number=self.frame.number, odom=odom)
            self._save()

    def _save(self) -> None:
        frame, odom = self.frame, self.frame.odom
        self._before = frame
        values = [frame.odometry, frame.number, odom.x, odom.y, odom.theta]
        try:
            # Not waited for: the robot drives meanwhile, and another boot has other odometry.
            files.replace(self._path, json.dumps(values).encode(), sync=False)
        except OSError as fault:
            _logger.warning("%s cannot be written: %s", self._path, fault.strerror or fault)


def _read(path: Path) -> MapFrame:
    """What a file holds; nothing where it is not ours, or makes no sense."""
    with contextlib.suppress(OSError, ValueError, TypeError, OverflowError, RecursionError):
        file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            ours = os.fstat(file).st_uid == os.getuid()
            raw = os.read(file, _MAX_BYTES)
        finally:
            os.close(file)
        odometry, number, x, y, theta = json.loads(raw)
        numbers = all(type(each) is int and 0 < each <= _MOST for each in (odometry, number))
        places = all(math.isfinite(each) and abs(each) <= _FARTHEST for each in (x, y, theta))
        if ours and numbers and places:
            odom = Pose(x=float(x), y=float(y), theta=float(theta))
            return MapFrame(odometry=odometry, number=number, odom=odom)
    return MapFrame()
