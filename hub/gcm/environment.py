"""The message of the air around the robot: sound level and carbon dioxide."""

from __future__ import annotations

import math
from typing import Annotated, TypeAlias

from hub.gcm.fields import Stamp
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Range
from hub.values import dataclass

_Decibels: TypeAlias = Annotated[float, Range(-100.0, 300.0, unit="dB", nan=True)]
_Parts: TypeAlias = Annotated[float, Range(0.0, 1e6, unit="ppm", nan=True)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Environment:
    """The air around the robot; ROS 2 has no types for sound level and carbon dioxide.

    Attributes:
        stamp: Time of measurement [s since the epoch]; for records only.
        sound: Sound level [dB]; NaN: not measured.
        co2: Carbon dioxide [ppm]; NaN: not measured.
    """

    stamp: Stamp
    sound: _Decibels = math.nan
    co2: _Parts = math.nan


ENVIRONMENT = MessageDefinition(name="GCM_Environment", type=Environment, rate_hz=2.0)

MESSAGES = (ENVIRONMENT,)
