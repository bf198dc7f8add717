"""Messages of motion and robot state, between console, navigation and driver.

Frames after ROS REP 103 and 105: x forward, y left, angles counter-clockwise from x; velocities are
in `base_link`. `odom` is dead reckoning, which drifts; `map` is `odom` corrected by landmarks. Both
are equal until the first correction.
"""

from __future__ import annotations

import enum
import math
from typing import Annotated

from hub.gcm.fields import (
    Count,
    LengthIfKnown,
    Metres,
    MetresIfKnown,
    Number,
    Radians,
    RadiansIfKnown,
    Seconds,
    SecondsIfKnown,
    Sentence,
    Share,
    ShareIfKnown,
    Speed,
    Stamp,
    TurnRate,
)
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.ground_truth import GROUND_TRUTH as GROUND_TRUTH  # noqa: PLC0414 - an export
from hub.gcm.ground_truth import GroundTruth as GroundTruth  # noqa: PLC0414 - an export
from hub.gcm.odometry import Odometry
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Counted
from hub.values import dataclass

MOST_POINTS = 1000
"""Most points of a path."""

VELOCITY_COMMAND = MessageDefinition(
    name="GCM_Velocity_Command",
    type=TwistStamped,
    plane=Plane.COMMAND,
    rate_hz=20.0,
    lifespan_s=0.3,
)
"""The operator's velocity; navigation decides whether the robot follows it."""

DRIVE_COMMAND = MessageDefinition(
    name="GCM_Drive_Command",
    type=TwistStamped,
    plane=Plane.COMMAND,
    rate_hz=20.0,
    lifespan_s=0.3,
)
"""Navigation's velocity for the driver; no other client sends it."""


class MotionState(enum.IntEnum):
    """The state of navigation's velocity commands.

    Attributes:
        STANDING: The commanded velocity is 0; ready.
        MOVING: The robot follows fresh commands.
        SILENCE: Commands ended while the robot moved; stopped, waits for a neutral command.
        STOPPED: A client sent a stop; waits for a neutral command.
        NO_DRIVER: The driver does not report; the robot cannot move.
        WAITING: No command yet, or a new owner of control; waits for a neutral command.
        GOING: The robot goes to a point, or turns, by itself.
    """

    STANDING = 0
    MOVING = 1
    SILENCE = 2
    STOPPED = 3
    NO_DRIVER = 4
    WAITING = 5
    GOING = 6


class Assistance(enum.IntEnum):
    """Whether the robot slows down before obstacles.

    Attributes:
        OFF: The robot follows commands into walls.
        ON: The robot stops before walls.
    """

    OFF = 0
    ON = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotState:
    """The present state of the robot: the summary that one glance needs.

    Attributes:
        stamp: Time of measurement [s since the epoch]; for records only.
        x: Position in `map` [m].
        y: Position in `map` [m].
        theta: Heading in `map` [rad], in (-pi, pi].
        linear: Measured forward velocity [m/s].
        angular: Measured turn rate [rad/s].
        commanded_linear: Commanded forward velocity [m/s].
        commanded_angular: Commanded turn rate [rad/s].
        bumpers: Bit i is set while bumper i of the description is pressed.
        battery_voltage: Battery [V]; NaN when not measured.
        battery_fraction: Charge left, 0 to 1; NaN when not known.
        sway: Measured velocity to the left [m/s].
        heave: Measured velocity upward [m/s].
        motion: The state of velocity commands.
        refused: Commands refused since the module's start: late, out of order, not finite, not
            from neutral, or not from the owner of control.
        assistance: Whether the robot slows down before obstacles.
        held_back: Withheld part of the commanded velocity now, 0 (none) to 1.
        frame: Number of the frame `map`; 0: not known. After a change, earlier positions are in
            another frame: the robot has lost its place.
        position_off: Standard deviation of the position in the map [m]; NaN: not known.
        heading_off: Standard deviation of the heading in the map [rad]; NaN: not known.
        stops: Counts the events after which a driver has to become neutral first: stops,
            silences, hand-overs, other drivers.
    """

    stamp: Stamp
    x: Metres
    y: Metres
    theta: Radians
    linear: Speed
    angular: TurnRate
    commanded_linear: Speed
    commanded_angular: TurnRate
    bumpers: Number
    battery_voltage: Annotated[float, Range(-1000.0, 1000.0, unit="V", nan=True), FLOAT32]
    battery_fraction: Annotated[ShareIfKnown, FLOAT32]
    sway: Speed = 0.0
    heave: Speed = 0.0
    motion: MotionState
    refused: Number
    assistance: Assistance = Assistance.ON
    held_back: Annotated[Share, FLOAT32] = 0.0
    frame: Number = 0
    position_off: Annotated[LengthIfKnown, FLOAT32] = math.nan
    heading_off: Annotated[RadiansIfKnown, FLOAT32] = math.nan
    stops: Number = 0


ROBOT_STATE = MessageDefinition(
    name="GCM_RobotState",
    type=RobotState,
    rate_hz=20.0,
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DriveState:
    """The report of the hardware.

    Attributes:
        odometry: Dead-reckoned pose in `odom`, and measured velocity in `base_link`.
        commanded: The velocity that it follows now, within its limits.
        bumpers: Bit i is set while bumper i of the description is pressed.
        reckoning: Number of this dead reckoning; it changes with each restart. 0: the driver
            process gives it one.
        origin: Number of the origin of `odom`; equal numbers mean equal places, even after a
            restart of the dead reckoning. 0: the robot's place at the restart.
    """

    odometry: Odometry = Odometry()
    commanded: Twist = Twist()
    bumpers: Number = 0
    reckoning: Number = 0
    origin: Number = 0

    @property
    def x(self) -> float:
        """Position in `odom` [m]."""
        return self.odometry.pose.pose.position.x

    @property
    def y(self) -> float:
        """Position in `odom` [m]."""
        return self.odometry.pose.pose.position.y

    @property
    def theta(self) -> float:
        """Heading in `odom` [rad], in (-pi, pi]."""
        return self.odometry.pose.pose.orientation.roll_pitch_yaw[2]

    @property
    def velocity(self) -> Twist:
        """Measured velocity in `base_link`."""
        return self.odometry.twist.twist

    @property
    def linear(self) -> float:
        """Measured forward velocity [m/s]."""
        return self.odometry.twist.twist.linear.x

    @property
    def angular(self) -> float:
        """Measured turn rate [rad/s]."""
        return self.odometry.twist.twist.angular.z


DRIVE_STATE = MessageDefinition(
    name="GCM_DriveState",
    type=DriveState,
    rate_hz=50.0,
)
"""20 Hz while the robot stands or only drifts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """Stop now; accepted from every client.

    Attributes:
        reason: The sender and the reason, for the log.
    """

    reason: Sentence = ""


STOP = MessageDefinition(
    name="GCM_Stop",
    type=Stop,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    unreadable=Stop(reason="somebody, in a message that cannot be read"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """A point on the ground.

    Attributes:
        x: In `map` [m].
        y: In `map` [m].
    """

    x: Metres
    y: Metres


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalCommand:
    """Go to points in order; no points: stand and forget them.

    Attributes:
        points: The goals in `map`.
        theta: Heading at the last one in `map` [rad]; NaN: any.
        linear_limit: Highest speed [m/s]; NaN: the robot's own limit.
        patience: Longest wait at a closed path, 600 at most [s]; 0 or NaN: 30.
    """

    points: Annotated[tuple[Point, ...], Counted(), Most(MOST_POINTS)] = ()
    theta: RadiansIfKnown = float("nan")
    linear_limit: Annotated[float, Range(0.0, 100.0, unit="m/s", nan=True)] = float("nan")
    patience: Annotated[float, Range(0.0, 1e6, unit="s", nan=True)] = float("nan")


GOAL_COMMAND = MessageDefinition(
    name="GCM_Goal_Command",
    type=GoalCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnCommand:
    """Turn on the spot.

    Attributes:
        angle: Angle [rad], positive counter-clockwise; more than a whole turn is allowed.
    """

    angle: Annotated[float, Range(-100.0, 100.0, unit="rad")] = 0.0


TURN_COMMAND = MessageDefinition(
    name="GCM_Turn_Command",
    type=TurnCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class AssistanceCommand:
    """Switch the slowdown before obstacles.

    Attributes:
        assistance: On or off.
    """

    assistance: Assistance = Assistance.ON


ASSISTANCE_COMMAND = MessageDefinition(
    name="GCM_Assistance_Command",
    type=AssistanceCommand,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkCorrection:
    """Correct the pose by a landmark with a known place that is seen now.

    Attributes:
        x: Place of the landmark in `map` [m].
        y: Place of the landmark in `map` [m].
        seen_x: Its measured place in `base_link` [m].
        seen_y: Its measured place in `base_link` [m].
    """

    x: Metres
    y: Metres
    seen_x: Metres
    seen_y: Metres


LANDMARK_CORRECTION = MessageDefinition(
    name="GCM_Landmark_Correction",
    type=LandmarkCorrection,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
    lifespan_s=1.0,
)


class Task(enum.IntEnum):
    """Navigation's own task, or its end.

    Attributes:
        NONE: It follows velocity commands only.
        GOING: It goes to a point.
        TURNING: It turns.
        REACHED: The task is done.
        BLOCKED: There is no path, or no progress.
        CANCELLED: A velocity command, a stop, or another task ended it.
    """

    NONE = 0
    GOING = 1
    TURNING = 2
    REACHED = 3
    BLOCKED = 4
    CANCELLED = 5


class Cause(enum.IntEnum):
    """The reason why a task waits, or ended early.

    Attributes:
        NONE: It does not wait; it is done.
        CLOSED: The map shows no path, or the robot makes no progress.
        OCCUPIED: An obstacle is at the goal.
        BUSY: Navigation was too busy to steer.
        DRIVER: The driver is silent or does not follow, or restarted at another place.
        STOP: A client sent a stop.
        STICK: An operator drives by hand.
        CONTROL: Another console has control now.
        REPLACED: Another task replaced it.
        WITHDRAWN: A client sent a goal without points.
        TILTED: The robot is tilted, and by itself it drives only where it sees all around.
        BLIND: All range sensors that look along the ground are silent.
    """

    NONE = 0
    CLOSED = 1
    OCCUPIED = 2
    BUSY = 3
    DRIVER = 4
    STOP = 5
    STICK = 6
    CONTROL = 7
    REPLACED = 8
    WITHDRAWN = 9
    TILTED = 10
    BLIND = 11


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigationStatus:
    """Navigation's own task; sent at each change and twice a second.

    Attributes:
        number: Counts the tasks since the module's start.
        task: The task, or its end.
        sender: Number at central of the task's sender, as in frame headers.
        driver: Number of the sender whose velocity commands count now; 0: none.
        points_left: Points that are not yet reached.
        distance_left: Length of the remaining path [m]; NaN: not known.
        why: The reason for a wait or an end, for people; empty while it goes on.
        path: The planned path in `map`, from the robot to the goal; empty: there is no map.
        cause: The same as `why`, for programs.
        x: Goal of the task in `map` [m]; NaN: a turn, or no task.
        y: Goal of the task in `map` [m].
        seconds: Its time so far, or in all [s].
        ended_s: Time since its end [s]; NaN: it is under way, or there was none.
    """

    number: Number
    task: Task
    sender: Number
    driver: Number
    points_left: Count
    distance_left: LengthIfKnown
    why: Sentence
    path: Annotated[tuple[Point, ...], Counted(), Most(MOST_POINTS)]
    cause: Cause = Cause.NONE
    x: MetresIfKnown = float("nan")
    y: MetresIfKnown = float("nan")
    seconds: Seconds = 0.0
    ended_s: SecondsIfKnown = float("nan")


NAVIGATION_STATUS = MessageDefinition(
    name="GCM_NavigationStatus",
    type=NavigationStatus,
    rate_hz=2.0,
)


MESSAGES = (
    VELOCITY_COMMAND,
    DRIVE_COMMAND,
    ROBOT_STATE,
    DRIVE_STATE,
    STOP,
    GOAL_COMMAND,
    TURN_COMMAND,
    ASSISTANCE_COMMAND,
    LANDMARK_CORRECTION,
    NAVIGATION_STATUS,
    GROUND_TRUTH,
)
