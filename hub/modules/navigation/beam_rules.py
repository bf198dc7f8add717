"""What the beams of a body's range sensors show and hide, from its description; pure.

| beam | shows | hides |
| --- | --- | --- |
| narrow | a point | obstacles beside it, so an edge may stand between two that are far apart |
| cone | an arc, used only where it is near | the place on the arc |
| of sound | - | smooth walls at a slant: no echo does not mean that nothing is there |
| of light | that its way is free | dark surfaces: without a hit only a part of its way is free |
| any | that something is nearer than it can measure | where that is |
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.beam_scans import LARGEST_TILT
from hub.gcm.beams import Beams
from hub.gcm.body import RangeKind, RobotBody
from hub.gcm.outline import exits
from hub.pose import each_wrapped
from hub.values import dataclass

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

NARROW = 0.1
"""Largest opening of a narrow beam [rad]."""
LONGEST_ARC = 0.71
"""Longest arc of a cone that is used for obstacles [m]."""
LEAST_LASER_BEAMS = 60
"""Fewest beams of a laser whose scans correct the pose."""
LEAST_GAP = 0.17
"""Smallest angle between two narrow beams that hides an edge [rad]."""
INFRARED_SURE = 0.40
"""An infrared ray without a hit is free for this length [m], also before dark surfaces."""
RIM = 0.005
"""Assumed distance of a point at the rim from it [m]."""

_CLAMPED = 0.005
"""A range that is larger than the least one by this is the least one too [m]."""
_SAME = 1e-3
"""Bearings that differ by this are equal [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LightGroup:
    """Narrow beams of light with one origin.

    Attributes:
        place: Where they stand among all beams.
        x: Their origin in `base_link` [m].
        y: The same.
        first: Bearing of beam 0 [rad].
        step: Angle from a beam to the next [rad]; 1 for a single one.
        count: Number of beams.
    """

    place: slice
    x: float
    y: float
    first: float
    step: float
    count: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gaps:
    """Gaps between neighbouring narrow beams that may hide an edge; shape (k,) each.

    Attributes:
        one: Number of the beam on one side.
        other: Number of the beam on the other side.
        bearing: Of the middle [rad].
        rim: Distance of the outline there from the beams' origin [m].
        echoes: Which cones of sound look there, shape (k, cones).
    """

    one: npt.NDArray[np.intp]
    other: npt.NDArray[np.intp]
    bearing: Floats
    rim: Floats
    echoes: Flags


class BeamRules:
    """What to conclude from the beams; arrays have the shape (n,).

    Attributes:
        beams: The beams.
        narrow: Which ones show a point.
        cones: Numbers of the others, shape (cones,).
        sure: Free length without a hit [m]; 0: none.
        blind: Ranges up to this mean "too near to measure" [m]; 0 always does.
        rim: Distance of the outline from the beam's origin [m].
        sparse: Which ones show where nothing is, far apart from each other.
        light: The groups that show where nothing is.
        laser: The widest level one; its scans correct the pose. None: there is none.
        gaps: The gaps that may hide an edge.
    """

    def __init__(self, body: RobotBody, beams: Beams) -> None:
        self.beams = beams
        light = beams.of_kind(RangeKind.INFRARED, RangeKind.LASER)
        self.narrow = beams.opening <= NARROW
        self.cones = np.flatnonzero(~self.narrow)
        dim = beams.of_kind(RangeKind.INFRARED)
        self.sure = np.where(dim, beams.ring + INFRARED_SURE, beams.farthest)
        self.rim = exits(body, beams.x, beams.y, beams.bearing)
        # A beam that measures from inside of the outline on hides nothing.
        self.blind = np.where(beams.nearest > self.rim + RIM, beams.nearest + _CLAMPED, 0.0)
        self.light = tuple(
            _light_group(beams, place)
            for place in beams.groups.values()
            if light[place.start] and self.narrow[place.start]
        )
        # Scans of two lasers that do not look at the same walls never match each other.
        self.laser = max(
            (
                group
                for group in self.light
                if beams.kind[group.place.start] == RangeKind.LASER
                and group.count >= LEAST_LASER_BEAMS
                and abs(beams.elevation[group.place]).max() <= LARGEST_TILT
            ),
            key=lambda group: group.count * abs(group.step),
            default=None,
        )
        self.sparse = np.zeros(len(beams.kind), dtype=np.bool_)
        for group in self.light:
            self.sparse[group.place] = abs(group.step) > LEAST_GAP
        self.gaps = self._gaps_of(body)

    def _within(self, bearing: Floats, half: Floats) -> Flags:
        """Which cones look in each direction, within half an angle [rad]; shape (k, cones)."""
        off = np.abs(each_wrapped(self.beams.bearing[self.cones] - bearing[:, None]))
        return np.asarray(off <= half + _SAME)

    def _gaps_of(self, body: RobotBody) -> Gaps:
        pairs = [
            (number, (number + 1 - group.place.start) % beams + group.place.start)
            for group in self.light
            for beams in (group.count,)
            if beams > 1 and abs(group.step) > LEAST_GAP
            for number in range(group.place.start, group.place.stop)
        ]
        one, other = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        bearings = self.beams.bearing
        apart = each_wrapped(bearings[other] - bearings[one])
        # The last beam of a scan that is no whole ring has no neighbour after it.
        steps = np.zeros(len(bearings))
        for group in self.light:
            steps[group.place] = abs(group.step)
        near = np.abs(apart) < 1.5 * steps[one]
        one, other, apart = one[near], other[near], apart[near]
        middle = bearings[one] + 0.5 * apart
        sound = self.beams.of_kind(RangeKind.SONAR, RangeKind.ECHO_SOUNDER)[self.cones]
        x, y = self.beams.x[one], self.beams.y[one]
        return Gaps(
            one=one,
            other=other,
            bearing=middle,
            rim=exits(body, x, y, middle),
            echoes=self._within(middle, np.abs(apart)[:, None] * 0.5) & sound,
        )


def _light_group(beams: Beams, place: slice) -> LightGroup:
    first = float(beams.bearing[place.start])
    after = beams.bearing[place][1:2] - first
    return LightGroup(
        place=place,
        x=float(beams.x[place.start]),
        y=float(beams.y[place.start]),
        first=first,
        step=float(each_wrapped(after)[0]) if len(after) else 1.0,
        count=place.stop - place.start,
    )
