"""How a body stands on the ground: its resting pose, its loads, and how far it tips."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.ground.chassis import Chassis
from hub.sim.ground.elements import Floats
from hub.sim.ground.height_field import HeightField
from hub.sim.ground.resting import RestingPlane, Triangle, resting_plane
from hub.sim.ground.rolling import RollingGround
from hub.sim.spatial_pose import SpatialPose
from hub.values import dataclass

TIPPED = math.atan(1.3)
"""A body that leans more than this does not come back [rad], about 52 degrees."""
_ROUNDS = 60
_SURE_ROUNDS = 8
"""From this round on, half of each correction is made, so that it ends."""
_AT_REST = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class Stance:
    """How a body would rest at a place.

    Attributes:
        z: Height of its origin [m].
        roll: As in `SpatialPose` [rad].
        pitch: As in `SpatialPose` [rad].
        steepness: Slope of its underside [m/m].
        downhill: Unit vector of the way down; (0, 0) on level ground.
        rise: How much higher the centre of mass is at the other place [m].
        lowest_z: Least z with which no contact point is below ground at the present lean [m].
        driven_load: Share of the weight on driven contacts.
        push: The same, weighed by the ground's grip.
        hold: Share of the weight that brakes hold, weighed by the ground's grip.
        drag: Share of the weight that parts drag over the ground which do not turn, weighed alike.
        triangle: The contact points that carry.
        loads: The share of the weight on each of them.
    """

    z: float
    roll: float
    pitch: float
    steepness: float
    downhill: tuple[float, float]
    rise: float
    lowest_z: float
    driven_load: float
    push: float
    hold: float
    drag: float
    triangle: Triangle
    loads: tuple[float, float, float]


class Footing:
    """The contact points of one body on one ground."""

    def __init__(self, field: HeightField, chassis: Chassis, angles: tuple[float, ...]) -> None:
        points = chassis.contact_points(angles)
        self._chassis = chassis
        self._radii = np.array([point.radius for point in points])
        self._drives = [point.drives for point in points]
        self._brakes = [point.brakes for point in points]
        self._ground = RollingGround(field, self._radii)
        self._field = field
        self._centre = np.array(chassis.centre_of_mass)
        self._triangle: Triangle | None = None
        self.turn_flippers(angles)

    def turn_flippers(self, angles: tuple[float, ...]) -> None:
        """Move the contact points of the flippers to these angles [rad]."""
        self._middles = self._chassis.middles(angles)

    def stance(self, pose: SpatialPose, other: SpatialPose | None = None) -> Stance | None:
        """How the body would rest at its place; None: it tips.

        The pose gives the lean from which the resting pose is sought. One call finds it where the
        lean changes little; `settled` repeats it.

        Args:
            pose: The present pose.
            other: Another pose of the same lean, for the rise to it.
        """
        rotation = pose.rotation()
        points = rotation @ self._middles
        centre_x, centre_y, _ = (rotation @ self._centre).tolist()
        x, y, z = points[0] + pose.x, points[1] + pose.y, points[2] + pose.z
        turned = points
        if other is not None:
            if other.yaw != pose.yaw:
                turned = other.rotation() @ self._middles
            x = np.concatenate((x, turned[0] + other.x))
            y = np.concatenate((y, turned[1] + other.y))
            z = np.concatenate((z, z))
        support, grip = self._ground.supports(x, y, z)
        count = len(self._radii)
        reach = self._radii - points[2]
        heights = support[:count] + reach
        plane = resting_plane(points[0], points[1], heights, (centre_x, centre_y), self._triangle)
        if plane is None:
            return None
        self._triangle = plane.triangle
        rise = 0.0
        if other is not None and not np.array_equal(support[:count], support[count:]):
            turn = other.yaw - pose.yaw
            cosine, sine = math.cos(turn), math.sin(turn)
            there = centre_x * cosine - centre_y * sine, centre_x * sine + centre_y * cosine
            ahead = resting_plane(
                turned[0], turned[1], support[count:] + reach, there, plane.triangle
            )
            # The same points hold the same centre of mass, so there is always a plane.
            height = plane.above(centre_x, centre_y)
            rise = 0.0 if ahead is None else ahead.above(*there) - height
        upright = rotation[:, 2].tolist()
        return self._stance(plane, upright, pose.yaw, rise, float(heights.max()), grip)

    def _stance(
        self,
        plane: RestingPlane,
        upright: list[float],
        yaw: float,
        rise: float,
        lowest_z: float,
        grip: Floats,
    ) -> Stance:
        # The plane says by which small turn the body comes to rest; it turns the body's axis.
        up_x, up_y, up_z = upright
        new_x, new_y = up_x - plane.east * up_z, up_y - plane.north * up_z
        new_z = up_z + plane.east * up_x + plane.north * up_y
        cosine, sine = math.cos(yaw), math.sin(yaw)
        along, left = new_x * cosine + new_y * sine, new_y * cosine - new_x * sine
        length = math.sqrt(along * along + left * left + new_z * new_z)
        level = math.hypot(new_x, new_y)
        driven_load = push = hold = drag = 0.0
        for load, corner in zip(plane.loads, plane.triangle, strict=True):
            drives, held = self._drives[corner], load * float(grip[corner])
            braked = held * self._brakes[corner]
            driven_load += load * drives
            push += held * drives
            hold += braked
            drag += 0.0 if drives else braked
        return Stance(
            z=plane.height,
            roll=math.asin(max(-1.0, min(1.0, -left / length))),
            pitch=math.atan2(along, new_z),
            steepness=level / max(new_z, 1e-9),
            downhill=(new_x / level, new_y / level) if level > 0.0 else (0.0, 0.0),
            rise=rise,
            lowest_z=lowest_z,
            driven_load=driven_load,
            push=push,
            hold=hold,
            drag=drag,
            triangle=plane.triangle,
            loads=plane.loads,
        )

    def settled(self, x: float, y: float, yaw: float, z: float | None = None) -> SpatialPose | None:
        """The pose at rest at a place; None: the body tips there.

        Args:
            x: The place [m].
            y: The same [m].
            yaw: The heading [rad].
            z: Height from which the body comes [m], for decks; None: the ground's.
        """
        height = self._field.height(x, y) if z is None else z
        pose = SpatialPose(x=x, y=y, z=height, yaw=yaw)
        self._triangle = None
        for number in range(_ROUNDS):
            stance = self.stance(pose)
            if stance is None:
                return None
            part = 1.0 if number < _SURE_ROUNDS else 0.5
            change = max(abs(stance.roll - pose.roll), abs(stance.pitch - pose.pitch))
            pose = SpatialPose(
                x=x,
                y=y,
                z=stance.z,
                roll=pose.roll + part * (stance.roll - pose.roll),
                pitch=pose.pitch + part * (stance.pitch - pose.pitch),
                yaw=yaw,
            )
            if pose.lean > TIPPED:
                return None
            if change < _AT_REST:
                break
        stance = self.stance(pose)
        if stance is None:
            return None
        return SpatialPose(x=x, y=y, z=stance.lowest_z, roll=pose.roll, pitch=pose.pitch, yaw=yaw)

    def loads(self, stance: Stance) -> Floats:
        """The share of the weight on every contact point, shape (n,)."""
        shares = np.zeros(len(self._radii))
        shares[list(stance.triangle)] = stance.loads
        return shares
