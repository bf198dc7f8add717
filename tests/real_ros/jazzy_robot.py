"""A robot with ROS 2 Jazzy: real nodes of rclpy over DDS; run by the Python of `.venv-ros2`.

Writes a line of JSON for each velocity that its base takes: its time [s, monotonic], its speeds.
"""

from __future__ import annotations

import json
import math
import signal
import sys
import time

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, Image, Imu, LaserScan, Range

TIMEOUT_S = 0.5
ODOMETRY_S, SCAN_S, BATTERY_S = 0.02, 0.1, 0.25
TURN = (0.0, 0.0, math.sin(0.15), math.cos(0.15))
"""Quaternion of a heading of 0.3 rad."""


class Base(Node):
    """Wheels, as diff_drive_controller drives them."""

    def __init__(self) -> None:
        super().__init__("diff_drive_controller")
        self.declare_parameter("cmd_vel_timeout", TIMEOUT_S)
        self.declare_parameter("linear.x.max_velocity", 0.6)
        self.speed = self.turn = self.x = self.y = self.heading = 0.0
        self.came = -math.inf
        self.odometry = self.create_publisher(Odometry, "/odom", 10)
        self.create_subscription(TwistStamped, "/cmd_vel", self.take, 10)
        self.create_timer(ODOMETRY_S, self.step)

    def take(self, message: TwistStamped) -> None:
        now = time.monotonic()
        self.came = now
        self.speed, self.turn = message.twist.linear.x, message.twist.angular.z
        stamp = message.header.stamp
        line = {"t": now, "x": self.speed, "z": self.turn, "stamp": [stamp.sec, stamp.nanosec]}
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()

    def step(self) -> None:
        if time.monotonic() - self.came > TIMEOUT_S:
            self.speed = self.turn = 0.0
        self.heading += self.turn * ODOMETRY_S
        self.x += self.speed * math.cos(self.heading) * ODOMETRY_S
        self.y += self.speed * math.sin(self.heading) * ODOMETRY_S
        value = Odometry()
        value.header.stamp = self.get_clock().now().to_msg()
        value.header.frame_id, value.child_frame_id = "odom", "base_link"
        value.pose.pose.position.x, value.pose.pose.position.y = self.x, self.y
        value.pose.pose.orientation.z = math.sin(self.heading / 2.0)
        value.pose.pose.orientation.w = math.cos(self.heading / 2.0)
        value.twist.twist.linear.x, value.twist.twist.angular.z = self.speed, self.turn
        self.odometry.publish(value)


class Sensors(Node):
    """What it measures."""

    def __init__(self) -> None:
        super().__init__("sensors")
        latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        self.scan = self.create_publisher(LaserScan, "/scan", qos_profile_sensor_data)
        self.range = self.create_publisher(Range, "/sonar", qos_profile_sensor_data)
        self.imu = self.create_publisher(Imu, "/imu/data", qos_profile_sensor_data)
        self.image = self.create_publisher(Image, "/camera/image_raw", qos_profile_sensor_data)
        self.battery = self.create_publisher(BatteryState, "/battery_state", latched)
        self.create_timer(SCAN_S, self.look)
        self.create_timer(BATTERY_S, self.measure)

    def look(self) -> None:
        stamp = self.get_clock().now().to_msg()
        scan = LaserScan(angle_min=-math.pi, angle_max=math.pi, angle_increment=math.tau / 36)
        scan.header.stamp, scan.header.frame_id = stamp, "base_link"
        scan.range_min, scan.range_max, scan.ranges = 0.1, 8.0, [2.0 + n / 10 for n in range(36)]
        self.scan.publish(scan)
        sonar = Range(field_of_view=0.3, min_range=0.05, max_range=3.0, range=1.25, variance=0.5)
        sonar.header.stamp, sonar.header.frame_id = stamp, "base_link"
        self.range.publish(sonar)
        imu = Imu(orientation_covariance=[0.01 * (n % 4 == 0) for n in range(9)])
        imu.header.stamp, imu.header.frame_id = stamp, "base_link"
        turn = imu.orientation
        turn.x, turn.y, turn.z, turn.w = TURN
        imu.angular_velocity_covariance[0] = imu.linear_acceleration_covariance[0] = 0.02
        imu.linear_acceleration.z = 9.81
        self.imu.publish(imu)
        image = Image(width=32, height=24, encoding="rgb8", step=96)
        image.header.stamp, image.header.frame_id = stamp, "camera"
        image.data = bytes(range(256)) * 9
        self.image.publish(image)

    def measure(self) -> None:
        value = BatteryState(voltage=12.25, current=-1.5, charge=2.5, temperature=31.0)
        value.capacity, value.design_capacity, value.percentage = 5.0, 6.0, 0.5
        value.power_supply_status, value.present = (
            BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
            True,
        )
        value.power_supply_health = BatteryState.POWER_SUPPLY_HEALTH_GOOD
        value.power_supply_technology = BatteryState.POWER_SUPPLY_TECHNOLOGY_LION
        value.cell_voltage, value.cell_temperature = [4.0, 4.25, 4.0], [30.0, 31.0, 32.0]
        value.location, value.serial_number = "rear", "B-7"
        value.header.stamp = self.get_clock().now().to_msg()
        self.battery.publish(value)


def main() -> None:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    rclpy.init()
    executor = rclpy.executors.SingleThreadedExecutor()
    for node in (Base(), Sensors()):
        executor.add_node(node)
    sys.stdout.write(json.dumps({"ready": True}) + "\n")
    sys.stdout.flush()
    while rclpy.ok():
        executor.spin_once(Duration(seconds=0.1).nanoseconds * 1e-9)


main()
