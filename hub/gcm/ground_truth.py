"""The true pose of a simulated robot: a message for tests and experiments."""

from __future__ import annotations

import math

from hub.gcm.fields import (
    Flag,
    Metres,
    Number,
    Radians,
    RadiansIfKnown,
    Seconds,
    Speed,
    TurnRate,
)
from hub.ipc.definition import MessageDefinition
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundTruth:
    """The true pose of a simulated robot; for tests and experiments, never for modules that drive.

    Attributes:
        time: Simulated time since the start [s].
        x: Position in the arena's frame [m].
        y: Position in the arena's frame [m].
        theta: Heading in the arena's frame [rad], in (-pi, pi].
        linear: True forward velocity [m/s].
        angular: True turn rate [rad/s].
        commanded_linear: Commanded forward velocity [m/s].
        commanded_angular: Commanded turn rate [rad/s].
        contacts: Number of collisions of the body since the start.
        touching: Whether it touches an obstacle now (0 or 1).
        z: Height of its centre above the arena's floor [m]; of a base on wheels, of the ground.
        roll: About x [rad], positive right side down.
        pitch: About y [rad], positive nose down.
        sway: True velocity to the left [m/s].
        heave: True velocity upward [m/s].
        contact_angle: Direction of the last collision, from straight ahead [rad], positive left;
            NaN: there was none.
        impact_speed: Speed towards the obstacle in that collision [m/s]; 0: there was none.
    """

    time: Seconds
    x: Metres
    y: Metres
    theta: Radians
    linear: Speed
    angular: TurnRate
    commanded_linear: Speed
    commanded_angular: TurnRate
    contacts: Number
    touching: Flag
    z: Metres = 0.0
    roll: Radians = 0.0
    pitch: Radians = 0.0
    sway: Speed = 0.0
    heave: Speed = 0.0
    contact_angle: RadiansIfKnown = math.nan
    impact_speed: Speed = 0.0


GROUND_TRUTH = MessageDefinition(
    name="SIM_GroundTruth",
    type=GroundTruth,
    rate_hz=50.0,
)
