"""The options of `rune-hub adopt`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from hub.command_line import CommandParser, Commands, number_type
from hub.inspection.record_options import reader
from hub.inspection.vehicle.options import vehicle_options
from hub.toml_reader import RefusedError, plain_name

_SCHEMES: Final = ("ws://", "wss://", "zenoh+tcp://", "zenoh+tls://")
_VEHICLE: Final = "mavlink:"
_seconds = number_type(float, 0.1, 3600.0, "number from 0.1 to 3600")


def with_kind(words: Sequence[str]) -> list[str]:
    """The words of the command line; addresses as `rune drive` takes them need no kind."""
    if len(words) < 2 or words[0] != "adopt" or words[1] in ("mavlink", "ros"):
        return list(words)
    if any(word.startswith(_SCHEMES) for word in words):
        return [words[0], "ros", *words[1:]]
    if any(word.startswith(_VEHICLE) for word in words):
        return [words[0], "mavlink", *(word.removeprefix(_VEHICLE) for word in words[1:])]
    return list(words)


def add_adopt(commands: Commands) -> None:
    """Add the command."""
    adopt = commands.add_parser(
        "adopt",
        help="write the robot file of a vehicle with an autopilot, or of a robot with ROS",
        description="Find a vehicle or a robot and write its robot file. Nothing in it changes. "
        "Exit codes: 0 written, 1 it cannot be driven, or the file is there or cannot be written, "
        "2 wrong usage, 3 there is no vehicle or robot.",
    )
    adopt.advice = "give an address, such as ws://HOST:8765 or mavlink:/dev/ttyACM0"
    kinds = adopt.add_subparsers(dest="task", required=True, metavar="KIND")
    mavlink = kinds.add_parser(
        "mavlink",
        parents=[vehicle_options(), _robot_file("its kind")],
        help="a vehicle with ArduPilot or PX4",
        description="Find a vehicle by its MAVLink heartbeats, ask what it is, and write its "
        "robot file. Say where it is: udp://:14550 (it sends to this machine; loopback only), "
        "udp://0.0.0.0:14550 (the same on all networks), udp://HOST:PORT, tcp://HOST:5760, "
        "/dev/ttyACM0, serial:///dev/ttyUSB0?baud=57600.",
    )
    mavlink.add_argument("address", help="where the vehicle is, such as udp://0.0.0.0:14550")
    ros = kinds.add_parser(
        "ros",
        parents=[_robot_file("its own")],
        help="a robot with ROS 1 or ROS 2",
        description="Look at the topics of a robot with ROS, and write its robot file. Nothing "
        "moves. Say where its bridge for Foxglove or its Zenoh router is: ws://HOST:8765, "
        "wss://HOST:8765, zenoh+tcp://HOST:7447?domain=0. The word `ros` may be left out.",
    )
    ros.add_argument("address", help="where the robot is, such as ws://127.0.0.1:8765")
    ros.add_argument(
        "--through",
        default="",
        metavar="ADDRESS",
        help="reach it there, as by a tunnel; the robot file keeps its own address",
    )
    ros.add_argument(
        "--tls",
        type=Path,
        metavar="FOLDER",
        help="folder with certificates, for zenoh+tls://: authority.pem, and its own",
    )
    ros.add_argument(
        "--seconds",
        type=_seconds,
        default=5.0,
        metavar="S",
        help="how long to listen at most (%(default)g); 1.5 at a port that refuses",
    )
    ros.add_argument(
        "--namespace",
        type=_namespace,
        default="",
        metavar="/NAME",
        help="of several robots, the one whose topics begin so; /: the one without a name",
    )


def run_adopt(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code."""
    if options.task == "ros":
        from hub.inspection.ros import adopt_command as of_ros

        return of_ros.run(options)
    from hub.inspection.vehicle import adopt_command

    return adopt_command.run(options)


def _robot_file(usual_name: str) -> CommandParser:
    """The options of the new robot file."""
    file = CommandParser(add_help=False)
    file.add_argument(
        "-o", "--output", type=Path, metavar="FILE.toml", help="new file; without: print it"
    )
    file.add_argument(
        "--name", type=reader(plain_name(32)), help=f"the robot's name; without: {usual_name}"
    )
    file.add_argument("--force", action="store_true", help="replace a file of this name")
    file.add_argument("--json", action="store_true", help="what was found, as JSON on one line")
    return file


def _namespace(text: str) -> str:
    from hub.robots.ros_table import ros_name

    if not text.strip("/"):
        return text[:1]
    try:
        return str(ros_name(f"/{text.strip('/')}"))
    except RefusedError as fault:
        raise argparse.ArgumentTypeError(str(fault)) from fault
