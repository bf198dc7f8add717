"""Which range sensors are silent, so that navigation does not count on what they showed; pure.

| state | event | next state |
| --- | --- | --- |
| HEARD | no new measurement for five periods, at least 0.5 s | SILENT |
| SILENT | a new measurement | HEARD |

Each group starts as HEARD, with the first report of the driver. A scan without any number is no
measurement. Groups with a rate of 0 measure when they want to.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from hub.gcm.beam_scans import LARGEST_TILT
from hub.gcm.beams import Beams
from hub.gcm.body import RangeGroup
from hub.gcm.ranges import RangeReadings
from hub.gcm.standard import Time

PERIODS = 5
"""A group is silent when this number of measurements is missing."""
LEAST_S = 0.5
"""Least time without a measurement after which a group is silent [s]."""


class RangeWatch:
    """Keeps the times of the last measurements; every method gets the monotonic time [s].

    Attributes:
        silent: The groups that are silent, and for how long [s].
        beams: Which beams are silent, shape (n,).
        blind: Whether no group that looks along the ground measures, although there are some.
    """

    def __init__(self, groups: Sequence[RangeGroup], beams: Beams) -> None:
        """Wait for the first report of the driver.

        Args:
            groups: The range sensors of the body.
            beams: Their beams.
        """
        self._longest = {
            group.name: max(LEAST_S, PERIODS / group.rate_hz) for group in groups if group.rate_hz
        }
        self._places = beams.groups
        level = np.abs(beams.elevation) <= LARGEST_TILT
        self._level = {name for name, place in beams.groups.items() if level[place].any()}
        self._stamps: dict[str, Time] = {}
        self._heard: dict[str, float] = {}
        self.silent: Mapping[str, float] = {}
        self.beams: npt.NDArray[np.bool_] = np.zeros(len(level), dtype=np.bool_)
        self.blind = False

    def heard(self, readings: RangeReadings, now: float) -> None:
        """Take the newest scans."""
        for scan in readings.scans:
            name, stamp = scan.header.frame_id, scan.header.stamp
            # A driver without a clock stamps all its scans with 0.
            is_new = stamp != self._stamps.get(name) or stamp == Time()
            if is_new and not np.isnan(scan.ranges).all():
                self._stamps[name], self._heard[name] = stamp, now

    def look(self, now: float) -> None:
        """The driver reports: find the groups that are silent."""
        silent = {
            name: now - at
            for name, longest in self._longest.items()
            if (at := self._heard.setdefault(name, now)) <= now - longest
        }
        if silent.keys() != self.silent.keys():
            self.beams[:] = False
            for name in silent:
                self.beams[self._places[name]] = True
            self.blind = bool(self._level) and self._level <= silent.keys()
        self.silent = silent
