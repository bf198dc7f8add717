"""Messages of the autonomy module: what it is to do, and what it does."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Annotated

from hub.gcm.fields import LengthIfKnown, MetresIfKnown, Sentence
from hub.gcm.navigation import MOST_POINTS, Point
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.ranges import Most


class Behaviour(enum.IntEnum):
    """What the robot does by itself.

    Attributes:
        HOLD: Nothing; the operator drives.
        EXPLORE: Go where the map ends, until no such place can be reached or nothing new comes.
        GO: Go to a point.
        FOLLOW: Go to one point after the other.
        RETURN: Go back to where the robot started.
        WANDER: Drive about where there is room.
    """

    HOLD = 0
    EXPLORE = 1
    GO = 2
    FOLLOW = 3
    RETURN = 4
    WANDER = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class AutonomyCommand:
    """Tell autonomy what to do.

    Attributes:
        behaviour: What.
        count: Number of points.
        points: Where to in `map`: one for GO, some for FOLLOW, else none.
    """

    behaviour: Behaviour = Behaviour.HOLD
    count: int = 0
    points: Annotated[tuple[Point, ...], Most(MOST_POINTS)] = ()


AUTONOMY_COMMAND = MessageDefinition(
    name="GCM_Autonomy_Command",
    format="{{enum:5},int,<{double,double}:2>}",
    type=AutonomyCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


class Pilot(enum.IntEnum):
    """Who drives."""

    NOBODY = 0
    OPERATOR = 1
    AUTONOMY = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class AutonomyState:
    """What autonomy does, and why; when it changes and twice a second.

    Attributes:
        behaviour: What it does.
        pilot: Who drives now.
        x: Where it goes in `map` [m]; NaN: nowhere.
        y: Where it goes in `map` [m].
        frontier_m: Length of the map's edge that is left to explore [m]; NaN: not exploring.
        why: Why it does so, for people: "the operator took over", "explored: nothing is left".
    """

    behaviour: Behaviour
    pilot: Pilot
    x: MetresIfKnown
    y: MetresIfKnown
    frontier_m: LengthIfKnown
    why: Sentence


AUTONOMY_STATE = MessageDefinition(
    name="GCM_AutonomyState",
    format="{{enum:5},{enum:2},double,double,double,string}",
    type=AutonomyState,
    rate_hz=2.0,
)

MESSAGES = (AUTONOMY_COMMAND, AUTONOMY_STATE)
