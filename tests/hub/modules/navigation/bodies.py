"""A body that is no robot of ours: long, with a laser upside down, seven other ranges and sway."""

from __future__ import annotations

import math

from hub.gcm.body import (
    BodyFrame,
    Bumper,
    Freedom,
    Motion,
    Point32,
    RangeGroup,
    RangeKind,
    RobotBody,
)

HALF_LENGTH, HALF_WIDTH = 0.45, 0.2
LASER = RangeGroup(
    name="laser",
    kind=RangeKind.LASER,
    beams=360,
    first=-math.pi,
    step=math.tau / 360,
    nearest=0.06,
    farthest=8.0,
)
_SONARS = tuple(
    (name, x, y, math.radians(yaw))
    for name, x, y, yaw in (
        ("left", 0.0, HALF_WIDTH, 90.0),
        ("right", 0.0, -HALF_WIDTH, -90.0),
        ("rear", -HALF_LENGTH, 0.0, 180.0),
        ("front left", HALF_LENGTH, 0.1, 15.0),
        ("front right", HALF_LENGTH, -0.1, -15.0),
    )
)
LONG = RobotBody(
    name="plank",
    kind="test",
    radius=math.hypot(HALF_LENGTH, HALF_WIDTH),
    footprint=tuple(
        Point32(x=x * HALF_LENGTH, y=y * HALF_WIDTH)
        for x, y in ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0))
    ),
    motions=(
        Motion(freedom=Freedom.SURGE, limit=0.5, acceleration=2.0),
        Motion(freedom=Freedom.SWAY, limit=0.3, acceleration=2.0),
        Motion(freedom=Freedom.YAW, limit=1.0, acceleration=4.0),
    ),
    frames=(
        BodyFrame(name="laser", x=0.3, z=0.3, roll=math.pi, yaw=math.pi / 2.0),
        *(BodyFrame(name=name, x=x, y=y, z=0.1, yaw=yaw) for name, x, y, yaw in _SONARS),
        BodyFrame(name="floor", x=0.45, z=0.2, pitch=math.radians(30.0)),
        BodyFrame(name="mast", x=0.0, z=0.5),
    ),
    ranges=(
        LASER,
        *(
            RangeGroup(name=name, kind=RangeKind.SONAR, opening=0.5, nearest=0.02, farthest=3.0)
            for name, *_ in _SONARS
        ),
        RangeGroup(name="floor", kind=RangeKind.INFRARED, nearest=0.1, farthest=0.8),
        RangeGroup(name="mast", kind=RangeKind.INFRARED, nearest=0.7, farthest=1.5),
    ),
    bumpers=(Bumper(name="front", direction=0.0, width=0.8),),
)
