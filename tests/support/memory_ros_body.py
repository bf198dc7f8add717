"""The body of a robot with ROS on a line in memory, with the time given."""

from hub.gcm.geometry import (
    Point3D,
    Pose3D,
    PoseWithCovariance,
    Quaternion,
    Twist,
    TwistWithCovariance,
)
from hub.gcm.odometry import Odometry
from hub.gcm.standard import Header, Time
from hub.robots.ros.body import RosBody
from tests.support.memory_ros_line import MemoryLine, cdr, ros_robot

ZERO, AHEAD = Twist(), Twist.planar(0.4, 0.1)
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
ROBOT = """
[limits]
linear = 0.6
angular = 1.5
[ros]
address = "ws://127.0.0.1:8765"
stop_service = "/e_stop"
battery = "/battery"
imu = "/imu"
joints = "/joint_states"
[[range]]
name = "lidar"
kind = "laser"
beams = 8
first_deg = -180.0
farthest = 10.0
topic = "/scan"
[[light]]
name = "lamp"
topic = "/lamp"
[[joint]]
name = "pan"
lowest_deg = -90.0
highest_deg = 90.0
topic = "/pan/angle"
"""


class RobotInMemory:
    """A body, its line, and the time."""

    def __init__(self, tmp_path, more=ROBOT, velocities=TWIST, encoding="cdr"):
        self.now = 100.0
        self.line = MemoryLine(encodings=encoding)
        if velocities:
            self.line.topic("/cmd_vel", velocities)
        self.line.topic("/odom", "nav_msgs/msg/Odometry")
        self.body = RosBody(ros_robot(tmp_path, more), self.line, lambda: self.now)
        self.body.advance(0.0)

    def run(self, seconds, tick=0.01):
        for _ in range(round(seconds / tick)):
            self.now += tick
            self.body.advance(tick)

    def drive(self, twist=AHEAD):
        self.body.command(ZERO)
        self.body.command(twist)

    def odometry(self, x=0.0, theta=0.0, speed=0.0, age=0.0, clock=0.0, waited=None):
        """`waited`: how long it was in the robot before its middleware had it [s]."""
        stamp = Time.of(self.now + clock - (waited or 0.0))
        time_ns = 0 if waited is None else int((self.now + 500.0) * 1e9)
        pose = Pose3D(position=Point3D(x=x), orientation=Quaternion.of(0.0, 0.0, theta))
        value = Odometry(
            header=Header(stamp=stamp, frame_id="odom"),
            pose=PoseWithCovariance(pose=pose),
            twist=TwistWithCovariance(twist=Twist.planar(speed, 0.0)),
        )
        self.line.give("/odom", cdr(value), self.now, age, time_ns)

    @property
    def sensors(self):
        return self.body.sensors(1e9)

    def problem(self, name):
        return [each.message for each in self.sensors.diagnostics if each.name == name]
