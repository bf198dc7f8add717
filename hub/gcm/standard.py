"""Parts that many messages of ROS 2 share, field for field: std_msgs and builtin_interfaces."""

from __future__ import annotations

import math
from typing import Annotated

from hub.gcm.fields import Name
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import Uint32
from hub.values import dataclass

BASE_LINK = "base_link"
"""Name of the frame of the whole body, after REP 105."""
ODOM = "odom"
"""Name of the frame of dead reckoning, which drifts."""
MAP = "map"
"""Name of the frame of the map: `odom` corrected by what the robot sees."""
_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Time:
    """builtin_interfaces/Time: a time since the epoch; for records, and to tell measurements apart.

    Attributes:
        sec: Whole seconds.
        nanosec: The rest [ns].
    """

    ros_type = "builtin_interfaces/msg/Time"

    sec: Annotated[int, Range(0, 0x7FFF_FFFF, unit="s")] = 0
    nanosec: Annotated[Uint32, Range(0, _NANOSECONDS - 1, unit="ns")] = 0

    @classmethod
    def of(cls, seconds: float) -> Time:
        """The time from seconds since the epoch; 0 where no such time exists."""
        if not 0.0 <= seconds < 0x7FFF_FFFF:
            return cls()
        whole = math.floor(seconds)
        return cls(sec=whole, nanosec=min(int((seconds - whole) * 1e9), _NANOSECONDS - 1))

    @property
    def seconds(self) -> float:
        """Seconds since the epoch."""
        return self.sec + self.nanosec * 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """std_msgs/Header.

    Attributes:
        stamp: Time of measurement.
        frame_id: Name of the frame that the values count from.
    """

    ros_type = "std_msgs/msg/Header"

    stamp: Time = Time()
    frame_id: Name = ""
