"""The robot's outline on the ground, its bumpers, and what its body can have."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from hub.gcm.body import Bumper, RobotBody
from hub.gcm.capability import Capability
from rune_tui.model.robot_state import RobotState
from rune_tui.model.sightings import Floats

_OF_PARTS: Final[Mapping[str, Callable[[RobotBody], object]]] = {
    Capability.DRV_HOLD.value: lambda body: body.holds,
    Capability.DRV_LIGHT.value: lambda body: body.lights,
    Capability.DRV_JOINT.value: lambda body: body.joints,
    Capability.DRV_ARM.value: lambda body: body.arms,
    Capability.DRV_MODE.value: lambda body: body.arms,
}
"""The capabilities that only a body with certain parts has, and those parts."""


def largest_radius(body: RobotBody | None) -> float:
    """Radius of the circle around the whole robot, at least to its corners [m]; 0: not known."""
    if body is None:
        return 0.0
    return max(body.radius, *(math.hypot(each.x, each.y) for each in body.footprint), 0.0)


def corners(body: RobotBody | None) -> Floats:
    """Corners of the robot's footprint in its frame [m], shape (n, 2).

    n is 0 if the footprint is a circle, is not known, or has two corners only.
    """
    points = body.footprint if body is not None and len(body.footprint) > 2 else ()
    return np.array([(point.x, point.y) for point in points], np.float64).reshape(-1, 2)


def rooms(body: RobotBody, points: Floats) -> Floats:
    """Distance from the robot's footprint to each point [m], shape (n,); 0 inside of it.

    Args:
        body: The robot's body.
        points: Points in its frame [m], shape (n, 2).
    """
    around = corners(body)
    if not len(around):
        away: Floats = np.hypot(points[:, 0], points[:, 1]) - largest_radius(body)
        return np.maximum(away, 0.0)
    # Axis 0 has the points, axis 1 the edges from p to p + e.
    p, e = around, np.roll(around, -1, axis=0) - around
    from_p = points[:, None, :] - p
    length = np.maximum((e * e).sum(axis=1), np.finfo(np.float64).tiny)
    along = np.clip((from_p * e).sum(axis=2) / length, 0.0, 1.0)
    off = from_p - along[..., None] * e
    nearest = np.hypot(off[..., 0], off[..., 1]).min(axis=1)
    # A point is inside if a ray from it to the left crosses an odd number of edges.
    low, high = p[:, 1] > points[:, 1:2], np.roll(p[:, 1], -1) > points[:, 1:2]
    across = from_p[..., 0] * e[:, 1] - from_p[..., 1] * e[:, 0]
    crossed = (low != high) & ((across > 0.0) == (e[:, 1] > 0.0))
    outside = crossed.sum(axis=1) % 2 == 0
    distances: Floats = np.where(outside, nearest, 0.0)
    return distances


def pressed_bumpers(body: RobotBody | None, bits: int) -> tuple[Bumper, ...]:
    """The bumpers that are pressed.

    Args:
        body: The robot's body; None: its bumpers are not known.
        bits: `bumpers` of the robot's state.
    """
    bumpers = body.bumpers if body is not None else ()
    return tuple(each for number, each in enumerate(bumpers) if bits >> number & 1)


def lacks(robot: RobotState, message: str) -> bool:
    """Whether the robot's body measures nothing for a message, and none arrived."""
    brought = {each.message for each in robot.body.messages} if robot.body is not None else set()
    return bool(brought) and message not in brought and message not in robot.messages


def can_have(body: RobotBody | None, capability: str) -> bool:
    """Whether a body has the parts of a capability."""
    parts = _OF_PARTS.get(capability)
    return parts is None or (body is not None and bool(parts(body)))
