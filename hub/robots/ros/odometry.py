"""Where a robot with ROS says that it is, how old that is, and whether its reckoning goes on; pure.

| event | number of the dead reckoning |
| --- | --- |
| the first place, near the one that the process before remembered | the remembered one |
| the first place elsewhere, or nothing is remembered | a new one |
| a place farther from the last one than the robot can have gone | a new one |
| a step to the origin of the reckoning, as after its restart | a new one |
| a new connection, and the robot's clock differs from before | a new one |
"""

from __future__ import annotations

import math
import secrets
from typing import Final

from hub.errors import RosMessageError
from hub.gcm.fields import FARTHEST_M
from hub.gcm.geometry import Twist, Vector3
from hub.pose import Pose, wrapped
from hub.robots.ros.topic_reader import UNFIT
from hub.ros import messages
from hub.ros.frame_tree import place_of
from hub.ros.values import RosValue
from hub.values import dataclass

FRESH_S: Final = 0.5
"""Age from which on a place is not known any more [s]."""
_JUMP, _TURN = 0.5, 1.0
"""A step that is no jump at any speed [m, rad]."""
_TIMES_FASTER: Final = 2.0
"""Factor by which others may drive a robot faster than its limits."""
_LONGEST_GAP_S: Final = 1.0
"""Longest time for which the robot is supposed to have driven [s]."""
_AT_ORIGIN: Final = 0.01
"""A dead reckoning that began again is within this of its origin [m, rad]."""
_ONE_STEP: Final = 0.1
"""Longest way to the origin that is no new begin [m, rad]."""
_SAME_CLOCK_S: Final = 1.0
_FASTEST: Final = 100.0
_IN_PLANE: Final = (0, 1, 3)
"""Which numbers of `planar` each robot has: forward, left and turning."""
_MOST: Final = 2**32 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class RosPlace:
    """Where a robot is, and how it moves.

    Attributes:
        pose: In its frame of dead reckoning.
        z: Height there [m].
        velocity: In its own frame.
        stamp: When, by the robot's clock [s since its epoch].
        measured: When [s, monotonic].
    """

    pose: Pose
    z: float = 0.0
    velocity: Twist = Twist()
    stamp: float = 0.0
    measured: float = -math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptReckoning:
    """What is remembered of a dead reckoning.

    Attributes:
        number: Its number.
        pose: The last pose.
        measured: When [s, monotonic].
        clock: The robot's clock less the monotonic one [s].
    """

    number: int
    pose: Pose
    measured: float
    clock: float


def place_of_odometry(value: RosValue, measured: float) -> RosPlace:
    """The place in a nav_msgs/Odometry.

    Raises:
        RosMessageError: It is not finite, or too far away.
    """
    pose, stamp, twist = value.get("pose.pose"), value.get("header.stamp"), value.get("twist.twist")
    place = place_of(pose.get("position"), pose.get("orientation"))
    if place is None or abs(place.origin).max() > FARTHEST_M:
        text = "the place or the orientation of an odometry makes no sense"
        raise RosMessageError(text)
    if any(math.isnan(messages.planar(twist)[each]) for each in _IN_PLANE):
        text = "the velocity of an odometry is not a number"
        raise RosMessageError(text)
    x, y, z = place.origin.tolist()
    theta = place.roll_pitch_yaw[2]
    return RosPlace(
        pose=Pose(x=x, y=y, theta=wrapped(theta)),
        z=z,
        velocity=Twist(linear=_vector(twist.get("linear")), angular=_vector(twist.get("angular"))),
        stamp=int(stamp.get("sec")) + int(stamp.get("nanosec")) * 1e-9,
        measured=measured,
    )


def odometry_fault(value: RosValue) -> str:
    """Why a message of the topic of odometry cannot be used, in words; empty: it can."""
    try:
        place_of_odometry(value, 0.0)
    except UNFIT as fault:
        return str(fault)
    return ""


class RosOdometry:
    """The dead reckoning of one robot.

    Attributes:
        place: The newest place; None: there was none.
        number: Number of the dead reckoning; 0: there is none yet.
        late: For how long the newest place was on its way [s].
    """

    def __init__(self, speed: float, turn: float, kept: KeptReckoning | None = None) -> None:
        """Wait for the first place.

        Args:
            speed: Its largest velocity [m/s].
            turn: Its largest turn rate [rad/s].
            kept: What the process before remembered.
        """
        self.place: RosPlace | None = None
        self.number = 0
        self.late = 0.0
        self._speed, self._turn = _TIMES_FASTER * speed, _TIMES_FASTER * turn
        self._kept = kept
        self._connection = -1

    @property
    def kept(self) -> KeptReckoning | None:
        """What the next process has to know."""
        return self._kept

    def take(self, place: RosPlace, connection: int, late: float = 0.0) -> None:
        """Take the next place.

        Args:
            place: The place.
            connection: Number of the connection by which it came.
            late: For how long it was on its way [s].
        """
        self.late = late
        last = self._kept
        reconnected, self._connection = connection != self._connection, connection
        clock = place.stamp - place.measured
        goes_on = last is not None and self._near(last, place)
        if last is not None and reconnected and abs(clock - last.clock) > _SAME_CLOCK_S:
            goes_on = False
        number = last.number if last is not None and goes_on else secrets.randbelow(_MOST) + 1
        self.place, self.number = place, number
        self._kept = KeptReckoning(
            number=number, pose=place.pose, measured=place.measured, clock=clock
        )

    def fresh(self, now: float) -> bool:
        """Whether the robot's place is known at a time [s]."""
        return self.place is not None and now - self.place.measured < FRESH_S

    def _near(self, last: KeptReckoning, place: RosPlace) -> bool:
        """Whether the robot can have gone from its last place to this one."""
        seconds = min(max(0.0, place.measured - last.measured), _LONGEST_GAP_S)
        way = math.hypot(place.pose.x - last.pose.x, place.pose.y - last.pose.y)
        turned = abs(wrapped(place.pose.theta - last.pose.theta))
        here = place.pose
        at_origin = max(abs(here.x), abs(here.y), abs(here.theta)) <= _AT_ORIGIN
        if at_origin and max(way, turned) > _ONE_STEP:
            return False
        return way <= _JUMP + self._speed * seconds and turned <= _TURN + self._turn * seconds


def _vector(value: RosValue) -> Vector3:
    x, y, z = (_limited(float(value.get(part))) for part in "xyz")
    return Vector3(x=x, y=y, z=z)


def _limited(speed: float) -> float:
    return max(-_FASTEST, min(_FASTEST, speed)) if math.isfinite(speed) else 0.0
