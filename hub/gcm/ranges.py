"""The message of range sensors; `GCM_RobotDescription` has their places, cones and limits."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.gcm.body import MOST_BEAMS, MOST_PARTS, RangeGroup
from hub.gcm.fields import Ranges
from hub.gcm.standard import Header, Time
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Counted, Sequence
from hub.values import dataclass

_Angle: TypeAlias = Annotated[float, Range(-100.0, 100.0, unit="rad"), FLOAT32]
_Duration: TypeAlias = Annotated[float, Range(0.0, 1e6, unit="s"), FLOAT32]
_Reach: TypeAlias = Annotated[float, Range(0.0, 1e6, unit="m"), FLOAT32]
_NONE: npt.NDArray[np.float32] = np.empty(0, np.float32)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaserScan:
    """sensor_msgs/LaserScan: the ranges of equal sensors, or of the beams of one.

    Attributes:
        header: When they were measured, and the name of their frame.
        angle_min: Direction of the first beam in the frame's xy-plane [rad].
        angle_max: Direction of the last [rad].
        angle_increment: From a beam to the next [rad], positive counter-clockwise.
        time_increment: From a beam to the next [s].
        scan_time: From a scan to the next [s].
        range_min: Least range [m].
        range_max: Largest range [m].
        ranges: Each range from the frame's origin [m], shape (n,); inf: nothing within reach,
            NaN: not measured.
        intensities: Strength of each echo, shape (n,), in units of the device; none: not measured.
    """

    ros_type = "sensor_msgs/msg/LaserScan"

    header: Header
    angle_min: _Angle = 0.0
    angle_max: _Angle = 0.0
    angle_increment: _Angle = 0.0
    time_increment: _Duration = 0.0
    scan_time: _Duration = 0.0
    range_min: _Reach = 0.0
    range_max: _Reach
    ranges: Annotated[Ranges, Sequence(), Most(MOST_BEAMS)]
    intensities: Annotated[npt.NDArray[np.float32], Sequence(), Most(MOST_BEAMS)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RangeReadings:
    """The newest scan of each group of range sensors.

    Attributes:
        scans: The scans, in the order of the groups in `RobotBody.ranges`.
    """

    scans: Annotated[tuple[LaserScan, ...], Counted(), Most(MOST_PARTS)]


RANGES = MessageDefinition(name="GCM_Ranges", type=RangeReadings, rate_hz=10.0)
"""Sent as soon as one of the groups has measured."""

MESSAGES = (RANGES,)


def scan_of(group: RangeGroup, ranges: npt.NDArray[np.float32], stamp: float) -> LaserScan:
    """The scan of a group that measured these ranges [m] at `stamp` [s since the epoch]."""
    return LaserScan(
        header=Header(stamp=Time.of(stamp), frame_id=group.name),
        angle_min=group.first,
        angle_max=group.first + group.step * (group.beams - 1),
        angle_increment=group.step,
        scan_time=1.0 / group.rate_hz if group.rate_hz else 0.0,
        range_min=group.nearest,
        range_max=group.farthest,
        ranges=ranges,
        intensities=_NONE,
    )
