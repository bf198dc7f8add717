"""The message of a link shaper: how it degrades the link between a console and this hub."""

from __future__ import annotations

import math
from typing import Annotated, TypeAlias

from hub.gcm.fields import Count, Flag, Name, Number, Seconds, SecondsIfKnown
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import Uint64
from hub.values import dataclass

MOST_PICTURES = 1000.0
"""Largest limit of a picture rate [1/s]."""
_Total: TypeAlias = Annotated[Uint64, Range(0, 2**53)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapedDirection:
    """What a link shaper did with one direction since its start.

    Attributes:
        packets: Packets that it took.
        size: Their content [bytes].
        lost: Packets that it lost; a packet that was sent again and lost again counts again.
        held: Content that is in the link now [bytes].
        delay: Mean time in the link of the packets since the last message [s]; NaN: none.
    """

    packets: _Total = 0
    size: _Total = 0
    lost: _Total = 0
    held: _Total = 0
    delay: SecondsIfKnown = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaperState:
    """A link shaper; each second, and when a blackout begins or ends.

    Attributes:
        profile: Name of its profile.
        digest: SHA-256 of the profile's file.
        seed: With the profile, it fixes delays, losses and blackouts.
        address: Where consoles connect.
        elapsed: Time since its start [s]; its conditions depend on this time alone.
        connections: TCP connections through it.
        blackout: 1: it carries nothing now.
        picture_rate: Most pictures per second of each camera [1/s]; 0: no limit.
        up: From consoles to the hub.
        down: From the hub to consoles.
    """

    profile: Name
    digest: Name
    seed: Number
    address: Name
    elapsed: Seconds
    connections: Count = 0
    blackout: Flag = 0
    picture_rate: Annotated[float, Range(0.0, MOST_PICTURES, unit="1/s")] = 0.0
    up: ShapedDirection = ShapedDirection()
    down: ShapedDirection = ShapedDirection()


SHAPER_STATE = MessageDefinition(
    name="GCM_Shaper_State",
    type=ShaperState,
    rate_hz=1.0,
    lifespan_s=3.0,
)

MESSAGES = (SHAPER_STATE,)
