"""The message of range sensors; `GCM_RobotDescription` has their places, cones and limits.

Drivers say what a sensor found in many ways. `as_measured` decides once what each value means:

| a sensor says | it means | the message has |
| --- | --- | --- |
| a number between its limits | an obstacle, at that range | the number |
| -inf (REP 117), or a number below the least range | an obstacle, nearer | the least range |
| +inf, or a number above the largest range | nothing within reach | +inf |
| NaN, 0, or a negative number | not measured | NaN |

A sensor with a fixed distance (sensor_msgs/Range with equal limits) says -inf for an obstacle.
"""

from __future__ import annotations

from typing import Annotated, Final, TypeAlias

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
_ROUNDING: Final = 1e-4
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
            NaN: not measured. The least range means: an obstacle, that far away or nearer.
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

LEAST_M: Final = 1e-3
"""Least range of an obstacle before a sensor that has no least range [m]: 0 is not measured."""


def as_measured(
    said: npt.NDArray[np.float32], nearest: float, farthest: float
) -> npt.NDArray[np.float32]:
    """What sensors found, from what their drivers say; the table above has the rules.

    Args:
        said: What they say [m], shape (n,).
        nearest: Their least range [m].
        farthest: Their largest range [m].

    Returns:
        Ranges [m], shape (n,).
    """
    least = np.float32(max(nearest, LEAST_M))
    ranges = np.where(np.isneginf(said) | ((said > 0.0) & (said < least)), least, said)
    ranges[ranges <= 0.0] = np.nan
    # Of a sensor with a fixed distance the least range is the largest one too.
    ranges[(ranges > farthest) & (ranges > least)] = np.inf
    ranges.flags.writeable = False  # all readers share them
    return ranges


def too_near(
    ranges: npt.NDArray[np.floating], nearest: npt.NDArray[np.float64]
) -> npt.NDArray[np.bool_]:
    """Which ranges say that an obstacle is nearer than the sensor can measure.

    Args:
        ranges: Ranges of a message [m], shape (n,).
        nearest: The least range of each beam [m], shape (n,).

    Returns:
        Flags of the shape (n,).
    """
    # The message has numbers of 32 bits.
    return np.asarray(ranges <= np.maximum(nearest, LEAST_M) + _ROUNDING)


def scan_of(group: RangeGroup, ranges: npt.NDArray[np.float32], stamp: float) -> LaserScan:
    """The scan of a group at a time.

    Args:
        group: The group.
        ranges: What its driver says [m], shape (beams,); see `as_measured`.
        stamp: When it measured them [s since the epoch].
    """
    return LaserScan(
        header=Header(stamp=Time.of(stamp), frame_id=group.name),
        angle_min=group.first,
        angle_max=group.first + group.step * (group.beams - 1),
        angle_increment=group.step,
        scan_time=1.0 / group.rate_hz if group.rate_hz else 0.0,
        range_min=group.nearest,
        range_max=group.farthest,
        ranges=as_measured(ranges, group.nearest, group.farthest),
        intensities=_NONE,
    )
