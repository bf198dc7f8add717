"""Messages of robots that fly or dive: height and depth, and the pressure around them."""

from __future__ import annotations

import math
from typing import Annotated

from hub.gcm.fields import MetresIfKnown, SpeedIfKnown, Stamp
from hub.gcm.standard import BASE_LINK, Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Range
from hub.values import dataclass


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


@dataclass(frozen=True, slots=True, kw_only=True)
class FluidPressure:
    """sensor_msgs/FluidPressure: the absolute pressure of the air or the water.

    Attributes:
        header: When it was measured.
        fluid_pressure: [Pa].
        variance: [Pa^2]; 0: not known.
    """

    ros_type = "sensor_msgs/msg/FluidPressure"

    header: Header = Header(frame_id=BASE_LINK)
    fluid_pressure: Annotated[float, Range(0.0, 1e9, unit="Pa")]
    variance: Annotated[float, Range(0.0, 1e18, unit="Pa^2")] = 0.0


FLUID_PRESSURE = MessageDefinition(name="GCM_FluidPressure", type=FluidPressure, rate_hz=10.0)

MESSAGES = (ALTITUDE, FLUID_PRESSURE)
