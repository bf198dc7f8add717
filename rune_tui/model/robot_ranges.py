"""The newest ranges of a robot around its body: directions, ends, and room; pure."""

from __future__ import annotations

import functools
import math
from typing import Final, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from hub.gcm.beams import Beams, beams_of
from hub.gcm.body import RobotBody
from hub.gcm.ranges import RANGES, RangeReadings, too_near
from hub.values import dataclass
from rune_tui.model.body import rooms
from rune_tui.model.robot_state import RobotState
from rune_tui.model.sightings import Bools, Floats

WIDE: Final = math.radians(10.0)
"""Least opening of a wide beam: its echo may come from anywhere in the cone [rad]."""
LEVEL: Final = math.radians(10.0)
"""Beams that look farther up or down measure heights, not obstacles beside the robot [rad]."""

_SCAN_STEP: Final = math.radians(6.0)
"""Largest angle between neighbours of a scan [rad]."""
_NARROW_HALF: Final = math.radians(4.0)
"""Half the angle in which a single narrow beam counts [rad]."""

T = TypeVar("T")


class _Same(Generic[T]):
    """A key of a cache that compares values by identity: they are large and do not change."""

    __slots__ = ("value",)

    def __init__(self, value: T) -> None:
        self.value = value

    def __hash__(self) -> int:
        return id(self.value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.value is other.value


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyBeams:
    """The beams of a body; arrays have the shape (n,).

    Attributes:
        beams: Their places, directions and limits.
        level: Which of them find obstacles beside the robot.
        wide: Which of them have a wide cone.
        step: Angle from a beam to the next of its group [rad]; 0: it is alone.
        half: Half the angle in which a beam's range counts [rad].
        scans: The groups of narrow beams that are close together.
        in_scan: Which beams are in one of them.
    """

    beams: Beams
    level: Bools
    wide: Bools
    step: Floats
    half: Floats
    scans: tuple[slice, ...]
    in_scan: Bools


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotRanges:
    """The newest ranges of a robot in `base_link`; arrays have the shape (n,).

    Attributes:
        body: The robot's body.
        of: Its beams.
        ranges: The ranges [m]; inf: nothing within reach, NaN: not known. An obstacle nearer than
            a sensor can measure has the sensor's least range.
        x: End of each beam [m]; NaN if it has none.
        y: End of each beam [m]; NaN if it has none.
        room: Distance from the footprint to that end [m]; inf if the beam found no obstacle,
            0 if the obstacle is nearer than the sensor can measure.
    """

    body: RobotBody
    of: BodyBeams
    ranges: npt.NDArray[np.float32]
    x: Floats
    y: Floats
    room: Floats

    @property
    def nearest(self) -> int | None:
        """Number of the beam to the nearest obstacle; None: there is none."""
        if not len(self.room):
            return None
        number = int(self.room.argmin())
        return number if math.isfinite(self.room[number]) else None

    def bearing(self, number: int) -> float:
        """Direction of a beam's end from the robot's origin [rad]."""
        return math.atan2(self.y[number], self.x[number])


def ranges_of(robot: RobotState) -> RobotRanges | None:
    """The newest ranges of a robot; None: `lack_of_ranges` has the reason."""
    body, readings = robot.body, robot.newest(RANGES)
    if body is None or readings is None:
        return None
    return _ranges(_Same(body), _Same(readings.value))


def lack_of_ranges(robot: RobotState) -> str:
    """Why the ranges of a robot are not known, in words; empty: they are, or it has no sensors."""
    body = robot.body
    if robot.newest(RANGES) is None and (body is None or body.ranges):
        return f"no ranges from {robot.title} yet"
    return "" if body is not None else f"no description of {robot.title} yet"


@functools.lru_cache(maxsize=16)
def _beams(body: _Same[RobotBody]) -> BodyBeams:
    beams = beams_of(body.value)
    groups = body.value.ranges
    counts = [group.beams for group in groups]
    wide = beams.opening >= WIDE
    step = np.repeat([abs(each.step) if each.beams > 1 else 0.0 for each in groups], counts)
    in_scan = ~wide & (step > 0.0) & (step <= _SCAN_STEP)
    least = np.where(in_scan, step / 2.0, np.where(wide, 0.0, _NARROW_HALF))
    return BodyBeams(
        beams=beams,
        level=np.abs(beams.elevation) <= LEVEL,
        wide=wide,
        step=step,
        half=np.maximum(beams.opening / 2.0, least),
        scans=tuple(place for place in beams.groups.values() if in_scan[place].any()),
        in_scan=in_scan,
    )


@functools.lru_cache(maxsize=32)
def _ranges(body: _Same[RobotBody], readings: _Same[RangeReadings]) -> RobotRanges:
    of = _beams(body)
    ranges = of.beams.ranges(readings.value)
    hits = of.level & np.isfinite(ranges)
    reach = np.where(hits, ranges, np.nan) * np.cos(of.beams.elevation)
    x = of.beams.x + reach * np.cos(of.beams.bearing)
    y = of.beams.y + reach * np.sin(of.beams.bearing)
    room = np.full(len(ranges), np.inf)
    room[hits] = rooms(body.value, np.stack((x[hits], y[hits]), axis=1))
    room[hits & too_near(ranges, of.beams.nearest)] = 0.0
    return RobotRanges(body=body.value, of=of, ranges=ranges, x=x, y=y, room=room)
