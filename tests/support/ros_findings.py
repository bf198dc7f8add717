"""Robots with ROS as adopting finds them, made of a few lines each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.findings import HeardTopic, RosFindings
from hub.robots.ros.line import RosGraph, RosService, RosTopic
from hub.ros.frame_tree import FrameTree
from hub.ros.values import NamedValue

ADDRESS = "ws://127.0.0.1:8765"
UPRIGHT = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
OPTICAL = {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}
Spec = Mapping[str, Any]


def header(frame: str) -> dict[str, Any]:
    return {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": frame}


def odometry(frame: str = "odom", child: str = "base_link") -> dict[str, Any]:
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    return {
        "header": header(frame),
        "child_frame_id": child,
        "pose": {"pose": {"position": zero, "orientation": UPRIGHT}},
        "twist": {"twist": {"linear": zero, "angular": zero}},
    }


def scan(frame: str, beams: int = 360, spread: float = math.tau) -> dict[str, Any]:
    return {
        "header": header(frame),
        "angle_min": -spread / 2.0,
        "angle_max": spread / 2.0,
        "angle_increment": spread / beams,
        "range_min": 0.16,
        "range_max": 12.0,
        "ranges": [1.0] * beams,
    }


def sonar(frame: str) -> dict[str, Any]:
    return {
        "header": header(frame),
        "radiation_type": 0,
        "field_of_view": 0.26,
        "min_range": 0.1,
        "max_range": 3.0,
        "range": 1.0,
    }


def camera_info(frame: str, width: int = 320, focal: float = 264.0) -> dict[str, Any]:
    return {
        "header": header(frame),
        "width": width,
        "height": width * 3 // 4,
        "k": [focal, 0.0, 0.0, 0.0, focal, 0.0, 0.0, 0.0, 1.0],
    }


def transform(
    parent: str, child: str, x: float, y: float, z: float, turn: Mapping[str, float] = UPRIGHT
) -> dict[str, Any]:
    return {
        "header": header(parent),
        "child_frame_id": child,
        "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": dict(turn)},
    }


def found(
    topics: Mapping[str, Spec],
    *,
    frames: tuple[dict[str, Any], ...] = (),
    services: Mapping[str, str] | None = None,
    parameters: Mapping[str, object] | None = None,
    whole: bool = True,
    distribution: str = "jazzy",
    encoding: str = "cdr",
    **more: Any,
) -> RosFindings:
    """A robot.

    Args:
        topics: By name: type, and where they are known "by", "to" and the message "said".
        frames: Its static transforms.
        services: Types by name.
        parameters: Its parameters.
        whole: Whether publishers and subscribers are known.
        distribution: Of ROS.
        encoding: Of messages.
        more: Further fields of the findings.
    """
    tree = FrameTree()
    tree.take(NamedValue("tf2_msgs/msg/TFMessage", {"transforms": list(frames)}))
    graph = RosGraph(
        distribution=distribution,
        topics={
            name: RosTopic(
                name=name,
                schema_name=spec["type"],
                encoding=encoding,
                publishers=tuple(spec.get("by", ())),
                subscribers=tuple(spec.get("to", ())),
            )
            for name, spec in topics.items()
        },
        services={
            name: RosService(name=name, type=kind) for name, kind in (services or {}).items()
        },
        whole=whole,
    )
    heard = {
        name: HeardTopic(
            messages=1,
            rate_hz=spec.get("rate", math.nan),
            value=NamedValue(spec["type"], spec["said"]) if "said" in spec else None,
            fault=spec.get("fault", ""),
        )
        for name, spec in topics.items()
        if "said" in spec or "fault" in spec
    }
    given = {"address": ros_address(ADDRESS), **more}
    return RosFindings(
        graph=graph, heard=heard, frames=tree, parameters=dict(parameters or {}), **given
    )


TURTLEBOT_4: dict[str, Any] = {
    "/cmd_vel": {"type": "geometry_msgs/msg/TwistStamped", "to": ("/motion_control",)},
    "/cmd_vel_unstamped": {"type": "geometry_msgs/msg/Twist", "to": ("/motion_control",)},
    "/odom": {
        "type": "nav_msgs/msg/Odometry",
        "by": ("/motion_control",),
        "said": odometry(),
        "rate": 20.0,
    },
    "/scan": {
        "type": "sensor_msgs/msg/LaserScan",
        "by": ("/rplidar",),
        "said": scan("rplidar_link", 720),
        "rate": 7.5,
    },
    "/tf": {"type": "tf2_msgs/msg/TFMessage", "by": ("/motion_control",)},
    "/tf_static": {"type": "tf2_msgs/msg/TFMessage", "by": ("/robot_state_publisher",)},
    "/battery_state": {"type": "sensor_msgs/msg/BatteryState", "by": ("/create3",), "said": {}},
    "/imu": {"type": "sensor_msgs/msg/Imu", "by": ("/create3",), "said": {}},
    "/joint_states": {"type": "sensor_msgs/msg/JointState", "by": ("/create3",), "said": {}},
    "/oakd/rgb/preview/image_raw": {"type": "sensor_msgs/msg/Image", "by": ("/oakd",)},
    "/oakd/rgb/preview/image_raw/compressed": {
        "type": "sensor_msgs/msg/CompressedImage",
        "by": ("/oakd",),
        "said": {},
    },
    "/oakd/rgb/preview/image_raw/compressedDepth": {
        "type": "sensor_msgs/msg/CompressedImage",
        "by": ("/oakd",),
    },
    "/oakd/rgb/preview/camera_info": {
        "type": "sensor_msgs/msg/CameraInfo",
        "by": ("/oakd",),
        "said": camera_info("oakd_rgb_camera_optical_frame"),
    },
    "/hazard_detection": {
        "type": "irobot_create_msgs/msg/HazardDetectionVector",
        "by": ("/create3",),
    },
    "/cmd_lightring": {"type": "irobot_create_msgs/msg/LightringLeds", "to": ("/create3",)},
}
TURTLEBOT_4_FRAMES = (
    transform("base_footprint", "base_link", 0.0, 0.0, 0.006),
    transform(
        "base_link", "rplidar_link", -0.04, 0.0, 0.193, {**UPRIGHT, "z": 0.7071, "w": 0.7071}
    ),
    transform("base_link", "oakd_link", -0.06, 0.0, 0.244),
    transform("oakd_link", "oakd_rgb_camera_optical_frame", 0.0, 0.0, 0.0, OPTICAL),
)


def turtlebot_4(**more: Any) -> RosFindings:
    given = {
        "frames": TURTLEBOT_4_FRAMES,
        "services": {"/e_stop": "irobot_create_msgs/srv/EStop", "/robot_power": "x/srv/RobotPower"},
        **more,
    }
    return found(given.pop("topics", TURTLEBOT_4), **given)


def clearpath() -> RosFindings:
    place = "/a200_0000"
    twist = "geometry_msgs/msg/TwistStamped"
    topics = {
        f"{place}/cmd_vel": {"type": twist, "to": (f"{place}/twist_mux",)},
        f"{place}/joy_teleop/cmd_vel": {
            "type": twist,
            "by": (f"{place}/joy_teleop/teleop_twist_joy_node",),
            "to": (f"{place}/twist_mux",),
        },
        f"{place}/platform/cmd_vel": {
            "type": twist,
            "by": (f"{place}/twist_mux",),
            "to": (f"{place}/platform_velocity_controller",),
        },
        f"{place}/platform/odom": {
            "type": "nav_msgs/msg/Odometry",
            "by": (f"{place}/platform_velocity_controller",),
            "said": odometry(),
        },
        f"{place}/platform/odom/filtered": {
            "type": "nav_msgs/msg/Odometry",
            "by": (f"{place}/ekf_node",),
            "said": odometry(),
        },
        f"{place}/sensors/lidar2d_0/scan": {
            "type": "sensor_msgs/msg/LaserScan",
            "by": (f"{place}/sensors/lidar2d_0/urg",),
            "said": scan("lidar2d_0_laser", 1081, math.radians(270.0)),
            "rate": 40.0,
        },
        f"{place}/sensors/camera_0/color/image": {
            "type": "sensor_msgs/msg/Image",
            "by": (f"{place}/camera_0",),
            "said": {"header": header("camera_0_color"), "width": 640, "height": 480},
        },
        f"{place}/platform/bms/state": {
            "type": "sensor_msgs/msg/BatteryState",
            "by": (f"{place}/bms",),
            "said": {},
        },
        f"{place}/tf": {"type": "tf2_msgs/msg/TFMessage", "by": (f"{place}/ekf_node",)},
        f"{place}/diagnostics": {
            "type": "diagnostic_msgs/msg/DiagnosticArray",
            "by": (f"{place}/bms",),
        },
        f"{place}/sensors/lidar3d_0/points": {
            "type": "sensor_msgs/msg/PointCloud2",
            "by": (f"{place}/velodyne",),
        },
    }
    action = f"{place}/navigate_to_pose/_action"
    kind = "nav2_msgs/action/NavigateToPose"
    for part, name in (
        ("status", "action_msgs/msg/GoalStatusArray"),
        ("feedback", f"{kind}_FeedbackMessage"),
    ):
        topics[f"{action}/{part}"] = {"type": name, "by": (f"{place}/bt_navigator",)}
    services = {
        f"{action}/send_goal": f"{kind}_SendGoal",
        f"{action}/cancel_goal": "action_msgs/srv/CancelGoal",
        f"{action}/get_result": f"{kind}_GetResult",
        f"{place}/spin/_action/send_goal": "nav2_msgs/action/Spin_SendGoal",
    }
    parameters = {
        f"{place}/platform_velocity_controller.cmd_vel_timeout": 0.25,
        f"{place}/platform_velocity_controller.linear.x.max_velocity": 1.0,
        f"{place}/platform_velocity_controller.angular.z.max_velocity": 2.0,
        f"{place}/twist_mux.use_sim_time": False,
    }
    frames = (transform("base_link", "lidar2d_0_laser", 0.3, 0.0, 0.4),)
    return found(topics, frames=frames, services=services, parameters=parameters)


def ros_1() -> RosFindings:
    topics = {
        "/mobile_base/commands/velocity": {
            "type": "geometry_msgs/msg/Twist",
            "to": ("/mobile_base",),
        },
        "/odom": {
            "type": "nav_msgs/msg/Odometry",
            "by": ("/mobile_base",),
            "said": odometry("/odom", "/base_footprint"),
        },
        "/front/scan": {
            "type": "sensor_msgs/msg/LaserScan",
            "by": ("/lidar",),
            "said": scan("laser", 640, math.radians(240.0)),
        },
        "/sonar_front": {
            "type": "sensor_msgs/msg/Range",
            "by": ("/sonars",),
            "said": sonar("sonar_front"),
        },
        "/map": {
            "type": "nav_msgs/msg/OccupancyGrid",
            "by": ("/map_server",),
            "said": {"header": header("map")},
        },
        "/move_base/status": {
            "type": "actionlib_msgs/msg/GoalStatusArray",
            "by": ("/move_base",),
        },
        "/move_base/feedback": {
            "type": "move_base_msgs/msg/MoveBaseActionFeedback",
            "by": ("/move_base",),
        },
        "/joint_states": {
            "type": "sensor_msgs/msg/JointState",
            "by": ("/head",),
            "said": {"name": ["head_pan_joint", "wheel_left_joint"]},
        },
        "/head_pan_controller/command": {"type": "std_msgs/msg/Float64", "to": ("/head",)},
        "/headlight": {"type": "std_msgs/msg/Bool", "to": ("/lights",)},
        "/tf": {"type": "tf2_msgs/msg/TFMessage", "by": ("/mobile_base",)},
    }
    return found(
        topics,
        frames=(
            transform("base_footprint", "base_link", 0.0, 0.0, 0.1),
            transform("base_link", "laser", 0.1, 0.0, 0.2),
        ),
        parameters={
            "/mobile_base/cmd_vel_timeout": 0.6,
            "/move_base/local_costmap/robot_radius": 0.18,
            "/robot_description": (
                '<robot name="kobuki"><link name="base_link"><collision><geometry>'
                '<cylinder radius="0.178" length="0.1"/></geometry></collision></link></robot>'
            ),
        },
        distribution="noetic",
        encoding="ros1",
    )


def bare_firmware() -> RosFindings:
    """Two topics, and neither a graph nor parameters."""
    topics = {
        "/cmd_vel": {"type": "geometry_msgs/msg/Twist"},
        "/odom": {"type": "nav_msgs/msg/Odometry", "said": odometry()},
    }
    return found(topics, whole=False, distribution="")


ROBOTS = {
    "turtlebot4": turtlebot_4,
    "clearpath": clearpath,
    "ros1": ros_1,
    "bare": bare_firmware,
}
