"""The beams of a body's range sensors as arrays; pure."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from hub.gcm.body import RangeKind, RobotBody
from hub.gcm.frames import Floats, poses_of
from hub.gcm.ranges import RangeReadings
from hub.values import dataclass

_LEVEL = 1e-9
"""A beam that falls by less than this share of its length never meets the floor."""
_COLUMNS = ("x", "y", "z", "bearing", "elevation", "opening", "ring", "nearest", "farthest")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beams:
    """All beams of a body's range sensors in `base_link`, in the order of its description.

    A range counts from (x, y, z) along the beam. Arrays have the shape (n,).

    Attributes:
        x: Origin of the ranges [m].
        y: Origin of the ranges [m].
        z: Origin of the ranges [m].
        bearing: Direction, seen from above [rad], counter-clockwise from x.
        elevation: Angle above the xy-plane [rad].
        opening: Whole angle of the cone [rad].
        ring: Distance of the sensor itself from the origin of its ranges [m].
        nearest: Least range [m].
        farthest: Largest range [m].
        kind: The `RangeKind`.
        groups: Name of each group, and where its beams are.
    """

    x: Floats
    y: Floats
    z: Floats
    bearing: Floats
    elevation: Floats
    opening: Floats
    ring: Floats
    nearest: Floats
    farthest: Floats
    kind: npt.NDArray[np.uint8]
    groups: Mapping[str, slice]

    def of_kind(self, *kinds: RangeKind) -> npt.NDArray[np.bool_]:
        """Which beams are of one of these kinds, shape (n,)."""
        return np.isin(self.kind, kinds)

    def hits(
        self, numbers: npt.NDArray[np.intp], ranges: Floats, aside: Floats | float = 0.0
    ) -> tuple[Floats, Floats]:
        """Points on some beams, seen from above.

        Args:
            numbers: Of the beams, shape (k,).
            ranges: Of all beams, finite for these [m], shape (n,).
            aside: Angles between each beam and its point [rad], shape (k,).

        Returns:
            Ahead and left [m], shape (k,).
        """
        away, bearing = ranges[numbers], self.bearing[numbers] + aside
        return self.x[numbers] + away * np.cos(bearing), self.y[numbers] + away * np.sin(bearing)

    def heights(self, roll: float, pitch: float) -> tuple[Floats, Floats]:
        """How the beams stand over the level plane through the origin of a body that leans.

        Args:
            roll: Of the body [rad], positive right side down.
            pitch: Of the body [rad], positive nose down.

        Returns:
            Height of each origin [m], and the sine of each beam's angle above that plane; shape
            (n,) each.
        """
        ahead = -math.sin(pitch)
        left, up = math.cos(pitch) * math.sin(roll), math.cos(pitch) * math.cos(roll)
        flat = np.cos(self.elevation)
        rise = ahead * flat * np.cos(self.bearing) + left * flat * np.sin(self.bearing)
        return ahead * self.x + left * self.y + up * self.z, rise + up * np.sin(self.elevation)

    def to_floor(self, roll: float = 0.0, pitch: float = 0.0, error: float = 0.0) -> Floats:
        """The range at which each beam may meet a level floor [m], shape (n,); inf: it does not.

        Args:
            roll: Of the body [rad].
            pitch: Of the body [rad].
            error: How much lower a beam may look than these say [rad].
        """
        height, rise = self.heights(roll, pitch)
        fall = np.sin(error) - rise
        reach = np.full(len(fall), np.inf)
        np.divide(np.maximum(height, 0.0), fall, out=reach, where=fall > _LEVEL)
        return reach

    def ranges(self, readings: RangeReadings) -> npt.NDArray[np.float32]:
        """The range of each beam [m], shape (n,); NaN where the readings have none."""
        ranges = np.full(len(self.kind), np.nan, np.float32)
        for scan in readings.scans:
            place = self.groups.get(scan.header.frame_id)
            if place is not None and place.stop - place.start == len(scan.ranges):
                ranges[place] = scan.ranges
        return ranges


@functools.lru_cache(maxsize=16)
def beams_of(body: RobotBody) -> Beams:
    """The beams of a body; its arrays must not be changed."""
    poses = poses_of(body.frames)
    parts: dict[str, list[Floats]] = {name: [] for name in _COLUMNS}
    kinds: list[npt.NDArray[np.uint8]] = []
    groups: dict[str, slice] = {}
    count = 0
    for group in body.ranges:
        turn, place = poses.get(group.name, (np.eye(3), np.zeros(3)))
        angles = group.first + group.step * np.arange(group.beams)
        directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(group.beams)])
        ahead, left, up = turn @ directions
        columns = (
            *place,
            np.arctan2(left, ahead),
            np.arcsin(np.clip(up, -1.0, 1.0)),
            group.opening,
            group.ring,
            group.nearest,
            group.farthest,
        )
        for name, column in zip(_COLUMNS, columns, strict=True):
            parts[name].append(np.broadcast_to(column, group.beams))
        kinds.append(np.full(group.beams, group.kind, np.uint8))
        groups[group.name] = slice(count, count + group.beams)
        count += group.beams
    arrays = {name: np.concatenate([np.empty(0), *each]) for name, each in parts.items()}
    for array in arrays.values():
        array.flags.writeable = False
    return Beams(kind=np.concatenate([np.empty(0, np.uint8), *kinds]), groups=groups, **arrays)
