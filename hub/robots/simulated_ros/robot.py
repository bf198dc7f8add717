"""The robot behind the bridge: its body, its controller, the messages of its topics; no sockets.

| topic | by |
| --- | --- |
| `/odom`, `/tf`, `/joint_states` | the wheels |
| `/scan`, `/imu`, `/battery_state` | the simulated body |
| `/camera/...` | the simulated camera |
| `/map`, `/tf_static` | the arena and the body, latched: a later subscriber gets the last |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from hub.gcm.camera_info import CameraInfo
from hub.gcm.diagnostics import Diagnostics, DiagnosticStatus, Severity
from hub.gcm.geometry import (
    Point3D,
    Pose3D,
    PoseWithCovariance,
    Quaternion,
    TwistWithCovariance,
    Vector3,
)
from hub.gcm.imu import Acceleration, Imu
from hub.gcm.joints import JointState, JointStates
from hub.gcm.odometry import Odometry
from hub.gcm.standard import BASE_LINK, MAP, ODOM, Header, Time
from hub.gcm.transforms import (
    Transform,
    Transforms,
    TransformStamped,
    Translation,
    optical_frame,
    static_transforms,
)
from hub.grids.grid import Grid
from hub.pose import Pose, wrapped
from hub.robots.interfaces import Sensors
from hub.robots.registry import body_of, kind_of, open_camera
from hub.robots.robot_file import read_description
from hub.robots.simulated_ros.arena_grid import occupancy_grid
from hub.robots.simulated_ros.controller import DiffDriveController
from hub.robots.simulated_ros.own_navigation import SimulatedNavigation
from hub.robots.simulated_ros.pictures import jpeg_file
from hub.sim.arena import load_arena
from hub.sim.spatial_pose import SpatialPose
from hub.values import dataclass

ROBOT_FILE: Final = Path(__file__).with_name("wheels.toml")
COMMANDS: Final = "/cmd_vel"
IMAGE: Final = "/camera/image_raw"
_CONTROLLER: Final = "/diff_drive_controller"
_SCANNER: Final = "/lidar_driver"
_BASE: Final = "/base_driver"
_CAMERA: Final = "/camera_driver"
_TRACK: Final = 0.28
"""From wheel to wheel [m]."""
_WHEEL: Final = 0.035
"""Radius of a wheel [m]."""
_GRAVITY: Final = 9.81


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedTopic:
    """A topic that the robot publishes.

    Attributes:
        name: Its name.
        type: Its type as ROS 2 writes it.
        period: From a message to the next [s]; 0: once, and again for each new subscriber.
        node: The node that publishes it.
    """

    name: str
    type: str
    period: float
    node: str


TOPICS: Final = (
    SimulatedTopic(name="/odom", type="nav_msgs/msg/Odometry", period=0.02, node=_CONTROLLER),
    SimulatedTopic(name="/tf", type="tf2_msgs/msg/TFMessage", period=0.02, node=_CONTROLLER),
    SimulatedTopic(
        name="/tf_static", type="tf2_msgs/msg/TFMessage", period=0.0, node="/robot_state_publisher"
    ),
    SimulatedTopic(name="/scan", type="sensor_msgs/msg/LaserScan", period=0.1, node=_SCANNER),
    SimulatedTopic(
        name="/battery_state", type="sensor_msgs/msg/BatteryState", period=1.0, node=_BASE
    ),
    SimulatedTopic(name="/imu", type="sensor_msgs/msg/Imu", period=0.02, node=_BASE),
    SimulatedTopic(
        name="/joint_states",
        type="sensor_msgs/msg/JointState",
        period=0.05,
        node="/joint_state_broadcaster",
    ),
    SimulatedTopic(name=IMAGE, type="sensor_msgs/msg/Image", period=0.1, node=_CAMERA),
    SimulatedTopic(
        name=f"{IMAGE}/compressed",
        type="sensor_msgs/msg/CompressedImage",
        period=0.1,
        node=_CAMERA,
    ),
    SimulatedTopic(
        name="/camera/camera_info", type="sensor_msgs/msg/CameraInfo", period=0.1, node=_CAMERA
    ),
    SimulatedTopic(name="/map", type="nav_msgs/msg/OccupancyGrid", period=0.0, node="/map_server"),
    SimulatedTopic(
        name="/diagnostics", type="diagnostic_msgs/msg/DiagnosticArray", period=1.0, node=_BASE
    ),
)


class SimulatedRosRobot:
    """A robot with two driven wheels; used by one thread.

    Attributes:
        controller: Takes the velocities.
    """

    def __init__(self, arena: str = "", seed: int = 1, *, timeout: float) -> None:
        """Stand at the start of an arena.

        Args:
            arena: Name of a shipped arena, or the path of one; empty: the body's own.
            seed: Of all noise.
            timeout: For how long a command counts [s]; 0: until the next one.

        Raises:
            ArenaError: There is no such arena.
        """
        settings = [f"simulation.arena={arena}"] * bool(arena) + [f"simulation.seed={seed}"]
        robot, _ = read_description(ROBOT_FILE, settings)
        self.controller = DiffDriveController(timeout)
        self._arena = load_arena(robot.arena)
        self._body = kind_of(robot).open_body(robot)
        self._described = body_of(robot)
        self._camera = open_camera(robot, robot.cameras[0])
        self._picture: tuple[float, npt.NDArray[np.uint8]] = (-math.inf, np.empty(0, np.uint8))
        self._sensors: Sensors = self._body.sensors(0.0)
        self._wheels = (0.0, 0.0)
        self._stamp = 0.0
        self._makers: Mapping[str, Callable[[], Any]] = {
            "/odom": self._odometry,
            "/tf": self._transforms,
            "/tf_static": lambda: static_transforms(self._described),
            "/scan": lambda: self._sensors.scans[0],
            "/battery_state": self._battery,
            "/imu": self._imu,
            "/joint_states": self._joints,
            IMAGE: self._image,
            f"{IMAGE}/compressed": self._compressed,
            "/camera/camera_info": self._camera_info,
            "/map": lambda: occupancy_grid(self._arena, self._header(MAP)),
            "/diagnostics": self._diagnostics,
        }

    def advance(self, seconds: float, stamp: float) -> None:
        """Let time pass.

        Args:
            seconds: How much [s].
            stamp: The time by the robot's clock afterwards [s since the epoch].
        """
        self._stamp = stamp
        self._body.command(self.controller.velocity(stamp))
        self._body.advance(seconds)
        self._camera.advance(seconds)
        self._sensors = self._body.sensors(stamp)
        speed, turn = self.motion
        self._wheels = (
            self._wheels[0] + (speed - turn * _TRACK / 2.0) / _WHEEL * seconds,
            self._wheels[1] + (speed + turn * _TRACK / 2.0) / _WHEEL * seconds,
        )

    @property
    def pose(self) -> Pose:
        """Its true pose on its map."""
        truth = self._body.ground_truth()
        if truth is None:
            return Pose(x=self._sensors.x, y=self._sensors.y, theta=self._sensors.theta)
        return Pose(x=truth.x, y=truth.y, theta=truth.theta)

    @property
    def odom(self) -> Pose:
        """The origin of `odom` on its map."""
        read, pose = self._sensors, self.pose
        turned = Pose(theta=wrapped(pose.theta - read.theta))
        x, y = turned.outward(read.x, read.y)
        return Pose(x=pose.x - x, y=pose.y - y, theta=turned.theta)

    def navigation(self, *, old: bool) -> SimulatedNavigation:
        """The navigation of its own, which sees its map.

        Args:
            old: Whether it is move_base of ROS 1.
        """
        found = occupancy_grid(self._arena, self._header(MAP))
        info = found["info"]
        origin = info["origin"].position
        grid = Grid(
            cells=found["data"], resolution=info["resolution"], origin_x=origin.x, origin_y=origin.y
        )
        return SimulatedNavigation(grid, self._described.radius, (MAP, ODOM), old=old)

    @property
    def motion(self) -> tuple[float, float]:
        """Its true velocities forward [m/s] and counter-clockwise [rad/s]."""
        velocity = self._sensors.velocity
        return velocity.linear.x, velocity.angular.z

    def message(self, topic: str) -> Any:  # noqa: ANN401 - each topic has a type of its own
        """The newest message of a topic, as `RosEncoder` takes it."""
        return self._makers[topic]()

    def _header(self, frame: str) -> Header:
        return Header(stamp=Time.of(self._stamp), frame_id=frame)

    def _odometry(self) -> Odometry:
        read = self._sensors
        pose = Pose3D(
            position=Point3D(x=read.x, y=read.y), orientation=Quaternion.of(0.0, 0.0, read.theta)
        )
        return Odometry(
            header=self._header(ODOM),
            pose=PoseWithCovariance(pose=pose),
            twist=TwistWithCovariance(twist=read.velocity),
        )

    def _transforms(self) -> Transforms:
        read, odom = self._sensors, self.odom
        own, drift = (read.x, read.y, read.theta), (odom.x, odom.y, odom.theta)
        return Transforms(
            transforms=(self._moved(ODOM, BASE_LINK, own), self._moved(MAP, ODOM, drift))
        )

    def _moved(self, parent: str, child: str, pose: tuple[float, float, float]) -> TransformStamped:
        x, y, yaw = pose
        place, rotation = Translation(x=x, y=y), Quaternion.of(0.0, 0.0, yaw)
        return TransformStamped(
            header=self._header(parent),
            child_frame_id=child,
            transform=Transform(translation=place, rotation=rotation),
        )

    def _battery(self) -> dict[str, Any]:
        read, unknown = self._sensors, math.nan
        return {
            "header": self._header(BASE_LINK),
            "voltage": read.battery_voltage,
            "percentage": read.battery_fraction,
            "power_supply_status": 2,
            "present": True,
            **dict.fromkeys(("temperature", "current", "charge", "capacity"), unknown),
            "design_capacity": unknown,
        }

    def _imu(self) -> Imu:
        return Imu.of(
            self._header(BASE_LINK),
            roll=0.0,
            pitch=0.0,
            heading=self._sensors.theta,
            turning=Vector3(z=self.motion[1]),
            acceleration=Acceleration(z=_GRAVITY),
        )

    def _joints(self) -> JointStates:
        speed, turn = self.motion
        sides = (("wheel_left_joint", -1.0), ("wheel_right_joint", 1.0))
        joints = (
            JointState(
                name=name,
                position=math.remainder(angle, math.tau),
                velocity=(speed + side * turn * _TRACK / 2.0) / _WHEEL,
                effort=0.0,
            )
            for (name, side), angle in zip(sides, self._wheels, strict=True)
        )
        return JointStates.of(joints, self._header(""))

    def _pixels(self) -> npt.NDArray[np.uint8]:
        """The picture of this moment; shape (height, width, 3)."""
        taken, pixels = self._picture
        if taken != self._stamp:
            truth = self._body.ground_truth()
            if truth is not None:
                pose = SpatialPose(x=truth.x, y=truth.y, z=0.0, yaw=truth.theta)
                self._camera.place(pose, self._stamp)
            body = self._described.cameras[0]
            pixels = self._camera.take(body.width_px, body.height_px, self._stamp).pixels
            self._picture = self._stamp, pixels
        return pixels

    def _image(self) -> dict[str, Any]:
        pixels = self._pixels()
        height, width, channels = pixels.shape
        return {
            "header": self._header(optical_frame("camera")),
            "height": height,
            "width": width,
            "encoding": "rgb8",
            "step": width * channels,
            "data": pixels,
        }

    def _compressed(self) -> dict[str, Any]:
        header = self._header(optical_frame("camera"))
        data = np.frombuffer(jpeg_file(self._pixels()), np.uint8)
        return {"header": header, "format": "rgb8; jpeg compressed bgr8", "data": data}

    def _camera_info(self) -> CameraInfo:
        body = self._described.cameras[0]
        return CameraInfo.of(
            self._header(optical_frame("camera")),
            width_px=body.width_px,
            height_px=body.height_px,
            horizontal_fov=body.horizontal_fov,
        )

    def _diagnostics(self) -> Diagnostics:
        halted = self.controller.halted
        status = DiagnosticStatus(
            level=Severity.WARN if halted else Severity.OK,
            name="diff_drive_controller: base",
            message="stopped by /e_stop" if halted else "drives",
            hardware_id="wheels",
        )
        return Diagnostics(header=self._header(""), status=(status,))
