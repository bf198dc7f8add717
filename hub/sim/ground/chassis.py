"""Bodies on wheels or tracks as tables of contact points.

Axes as in REP 103: x forward, y left, z up from the ground that a body stands on, in metres.
"""

from __future__ import annotations

import math

import numpy as np

from hub.sim.ground.elements import Floats
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactPoint:
    """A part of the body that can touch the ground.

    Attributes:
        x: Its middle ahead of the body's origin [m].
        y: Left of it [m].
        lowest: Its lowest point above level ground [m].
        radius: Radius of the wheel, 0 for a corner [m].
        drives: Share of its load that pushes the body: 1 for a driven wheel.
        brakes: Friction of a part that does not turn as a share of the grip; 0 for a castor.
    """

    x: float
    y: float
    lowest: float = 0.0
    radius: float = 0.0
    drives: float = 0.0
    brakes: float = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class FlipperPair:
    """Two driven flippers that turn together about an axle across the body.

    Attributes:
        axle: Ahead of the body's origin [m].
        direction: 1: they point ahead; -1: back.
        across: Distance of each from the middle line [m].
        lengths: Distances of contact points from the axle [m].
        radius: Radius of the belt's ends [m]; the axle is this high.
        limits: Least and largest angle above the ground [rad].
        speed: Largest rate [rad/s].
        home: Angle that suits most ground [rad].
    """

    axle: float
    direction: int
    across: float = 0.25
    lengths: tuple[float, ...] = (0.075, 0.15, 0.225, 0.3)
    radius: float = 0.05
    limits: tuple[float, float] = (math.radians(-60.0), math.radians(90.0))
    speed: float = 1.0
    home: float = 0.0

    def points(self, angle: float) -> list[ContactPoint]:
        """The contact points at an angle [rad]."""
        return [
            ContactPoint(
                x=self.axle + self.direction * length * math.cos(angle),
                y=side * self.across,
                lowest=length * math.sin(angle),
                radius=self.radius,
                drives=1.0,
                brakes=1.0,
            )
            for side in (1, -1)
            for length in self.lengths
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chassis:
    """A body that drives.

    Attributes:
        name: Its name.
        points: Contact points that do not move in the body.
        flippers: Pairs of flippers, from the front to the rear.
        centre_of_mass: In the body [m].
        grip: Coefficient of friction of its wheels or belts on a dry floor.
        bridge: Length over which it bridges the ground's shape ahead [m]; a belt is no row of
            points.
        reach: Radius of the circle that walls stop [m].
        height: Height of the body [m].
        mass: Mass [kg].
    """

    name: str
    points: tuple[ContactPoint, ...]
    flippers: tuple[FlipperPair, ...] = ()
    centre_of_mass: tuple[float, float, float]
    grip: float
    bridge: float
    reach: float
    height: float
    mass: float

    def contact_points(self, angles: tuple[float, ...]) -> list[ContactPoint]:
        """All contact points with flippers at these angles [rad]; their order never changes."""
        moving = [pair.points(angle) for pair, angle in zip(self.flippers, angles, strict=True)]
        return [*self.points, *(point for points in moving for point in points)]

    def middles(self, angles: tuple[float, ...]) -> Floats:
        """Middles of all contact points in the body [m], shape (3, n)."""
        points = self.contact_points(angles)
        return np.array([(p.x, p.y, p.lowest + p.radius) for p in points]).T


def _around(radius: float, lowest: float) -> list[ContactPoint]:
    """The rim of a round belly."""
    angles = (math.pi / 8 + number * math.pi / 4 for number in range(8))
    return [
        ContactPoint(x=radius * math.cos(angle), y=radius * math.sin(angle), lowest=lowest)
        for angle in angles
    ]


WHEELED = Chassis(
    name="wheeled",
    points=(
        *(ContactPoint(x=0.0, y=y, radius=0.06, drives=1.0, brakes=1.0) for y in (0.165, -0.165)),
        ContactPoint(x=-0.15, y=0.0, radius=0.03, brakes=0.0),
        ContactPoint(x=0.15, y=0.0, lowest=0.04, radius=0.03, brakes=0.2),
        *_around(0.19, 0.05),
        *(ContactPoint(x=x, y=y, lowest=0.05) for x in (-0.07, 0.07) for y in (-0.06, 0.06)),
    ),
    centre_of_mass=(-0.03, 0.0, 0.13),
    grip=0.7,
    bridge=0.006,
    reach=0.203,
    height=0.45,
    mass=18.0,
)
"""A round base: two driven wheels, a castor behind, a skid ahead."""

TRACKED = Chassis(
    name="tracked",
    points=(
        *(
            ContactPoint(x=-0.27 + 0.09 * number, y=y, radius=0.05, drives=1.0, brakes=1.0)
            for y in (0.21, -0.21)
            for number in range(7)
        ),
        *(ContactPoint(x=x, y=0.0, lowest=0.06) for x in (-0.2, 0.0, 0.2)),
    ),
    flippers=(
        FlipperPair(axle=0.27, direction=1, home=math.radians(35.0)),
        FlipperPair(axle=-0.27, direction=-1),
    ),
    centre_of_mass=(0.01, 0.0, 0.15),
    grip=0.9,
    bridge=0.1,
    reach=0.33,
    height=0.45,
    mass=35.0,
)
"""A tracked base of 0.65 by 0.5 m with two pairs of flippers of 0.3 m."""
