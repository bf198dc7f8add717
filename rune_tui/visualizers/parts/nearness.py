"""The classes of distances from the robot's body."""

from __future__ import annotations

import enum
from typing import Final

from hub.gcm.navigation import Assistance, MotionState
from rune_tui.model.robot_state import RobotState
from rune_tui.visualizers.parts.staleness import Staleness, staleness

NEAR_M: Final = 0.5
CLOSE_M: Final = 0.15


class Nearness(enum.IntEnum):
    """The distance of an obstacle from the body.

    Attributes:
        FAR: There is room.
        NEAR: Take care; has a colour and an exclamation mark.
        CLOSE: About to touch; has another colour and an X.
    """

    FAR = 0
    NEAR = 1
    CLOSE = 2


def nearness_of(
    room: float, near_m: float = NEAR_M, close_m: float = CLOSE_M, *, avoids: bool = False
) -> Nearness:
    """The class of a distance.

    Args:
        room: Distance from the body [m].
        near_m: Less than this is near [m].
        close_m: Less than this is close [m].
        avoids: Result of `avoids_obstacles`: then nothing is more than near.
    """
    if room < close_m:
        return Nearness.NEAR if avoids else Nearness.CLOSE
    return Nearness.NEAR if room < near_m else Nearness.FAR


def avoids_obstacles(robot: RobotState, now: float) -> bool:
    """Whether the robot moves by itself, and navigation may steer it past near obstacles."""
    state = robot.navigation
    if state is None or staleness(state.age(now)) is Staleness.STALE:
        return False
    return state.value.motion is MotionState.GOING and state.value.assistance is Assistance.ON
