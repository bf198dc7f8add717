"""Messages between navigation and driver about a robot that drives to goals by itself."""

from __future__ import annotations

import enum
import math

from hub.gcm.fields import (
    Count,
    Flag,
    LengthIfKnown,
    Metres,
    Number,
    Radians,
    SecondsIfKnown,
    Sentence,
)
from hub.ipc.definition import MessageDefinition, Plane
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveGoal:
    """Drive to a place by the robot's own navigation, while this is repeated.

    It takes the place of `GCM_Drive_Command`: the next velocity ends the goal, and so does silence.

    Attributes:
        number: Names the goal; the same number again changes nothing.
        x: In `odom` [m].
        y: In `odom` [m].
        theta: Heading at the place, in `odom` [rad].
    """

    number: Number
    x: Metres
    y: Metres
    theta: Radians


DRIVE_GOAL = MessageDefinition(
    name="GCM_Drive_Goal",
    type=DriveGoal,
    plane=Plane.COMMAND,
    rate_hz=20.0,
    lifespan_s=0.3,
)
"""Navigation's goal for the driver; no other client sends it."""


class OwnGoal(enum.IntEnum):
    """The state of a goal at the robot's own navigation.

    Attributes:
        NONE: There was none yet.
        SENT: It is not answered yet.
        DRIVES: The robot drives to it.
        REACHED: The robot is there.
        ABORTED: The robot gave up.
        REFUSED: The robot did not take it.
        CANCELLED: The hub or another node ended it.
        LOST: The robot was silent, or its line was away; the goal is cancelled.
    """

    NONE = 0
    SENT = 1
    DRIVES = 2
    REACHED = 3
    ABORTED = 4
    REFUSED = 5
    CANCELLED = 6
    LOST = 7


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnNavigation:
    """The navigation that the robot has itself; sent at each change and 5 times a second.

    Attributes:
        available: Whether it takes goals now.
        number: Number of the hub's last goal; 0: there was none.
        goal: Its state.
        distance_left: Length of the way that is left [m]; NaN: not known.
        heard_s: Age of the last message about the goal [s]; NaN: there is no goal now.
        others: Goals of other nodes that the robot follows.
        ending: Whether a cancelled goal has not ended yet.
        unanswered: Whether that lasts too long: the robot may still drive to it.
        why: The reason of its end, for people.
    """

    available: Flag = 0
    number: Number = 0
    goal: OwnGoal = OwnGoal.NONE
    distance_left: LengthIfKnown = math.nan
    heard_s: SecondsIfKnown = math.nan
    others: Count = 0
    ending: Flag = 0
    unanswered: Flag = 0
    why: Sentence = ""


OWN_NAVIGATION = MessageDefinition(
    name="GCM_OwnNavigation",
    type=OwnNavigation,
    rate_hz=5.0,
)

MESSAGES = (DRIVE_GOAL, OWN_NAVIGATION)
