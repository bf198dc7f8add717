"""How a body that has tipped falls onto its side, and lies there."""

from __future__ import annotations

import math

from hub.pose import Pose
from hub.sim.spatial_pose import SpatialPose
from hub.sim.steps import GRAVITY

_RATE = 5.0
"""Rate at which a body that tips comes to lie [1/s]."""


def way_of_fall(pose: SpatialPose, reach: float, seconds: float) -> tuple[float, float]:
    """How far the middle of a body moves away from the edge over which it turns [m]."""
    up_x, up_y, _ = pose.rotation()[:, 2].tolist()
    way = _part(seconds) * max(0.0, 1.0 - math.hypot(up_x, up_y)) * _RATE * reach
    return up_x * way, up_y * way


def fallen(
    pose: SpatialPose, place: Pose, climb: float, ground: float, reach: float, seconds: float
) -> tuple[SpatialPose, float]:
    """The pose and the velocity upwards [m/s] after some time of falling to the lower side.

    Args:
        pose: The pose before.
        place: Where the body is after it.
        climb: Velocity upwards before [m/s].
        ground: Height of the ground there [m].
        reach: Height of the middle of a body that lies [m].
        seconds: The time [s].
    """
    part = _part(seconds)
    falls_ahead = abs(pose.pitch) >= abs(pose.roll)
    pitch = math.copysign(math.pi / 2, pose.pitch) if falls_ahead else 0.0
    roll = 0.0 if falls_ahead else math.copysign(math.pi / 2, pose.roll)
    climb -= GRAVITY * seconds
    z = pose.z + climb * seconds
    if z < ground + reach:
        z, climb = min(ground + reach, pose.z + part * reach), 0.0
    after = SpatialPose(
        x=place.x,
        y=place.y,
        z=z,
        roll=pose.roll + part * (roll - pose.roll),
        pitch=pose.pitch + part * (pitch - pose.pitch),
        yaw=pose.yaw,
    )
    return after, climb


def _part(seconds: float) -> float:
    return 1.0 - math.exp(-_RATE * seconds)
