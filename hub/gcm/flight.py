"""Messages of robots that tilt, fly or dive; frames as in `hub.gcm.navigation`."""

from __future__ import annotations

import math

from hub.gcm.fields import MetresIfKnown, Radians, RadiansIfKnown, SpeedIfKnown, Stamp
from hub.ipc.definition import MessageDefinition
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Attitude:
    """The tilt of the robot: the rotations from `map` to `base_link`.

    Each rotation turns the axes of the next one: yaw first, then pitch, then roll.
    sensor_msgs/Imu has more than most sensors measure: covariances and accelerations.

    Attributes:
        stamp: Time of measurement [s since the epoch]; for records only.
        roll: About x [rad], in (-pi, pi], positive right side down.
        pitch: About y [rad], in [-pi/2, pi/2], positive nose down.
        yaw: About z [rad], in (-pi, pi], counter-clockwise; NaN when not measured.
    """

    stamp: Stamp
    roll: Radians
    pitch: Radians
    yaw: RadiansIfKnown = math.nan


ATTITUDE = MessageDefinition(name="GCM_Attitude", type=Attitude, rate_hz=20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Altitude:
    """The height and depth of the robot.

    Attributes:
        stamp: Time of measurement [s since the epoch]; for records only.
        height: Above the origin of `map` [m]; NaN when not measured.
        above_ground: Above the ground or the sea floor [m]; NaN when not measured.
        depth: Below the water's surface [m]; NaN when not measured.
        climb: Vertical velocity [m/s], positive up; NaN when not measured.
    """

    stamp: Stamp
    height: MetresIfKnown = math.nan
    above_ground: MetresIfKnown = math.nan
    depth: MetresIfKnown = math.nan
    climb: SpeedIfKnown = math.nan


ALTITUDE = MessageDefinition(name="GCM_Altitude", type=Altitude, rate_hz=10.0)

MESSAGES = (ATTITUDE, ALTITUDE)
