"""The options of `rune-hub adopt`."""

from __future__ import annotations

import argparse
from pathlib import Path

from hub.command_line import CommandParser, Commands, number_type
from hub.inspection.record_options import reader
from hub.toml_reader import plain_name

_system = number_type(int, 0, 255, "number from 0 to 255")
_seconds = number_type(float, 0.1, 3600.0, "number from 0.1 to 3600")


def add_adopt(commands: Commands) -> None:
    """Add `adopt`."""
    adopt = commands.add_parser(
        "adopt",
        help="write the robot file of a vehicle with an autopilot",
        description="Find a vehicle and write its robot file. Nothing in the vehicle changes. "
        "Exit codes: 0 written, 1 the file is there or cannot be written, 2 wrong usage, 3 there "
        "is no vehicle.",
    )
    kinds = adopt.add_subparsers(dest="task", required=True, metavar="KIND")
    mavlink = kinds.add_parser(
        "mavlink",
        parents=[vehicle_options()],
        help="a vehicle with ArduPilot or PX4",
        description="Find a vehicle by its MAVLink heartbeats, ask what it is, and write its "
        "robot file. Say where it is: udp://:14550 (it sends to this machine; loopback only), "
        "udp://0.0.0.0:14550 (the same on all networks), udp://HOST:PORT, tcp://HOST:5760, "
        "/dev/ttyACM0, serial:///dev/ttyUSB0?baud=57600.",
    )
    mavlink.add_argument("address", help="where the vehicle is, such as udp://0.0.0.0:14550")
    mavlink.add_argument(
        "-o", "--output", type=Path, metavar="FILE.toml", help="new file; without: print it"
    )
    mavlink.add_argument(
        "--name",
        type=reader(plain_name(32)),
        help="the robot's name; without: its kind",
    )
    mavlink.add_argument("--force", action="store_true", help="replace a file of this name")
    mavlink.add_argument("--json", action="store_true", help="what was found, as JSON on one line")


def vehicle_options() -> CommandParser:
    """The options of a link to a vehicle."""
    link = CommandParser(add_help=False)
    link.add_argument(
        "--system",
        type=_system,
        default=0,
        metavar="N",
        help="number of the vehicle; 0: the only one",
    )
    link.add_argument(
        "--seconds",
        type=_seconds,
        default=5.0,
        metavar="S",
        help="how long to listen (%(default)g)",
    )
    link.add_argument(
        "--key", type=Path, metavar="FILE", help="file of its signing key; without: unsigned"
    )
    return link


def run_adopt(options: argparse.Namespace) -> int:
    """Carry out `adopt`; returns the exit code."""
    from hub.inspection.vehicle import adopt_command

    return adopt_command.run(options)
