"""How wheels follow commands and move a wheeled base; pure."""

from __future__ import annotations

import math

from hub.pose import Pose, wrapped
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Accelerations:
    """How fast a velocity may change.

    Attributes:
        speeding_up: Away from zero [m/s^2 or rad/s^2].
        braking: Towards zero [m/s^2 or rad/s^2].
    """

    speeding_up: float
    braking: float


LINEAR = Accelerations(speeding_up=1.0, braking=2.0)
"""Largest braking [m/s^2]: from 0.5 m/s the robot stops after 0.25 s and 6 cm."""
ANGULAR = Accelerations(speeding_up=2.0, braking=4.0)


def limited(value: float, limit: float) -> float:
    """The value within plus and minus the limit; 0 for NaN."""
    return 0.0 if math.isnan(value) else max(-limit, min(limit, value))


def approach(velocity: float, target: float, accelerations: Accelerations, seconds: float) -> float:
    """The velocity after some time of change to the target; a reversal passes through zero."""
    remaining = seconds
    goal = target if velocity * target > 0.0 else 0.0
    if abs(velocity) > abs(goal):
        needed = (abs(velocity) - abs(goal)) / accelerations.braking
        if needed > remaining:
            return velocity - math.copysign(accelerations.braking * remaining, velocity)
        velocity = goal
        remaining -= needed
    gain = accelerations.speeding_up * remaining
    return velocity + max(-gain, min(gain, target - velocity))


def moved(pose: Pose, distance: float, turn: float, sideways: float = 0.0) -> Pose:
    """The pose after an arc of the given length [m] and turn [rad].

    Args:
        pose: The pose before.
        distance: Ahead, along the arc [m].
        turn: Counter-clockwise [rad].
        sideways: To the left, along the arc [m].
    """
    half = turn / 2.0
    chord = math.sin(half) / half if abs(half) > 1e-9 else 1.0
    cosine, sine = math.cos(pose.theta + half), math.sin(pose.theta + half)
    return Pose(
        x=pose.x + chord * (distance * cosine - sideways * sine),
        y=pose.y + chord * (distance * sine + sideways * cosine),
        theta=wrapped(pose.theta + turn),
    )
