"""The table `[ros]` of a robot file: where the parts of a robot with ROS are."""

from __future__ import annotations

import enum
import re
from typing import Final

from hub import toml_reader as toml
from hub.toml_reader import Within, choice, key, text, truth
from hub.values import dataclass

ROS_KIND: Final = "ros"
"""The kind of robots with ROS."""
_MOST_NAME: Final = 200
_NAME: Final = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+")


class CommandType(enum.Enum):
    """The type of the velocities that a robot takes.

    Attributes:
        AUTO: The one that the robot's nodes subscribe to.
        TWIST: geometry_msgs/Twist.
        STAMPED: geometry_msgs/TwistStamped.
    """

    AUTO = "auto"
    TWIST = "Twist"
    STAMPED = "TwistStamped"


def _ros_name(value: object) -> str:
    if value == "":
        return ""
    name: str = text(_MOST_NAME)(value)
    if not _NAME.fullmatch(name):
        reason = f"{toml.shorten(value)} is no whole name of ROS, such as '/base/odom'"
        raise toml.RefusedError(reason)
    return name


ros_name: Final = Within(_ros_name, "a whole name, such as `/base/odom`")
"""Reads the name of a topic or a service; an empty one is none."""
_frame: Final = text(64)


@dataclass(frozen=True, slots=True, kw_only=True)
class RosTable:
    """The table `[ros]`; each field has its `key` there."""

    address: str = key(
        text(_MOST_NAME),
        "",
        "of its bridge for Foxglove, `ws://HOST:8765`, or router, `zenoh+tcp://HOST:7447?domain=0`",
    )
    certificates: str = key(
        text(1000),
        "",
        "folder with certificates for `zenoh+tls://`: `authority.pem`, and its own",
        without="those of the system",
    )
    known_as: str = key(
        text(_MOST_NAME),
        "",
        "what stays the same while `address` changes, as in a tunnel; saved places belong to it",
        without="`address`",
    )
    cmd_vel: str = key(ros_name, "/cmd_vel", "topic of the velocities that it takes")
    cmd_vel_type: CommandType = key(
        choice({each.value: each for each in CommandType}),
        CommandType.AUTO,
        "their type; `auto`: the one that its nodes subscribe to",
    )
    hold: bool = key(
        truth,
        default=False,
        meaning="whether zeros go on while it stands, for a base that keeps its last velocity",
    )
    stop_service: str = key(
        ros_name,
        "",
        "service that a stop calls too: Trigger, Empty, SetBool of std_srvs, or EStop",
        without="none",
    )
    odom: str = key(
        ros_name, "/odom", "topic of its odometry; if nothing publishes it, the frames count"
    )
    tf: str = key(ros_name, "/tf", "topic of its frames that move")
    odom_frame: str = key(_frame, "odom", "name of the frame of dead reckoning")
    base_frame: str = key(_frame, "base_link", "name of the frame of the base")
    map_frame: str = key(_frame, "map", "name of the frame of its own map")
    battery: str = key(ros_name, "", "topic of its battery, a BatteryState", without="none")
    battery_percent: bool = key(
        truth,
        default=False,
        meaning="whether the battery's `percentage` counts to 100; BatteryState has 0 to 1",
    )
    imu: str = key(ros_name, "", "topic of tilt and turn rates, an Imu", without="none")
    joints: str = key(ros_name, "", "topic of its joints, a JointState", without="none")
    pressure: str = key(ros_name, "", "topic of the pressure, a FluidPressure", without="none")
    diagnostics: str = key(ros_name, "/diagnostics", "topic of what is wrong with it")
    navigation: str = key(
        ros_name,
        "",
        "action of its own navigation, Nav2's NavigateToPose or move_base, which drives to goals",
        without="Rune's navigation drives to goals",
    )
    map: str = key(
        ros_name,
        "",
        "topic of its own map, an OccupancyGrid, which takes the place of Rune's",
        without="Rune makes the map",
    )

    @property
    def identity(self) -> str:
        """What names the robot on this machine: in saved places, goals and claims."""
        return self.known_as or self.address
