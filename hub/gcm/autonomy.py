"""Messages of the autonomy module: its commands and its state."""

from __future__ import annotations

import enum
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
from hub.values import dataclass


class Behaviour(enum.IntEnum):
    """A behaviour of autonomy.

    Attributes:
        HOLD: Nothing; the operator drives.
        EXPLORE: Go to the edges of the map, until none can be reached or none brings new ground.
        GO: Go to a point.
        FOLLOW: Go to several points in order.
        RETURN: Go back to the start.
        WANDER: Drive around in free space.
    """

    HOLD = 0
    EXPLORE = 1
    GO = 2
    FOLLOW = 3
    RETURN = 4
    WANDER = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class AutonomyCommand:
    """Set the behaviour of autonomy.

    Attributes:
        behaviour: The behaviour.
        points: Goals in `map`: one for GO, some for FOLLOW, else none.
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
    """The driver of the robot."""

    NOBODY = 0
    OPERATOR = 1
    AUTONOMY = 2


class Phase(enum.IntEnum):
    """The state of the last command.

    Attributes:
        IDLE: No command yet, or the command was HOLD.
        ACTIVE: It is under way.
        WAITING: The robot stands until data comes back or the path clears, and goes on then.
        DONE: It is done.
        BLOCKED: There was no path.
        STOPPED: A client stopped it.
        TAKEN_OVER: An operator drives, has control now, or sent the robot elsewhere.
        LOST: Data that autonomy needs did not come back in time.
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
    """The state of autonomy; sent at each change and twice a second.

    Attributes:
        behaviour: The present behaviour.
        pilot: The driver now.
        x: Its goal in `map` [m]; NaN: none.
        y: Its goal in `map` [m].
        frontier_m: Length of the map's edge that is left to explore [m]; NaN: not exploring.
        why: The reason, for people: "the operator took over", "explored: nothing is left".
        phase: The state of the last command.
        asked: The last command.
        explored: Share of the edge of the known free ground that needs no exploring, 0 to 1;
            NaN: it has not explored.
        distance_m: Length of the remaining path to the goal [m]; NaN: not known.
        seconds: Its time so far, or in all [s].
        ended_s: Time since its end [s]; NaN: it is under way, or there was no command.
        sender: The module's number at central, as in `NavigationStatus.sender`.
        number: Counts the commands since the start of the module.
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
