"""Nodes of ROS 2 over Zenoh by zenoh-ros2-sdk, which others wrote: a robot, and a driver.

Each is a process of its own, since that library keeps one session for a process. A JSON line of
standard output says what happened. It ends with standard input.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
ODOMETRY, STAMPED = "nav_msgs/msg/Odometry", "geometry_msgs/msg/TwistStamped"
TWIST, MAP = "geometry_msgs/msg/Twist", "nav_msgs/msg/OccupancyGrid"
PERIOD_S = 0.02


class SdkNode:
    """A process with such a node."""

    def __init__(self, role: str, port: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.sdk_nodes", role, str(port)],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self.newest: dict[str, Any] = {}
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.newest = json.loads(line)

    def close(self) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait(10.0)
        self._reader.join()
        self._process.stdout.close()


class Node:
    """What both have: types by name, publishers and subscribers."""

    def __init__(self, port: int) -> None:
        from rosbags.typesys import Stores, get_typestore
        from zenoh_ros2_sdk.session import ZenohSession

        self.store = get_typestore(Stores.ROS2_JAZZY)
        session = ZenohSession.get_instance("127.0.0.1", port)
        # It would fetch the definitions from the network.
        session.store = self.store
        session.register_message_type = lambda _, name: self.store.types[name]
        self._port = port

    def _of(self, topic: str, kind: str, *, latched: bool) -> dict[str, Any]:
        from zenoh_ros2_sdk.qos import QosDurability, QosProfile

        quality = QosProfile(durability=QosDurability.TRANSIENT_LOCAL) if latched else None
        hashed = self.store.hash_rihs01(kind)
        place = {"topic": topic, "msg_type": kind, "router_port": self._port}
        return place | {"msg_definition": "known", "type_hash": hashed, "qos": quality}

    def publisher(self, topic: str, kind: str) -> Any:
        from zenoh_ros2_sdk import ROS2Publisher

        return ROS2Publisher(**self._of(topic, kind, latched=False), node_name="base")

    def subscriber(self, topic: str, kind: str, take: Any, *, latched: bool = False) -> Any:
        from zenoh_ros2_sdk import ROS2Subscriber

        return ROS2Subscriber(
            **self._of(topic, kind, latched=latched), callback=take, node_name="base"
        )

    def make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)

    def vector(self, x: float = 0.0, z: float = 0.0) -> Any:
        return self.make("geometry_msgs/msg/Vector3", x=x, y=0.0, z=z)


def say(**facts: Any) -> None:
    sys.stdout.write(json.dumps(facts) + "\n")
    sys.stdout.flush()


def robot(port: int) -> None:
    """A base that follows /cmd_vel and says where it is."""
    import numpy as np

    node = Node(port)
    wanted = {"linear": 0.0, "angular": 0.0}

    def take(message: Any) -> None:
        wanted.update(linear=message.twist.linear.x, angular=message.twist.angular.z)

    _kept = node.subscriber("/cmd_vel", STAMPED, take)
    odometry, x = node.publisher("/odom", ODOMETRY), 0.0
    while True:
        time.sleep(PERIOD_S)
        x += wanted["linear"] * PERIOD_S
        stamp_ns = time.time_ns()
        stamp = node.make(
            "builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9
        )
        pose = node.make(
            "geometry_msgs/msg/Pose",
            position=node.make("geometry_msgs/msg/Point", x=x, y=0.0, z=0.0),
            orientation=node.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        )
        speed = node.make(
            TWIST, linear=node.vector(wanted["linear"]), angular=node.vector(z=wanted["angular"])
        )
        unknown = np.zeros(36)
        odometry.publish(
            header=node.make("std_msgs/msg/Header", stamp=stamp, frame_id="odom"),
            child_frame_id="base_link",
            pose=node.make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=unknown),
            twist=node.make(
                "geometry_msgs/msg/TwistWithCovariance", twist=speed, covariance=unknown
            ),
        )
        say(**wanted)


def driver(port: int) -> None:
    """A node that reads the standard topics of a robot and drives it."""
    node = Node(port)
    came: Counter[str] = Counter()
    place = {"x": 0.0}

    def placed(message: Any) -> None:
        came["/odom"] += 1
        place["x"] = message.pose.pose.position.x

    def counted(topic: str) -> Any:
        def take(_: Any) -> None:
            came[topic] += 1

        return take

    _kept = [
        node.subscriber("/odom", ODOMETRY, placed),
        node.subscriber("/scan", "sensor_msgs/msg/LaserScan", counted("/scan")),
        node.subscriber("/tf", "tf2_msgs/msg/TFMessage", counted("/tf")),
        node.subscriber(
            "/tf_static", "tf2_msgs/msg/TFMessage", counted("/tf_static"), latched=True
        ),
        node.subscriber("/map", MAP, counted("/map"), latched=True),
    ]
    velocities = node.publisher("/cmd_vel", TWIST)
    begun = time.monotonic()
    while True:
        time.sleep(0.05)
        ahead = 0.2 if time.monotonic() - begun > 1.0 else 0.0  # a robot wants neutral first
        velocities.publish(linear=node.vector(ahead), angular=node.vector())
        say(x=place["x"], came=dict(came))


def main() -> None:
    role = {"robot": robot, "driver": driver}[sys.argv[1]]
    threading.Thread(target=role, args=(int(sys.argv[2]),), daemon=True).start()
    sys.stdin.read()
    os._exit(0)  # its threads cannot be ended


if __name__ == "__main__":
    main()
