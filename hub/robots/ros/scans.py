"""Ranges of a robot with ROS, as the groups of a robot file; pure."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.gcm.body import RangeGroup
from hub.gcm.ranges import LaserScan, scan_of
from hub.ros import messages
from hub.ros.values import RosValue

Ranges = npt.NDArray[np.float32]
_READERS: Final = {"LaserScan": messages.laser_scan, "Range": messages.single_range}
_ROUNDING: Final = 1e-4


class RosRanges:
    """The newest scan of one group.

    Attributes:
        scan: The scan; before the first one, without a time and without ranges.
        measured: When it was measured [s, monotonic]; before the first one, NaN.
    """

    def __init__(self, group: RangeGroup) -> None:
        self._group = group
        self.scan: LaserScan = scan_of(group, np.full(group.beams, np.nan, np.float32), 0.0)
        self.measured = math.nan
        self._sources: tuple[tuple[float, float, int], npt.NDArray[np.intp]] | None = None

    def take(self, value: RosValue, measured: float, stamp: float) -> None:
        """Take a sensor_msgs/LaserScan or Range.

        Args:
            value: The message.
            measured: When it was measured [s, monotonic].
            stamp: The same [s since the epoch].

        Raises:
            RosMessageError: It is neither of the two, or makes no sense.
        """
        read = _READERS.get(value.name.rpartition("/")[2])
        if read is None:
            text = f"a range sensor has messages of the type {value.name[:80]}"
            raise RosMessageError(text)
        # The least range of the robot file decides: a robot may see parts of itself below that
        # of the message.
        sensor, scan = read(value, self._group.name, self._group.nearest)
        ranges = self._placed(sensor, scan.ranges)
        self.scan, self.measured = scan_of(self._group, ranges, stamp), measured

    def _placed(self, sensor: RangeGroup, ranges: Ranges) -> Ranges:
        """The ranges in the beams of the group; the nearest where several are in one."""
        group = self._group
        if sensor.beams == group.beams == 1:
            return ranges.copy()
        layout = sensor.first, sensor.step, sensor.beams
        if self._sources is None or self._sources[0] != layout:
            self._sources = layout, _places(group, sensor)
        places = self._sources[1]
        if abs(sensor.step) < abs(group.step) or group.beams == 1:
            made = np.full(group.beams + 1, np.nan, np.float32)  # the last one is for all others
            np.fmin.at(made, places, ranges)
            return made[:-1]
        padded = np.append(ranges, np.float32(np.nan))
        picked: Ranges = padded[places]
        return picked


def _places(group: RangeGroup, sensor: RangeGroup) -> npt.NDArray[np.intp]:
    """Where beams belong: of each beam of the finer one, the place in the coarser one.

    The finer one is the sensor, or the group; a beam without a place has that behind the last.
    """
    fine, coarse = (sensor, group) if abs(sensor.step) < abs(group.step) else (group, sensor)
    if group.beams == 1:
        fine, coarse = sensor, group
    directions = fine.first + fine.step * np.arange(fine.beams)
    middle = coarse.first + coarse.step * (coarse.beams - 1) / 2.0
    turned = np.remainder(directions - middle + math.pi, math.tau) - math.pi
    size = abs(coarse.step) if coarse.beams > 1 else max(coarse.opening, abs(fine.step))
    sign = math.copysign(1.0, coarse.step) if coarse.beams > 1 else 1.0
    places = np.rint(sign * turned / size + (coarse.beams - 1) / 2.0 - _ROUNDING)
    if math.isclose(size * coarse.beams, math.tau, rel_tol=0.01):  # all around
        places = np.remainder(places, coarse.beams)
    places[(places < 0) | (places >= coarse.beams)] = coarse.beams
    made: npt.NDArray[np.intp] = places.astype(np.intp)
    return made
