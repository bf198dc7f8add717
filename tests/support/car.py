"""A body unlike the Magellan: a long car with a laser, one sonar, and two cameras."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.body import BodyFrame, Bumper, CameraBody, Point32, RangeGroup, RangeKind, RobotBody
from hub.gcm.ranges import RangeReadings, scan_of

CAR = RobotBody(
    name="car",
    kind="car",
    radius=0.7,
    footprint=tuple(
        Point32(x=x, y=y) for x, y in ((0.6, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.6, -0.3))
    ),
    frames=(
        BodyFrame(name="laser", x=0.4, z=0.3),
        BodyFrame(name="front", x=0.6, z=0.2),
        BodyFrame(name="side", x=-0.2, y=-0.3, z=0.2, yaw=-math.pi / 2),
        BodyFrame(name="down", z=0.2, pitch=math.pi / 2),
    ),
    ranges=(
        RangeGroup(
            name="laser",
            kind=RangeKind.LASER,
            beams=360,
            first=-math.pi,
            step=math.tau / 360,
            farthest=8.0,
        ),
        RangeGroup(name="front", kind=RangeKind.SONAR, opening=math.radians(30.0), farthest=4.0),
        RangeGroup(name="side", kind=RangeKind.INFRARED, farthest=1.5),
        RangeGroup(name="down", kind=RangeKind.LASER, farthest=2.0),
    ),
    cameras=(
        CameraBody(name="front", horizontal_fov=0.8),
        CameraBody(name="rear", horizontal_fov=1.2),
    ),
    bumpers=(
        Bumper(name="front", direction=0.0, width=0.9),
        Bumper(name="back", direction=math.pi, width=1.2),
    ),
)
"""Its laser is 0.2 m behind its front, its infrared sensor looks to the right."""


def car_readings(
    laser: npt.NDArray[np.float32] | float = math.inf,
    front: float = math.inf,
    side: float = math.inf,
    down: float = 0.2,
) -> RangeReadings:
    """Readings of the car; in the open, but for those given [m]."""
    given = (laser, front, side, down)
    return RangeReadings(
        scans=tuple(
            scan_of(group, np.broadcast_to(np.float32(ranges), group.beams), 0.0)
            for group, ranges in zip(CAR.ranges, given, strict=True)
        )
    )


def laser_of(**degrees: float) -> npt.NDArray[np.float32]:
    """A scan of the car that sees nothing but at these bearings [deg], as in l90=1.0, r90=1.0."""
    ranges = np.full(360, np.inf, np.float32)
    for name, distance in degrees.items():
        ranges[180 + int(name[1:]) * (-1 if name[0] == "r" else 1)] = distance
    return ranges
