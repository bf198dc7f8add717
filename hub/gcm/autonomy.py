"""Messages of the autonomy module: what it is to do, and what it does."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Annotated

from hub.gcm.fields import (
    LengthIfKnown,
    MetresIfKnown,
    Number,
    Seconds,
    SecondsIfKnown,
    Sentence,
    ShareIfKnown,
)
from hub.gcm.navigation import MOST_POINTS, Point
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Most
from hub.ipc.formats.wire_types import Counted


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
        points: Where to in `map`: one for GO, some for FOLLOW, else none.
    """

    behaviour: Behaviour = Behaviour.HOLD
    points: Annotated[tuple[Point, ...], Counted(), Most(MOST_POINTS)] = ()


AUTONOMY_COMMAND = MessageDefinition(
    name="GCM_Autonomy_Command",
    type=AutonomyCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


class DrivingMode(enum.IntEnum):
    """Who drives."""

    NOBODY = 0
    OPERATOR = 1
    AUTONOMY = 2


class Phase(enum.IntEnum):
    """How what was asked for stands.

    Attributes:
        IDLE: Nobody has asked for anything, or somebody asked to hold.
        ACTIVE: It is under way.
        WAITING: The robot stands until something comes back or clears, and goes on then.
        DONE: It is done.
        BLOCKED: There was no way.
        STOPPED: Somebody stopped it.
        TAKEN_OVER: Somebody drives, has control now, or sent the robot elsewhere.
        LOST: What autonomy has to know did not come back in time.
        REFUSED: The command made no sense.
    """

    IDLE = 0
    ACTIVE = 1
    WAITING = 2
    DONE = 3
    BLOCKED = 4
    STOPPED = 5
    TAKEN_OVER = 6
    LOST = 7
    REFUSED = 8


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
        phase: How what was asked for last stands.
        asked: What was asked for last.
        explored: Share of the edge of the known free ground that needs no exploring, 0 to 1;
            NaN: it has not explored.
        distance_m: Length of the way that is left to where it goes [m]; NaN: not known.
        seconds: How long it has taken so far, or took in all [s].
        ended_s: Time since it ended [s]; NaN: it is under way, or nobody has asked yet.
        sender: The module's number at central, as in `NavigationStatus.sender`.
        number: Counts what was asked for since the module started.
    """

    behaviour: Behaviour
    pilot: DrivingMode
    x: MetresIfKnown
    y: MetresIfKnown
    frontier_m: LengthIfKnown
    why: Sentence
    phase: Phase = Phase.IDLE
    asked: Behaviour = Behaviour.HOLD
    explored: ShareIfKnown = float("nan")
    distance_m: LengthIfKnown = float("nan")
    seconds: Seconds = 0.0
    ended_s: SecondsIfKnown = float("nan")
    sender: Number = 0
    number: Number = 0


AUTONOMY_STATE = MessageDefinition(
    name="GCM_AutonomyState",
    type=AutonomyState,
    rate_hz=2.0,
)

MESSAGES = (AUTONOMY_COMMAND, AUTONOMY_STATE)
