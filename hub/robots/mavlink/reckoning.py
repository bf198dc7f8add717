"""The dead reckoning of a vehicle: its own place, or the sum of velocities where it has none; pure.

| state | event | its number |
| --- | --- | --- |
| no place | the vehicle knows its place, from satellites | of its origin, also after a restart |
| no place | it knows its place otherwise | a new one |
| place | its place is no longer known, or comes no more for 1 s | a new one |
| any | it was booted | a new one |
"""

from __future__ import annotations

import math
import secrets
import struct
import zlib
from typing import Final

from hub.pose import Pose
from hub.robots.mavlink.profiles.profile import Setpoint
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.sim.kinematics import moved

_FRESH_S: Final = 1.0
_NO_SATELLITES: Final = (0, 255)
_MOST: Final = 2**32 - 1


class VehicleReckoning:
    """The pose of one vehicle in `odom`.

    Attributes:
        pose: The pose.
        number: Number of the dead reckoning, from 1; 0: it has not begun.
        has_place: Whether the pose is the vehicle's own.
    """

    def __init__(self) -> None:
        self.pose = Pose()
        self.number = 0
        self.has_place = False
        self._of: Telemetry | None = None

    def update(self, read: Telemetry, wanted: Setpoint, seconds: float, now: float) -> None:
        """Let time pass.

        Args:
            read: What the vehicle measures; another object after each of its starts.
            wanted: The velocity that it follows.
            seconds: The time since the last call [s].
            now: Monotonic time [s].
        """
        has_place = read.position and now - read.placed <= _FRESH_S and not math.isnan(read.x)
        if read is not self._of or has_place is not self.has_place:
            self._of, self.has_place = read, has_place
            self.number = _number(read) if has_place else _random()
        theta = self.pose.theta if math.isnan(read.yaw) else read.yaw
        if has_place:
            self.pose = Pose(x=read.x, y=read.y, theta=theta)
            return
        turned = math.remainder(theta - self.pose.theta, math.tau)
        if math.isnan(read.yaw):
            turned = wanted.turn * seconds
        self.pose = moved(self.pose, wanted.ahead * seconds, turned, wanted.left * seconds)


def _number(read: Telemetry) -> int:
    if read.origin is None or read.satellites in _NO_SATELLITES:
        return _random()
    return zlib.crc32(struct.pack("<3i", *read.origin)) or 1


def _random() -> int:
    return secrets.randbelow(_MOST) + 1
