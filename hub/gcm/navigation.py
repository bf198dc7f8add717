"""Messages of motion and robot state, between console, navigation and driver.

Frames after ROS REP 103 and 105: x forward, y left, angles counter-clockwise from x; poses are in
`odom`, velocities in `base_link`.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hub.ipc.definition import Keep, MessageDefinition, Plane

SENSOR_COUNT = 16
"""Sonars, infrared sensors and bumpers of a Magellan Pro, one of each every 22.5 degrees.

Sensor 0 looks straight ahead (along x), the others follow counter-clockwise.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Vector3:
    """geometry_msgs/Vector3.

    Attributes:
        x: Along x [m/s or rad/s].
        y: Along y [m/s or rad/s].
        z: Along z [m/s or rad/s].
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Twist:
    """geometry_msgs/Twist: a velocity in `base_link`.

    Attributes:
        linear: Linear velocity [m/s]; a wheeled base follows x only.
        angular: Angular velocity [rad/s]; a wheeled base follows z only.
    """

    linear: Vector3 = Vector3()
    angular: Vector3 = Vector3()

    @classmethod
    def planar(cls, linear: float, angular: float) -> Twist:
        """The velocity of a wheeled base: forward [m/s] and counter-clockwise [rad/s]."""
        return cls(linear=Vector3(x=linear), angular=Vector3(z=angular))

    @property
    def neutral(self) -> bool:
        """Whether nothing is commanded to move."""
        parts = (self.linear, self.angular)
        return all(part.x == part.y == part.z == 0.0 for part in parts)


_TWIST = "{{double,double,double},{double,double,double}}"

VELOCITY_COMMAND = MessageDefinition(
    name="GCM_Velocity_Command",
    format=_TWIST,
    type=Twist,
    plane=Plane.COMMAND,
    rate_hz=20.0,
    lifespan_s=0.3,
    ros_type="geometry_msgs/msg/Twist",
)
"""What the operator wants the robot to do; navigation decides what it does."""

DRIVE_COMMAND = MessageDefinition(
    name="GCM_Drive_Command",
    format=_TWIST,
    type=Twist,
    plane=Plane.COMMAND,
    rate_hz=20.0,
    lifespan_s=0.3,
    ros_type="geometry_msgs/msg/Twist",
)
"""What navigation tells the driver; nobody else sends it."""


class MotionState(enum.IntEnum):
    """What navigation does with velocity commands.

    Attributes:
        STANDING: Commanded to stand; ready.
        MOVING: Following fresh commands.
        SILENCE: Commands stopped coming while moving; stopped, waits for a neutral command.
        STOPPED: Somebody sent a stop; waits for a neutral command.
        NO_DRIVER: The driver does not report; nothing can move.
        WAITING: Nobody has commanded yet; waits for a neutral command.
    """

    STANDING = 0
    MOVING = 1
    SILENCE = 2
    STOPPED = 3
    NO_DRIVER = 4
    WAITING = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotState:
    """What is known of the robot now.

    Attributes:
        stamp: When it was measured [s since the epoch]; for records only.
        x: Position in `odom` [m].
        y: Position in `odom` [m].
        theta: Heading in `odom` [rad], in (-pi, pi].
        linear: Measured forward velocity [m/s].
        angular: Measured turn rate [rad/s].
        commanded_linear: Forward velocity the wheels are told [m/s].
        commanded_angular: Turn rate the wheels are told [rad/s].
        sonar: Range of each sonar from the robot's centre [m], shape (16,); inf: no echo.
        infrared: Range of each infrared sensor from the centre [m], shape (16,); inf: nothing seen.
        bumpers: Bit i is set while bumper i is pressed.
        battery_voltage: Battery [V]; NaN when not measured.
        battery_fraction: Charge left, 0 to 1; NaN when not known.
        motion: What is done with velocity commands.
        refused: Velocity commands refused since the module started: late, out of order, not
            finite, or not from neutral.
    """

    stamp: float
    x: float
    y: float
    theta: float
    linear: float
    angular: float
    commanded_linear: float
    commanded_angular: float
    sonar: npt.NDArray[np.float32]
    infrared: npt.NDArray[np.float32]
    bumpers: int
    battery_voltage: float
    battery_fraction: float
    motion: MotionState
    refused: int


ROBOT_STATE = MessageDefinition(
    name="GCM_RobotState",
    format="{double,double,double,double,double,double,double,double,[float:16],[float:16],"
    "uint,float,float,{enum:5},uint}",
    type=RobotState,
    rate_hz=20.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveState:
    """What the hardware reports.

    Attributes:
        stamp: When it was measured [s since the epoch]; for records only.
        x: Dead-reckoned position in `odom` [m].
        y: Dead-reckoned position in `odom` [m].
        theta: Dead-reckoned heading in `odom` [rad], in (-pi, pi].
        linear: Forward velocity from the encoders [m/s].
        angular: Turn rate from the encoders [rad/s].
        commanded_linear: Forward velocity the wheels are told [m/s].
        commanded_angular: Turn rate the wheels are told [rad/s].
        sonar: As in `RobotState`.
        infrared: As in `RobotState`.
        bumpers: Bit i is set while bumper i is pressed.
        battery_voltage: Battery [V]; NaN when not measured.
        battery_fraction: Charge left, 0 to 1; NaN when not known.
    """

    stamp: float
    x: float
    y: float
    theta: float
    linear: float
    angular: float
    commanded_linear: float
    commanded_angular: float
    sonar: npt.NDArray[np.float32]
    infrared: npt.NDArray[np.float32]
    bumpers: int
    battery_voltage: float
    battery_fraction: float


DRIVE_STATE = MessageDefinition(
    name="GCM_DriveState",
    format="{double,double,double,double,double,double,double,double,[float:16],[float:16],"
    "uint,float,float}",
    type=DriveState,
    rate_hz=50.0,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """Stop now; accepted from anyone who may connect.

    Attributes:
        reason: Who stops and why, for the log.
    """

    reason: str = ""


STOP = MessageDefinition(
    name="GCM_Stop", format="{string}", type=Stop, keep=Keep.ALL, plane=Plane.COMMAND
)


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundTruth:
    """Where a simulated robot really is; for tests and experiments, never for modules that drive.

    Attributes:
        time: Simulated time since the start [s].
        x: Position in the arena's frame [m].
        y: Position in the arena's frame [m].
        theta: Heading in the arena's frame [rad], in (-pi, pi].
        linear: True forward velocity [m/s].
        angular: True turn rate [rad/s].
        commanded_linear: Forward velocity the wheels are told [m/s].
        commanded_angular: Turn rate the wheels are told [rad/s].
        contacts: Times the body has come into contact with something since the start.
        touching: Whether it touches something now (0 or 1).
    """

    time: float
    x: float
    y: float
    theta: float
    linear: float
    angular: float
    commanded_linear: float
    commanded_angular: float
    contacts: int
    touching: int


GROUND_TRUTH = MessageDefinition(
    name="SIM_GroundTruth",
    format="{double,double,double,double,double,double,double,double,uint,ubyte}",
    type=GroundTruth,
    rate_hz=50.0,
)

MESSAGES = (VELOCITY_COMMAND, DRIVE_COMMAND, ROBOT_STATE, DRIVE_STATE, STOP, GROUND_TRUTH)
