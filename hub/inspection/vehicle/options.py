"""The options of `rune-hub vehicle`, and those of a link to a vehicle."""

from __future__ import annotations

import argparse
from pathlib import Path

from hub.command_line import CommandParser, Commands, number_type
from hub.ipc.endpoints import endpoint_of
from hub.robots.mavlink.profiles.profile import STATION

_system = number_type(int, 0, 255, "number from 0 to 255")
_station = number_type(int, 1, 255, "number from 1 to 255")
_seconds = number_type(float, 0.1, 3600.0, "number from 0.1 to 3600")


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
        help="how long to listen (%(default)g); 1.5 at a port that refuses",
    )
    link.add_argument(
        "--station",
        type=_station,
        default=STATION,
        metavar="N",
        help="own number as a ground station, the vehicle's MAV_GCS_SYSID (%(default)s)",
    )
    link.add_argument(
        "--key", type=Path, metavar="FILE", help="file of its signing key; without: unsigned"
    )
    return link


def add_vehicle(commands: Commands) -> None:
    """Add `vehicle`."""
    vehicle = commands.add_parser(
        "vehicle",
        help="a vehicle with an autopilot: its parameters, mission, frames, key",
        description="Ask a vehicle with an autopilot, or change it when you say so. It is named by "
        "its robot file or by its address. Exit codes: 0 done, 1 it was refused or a part of it "
        "failed, 2 wrong usage, 3 there is no vehicle.",
    )
    tasks = vehicle.add_subparsers(dest="task", required=True, metavar="TASK")
    which = CommandParser(add_help=False, parents=[vehicle_options()])
    which.add_argument("vehicle", help="a robot file (TOML), or an address such as udp://:14550")
    _add_parameters(tasks, which)
    mission = tasks.add_parser(
        "mission",
        parents=[which],
        help="show its mission items, geofence and rally points",
        description="Ask the vehicle for its mission items, geofence and rally points, and show "
        "them. Nothing in the vehicle changes. Its hub may not run meanwhile: it has the link.",
    )
    mission.add_argument("--json", action="store_true", help="JSON, one line an item")
    _add_forward(tasks, which)
    key = tasks.add_parser(
        "key",
        parents=[vehicle_options()],
        help="make a signing key, and give it to the vehicle",
        description="Make the file of a signing key, for the robot file's key mavlink.key_file. "
        "With --setup the vehicle gets it, while it is disarmed: from then on it takes only signed "
        "frames, except at its first serial port (USB). Give it by a cable: whoever reads the link "
        "then can read the key.",
    )
    key.add_argument("file", type=Path, help="a new file; with --setup also one that is there")
    key.add_argument(
        "--phrase",
        action="store_true",
        help="make it of a phrase, as other stations do; it is asked for, or read from stdin",
    )
    key.add_argument(
        "--setup", metavar="ROBOT.toml|ADDRESS", help="give it to this vehicle; --key: its old one"
    )


def _add_forward(tasks: Commands, which: CommandParser) -> None:
    task = tasks.add_parser(
        "forward",
        parents=[which],
        help="let another ground station see it, beside its running hub",
        description="Send the frames of the vehicle to QGroundControl, MAVProxy or another program "
        "by UDP. Its hub runs and keeps the link. What the program sends back is counted and "
        "dropped, so it cannot change the vehicle. With --commands its commands, parameters and "
        "missions pass while no operator has control: it can then arm the vehicle and change its "
        "mode. Sticks, velocities and heartbeats never pass.",
    )
    task.add_argument(
        "--commands", action="store_true", help="pass its commands on while no other has control"
    )
    task.add_argument(
        "--to", required=True, metavar="udp://HOST:PORT", help="such as udp://127.0.0.1:14550"
    )
    task.add_argument("--hub", type=endpoint_of, help="as for other commands; without: the robot's")
    task.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    task.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")


def _add_parameters(tasks: Commands, which: CommandParser) -> None:
    task = tasks.add_parser(
        "parameters",
        parents=[which],
        help="show its parameters, or set some",
        description="Show the parameters that decide how the vehicle stops and drives, with the "
        "values that make it safe. They change only with --write, --write-safe or --restore, and "
        "not while it is armed or its hub runs. Each is read back, and the old values are kept in "
        "a file.",
    )
    task.add_argument("names", nargs="*", metavar="NAME", help="only these")
    task.add_argument("--all", action="store_true", help="all that it has, 1000 and more")
    task.add_argument("--unsafe", action="store_true", help="only those with an unsafe value")
    task.add_argument("--json", action="store_true", help="JSON, one line a parameter")
    change = task.add_mutually_exclusive_group()
    change.add_argument(
        "--write", nargs="+", default=[], metavar="NAME=VALUE", help="set these parameters"
    )
    change.add_argument("--write-safe", action="store_true", help="set those that are unsafe")
    change.add_argument("--restore", type=Path, metavar="FILE", help="set those in a file")


def run_vehicle(options: argparse.Namespace) -> int:
    """Carry out `vehicle`; returns the exit code."""
    if options.task == "forward":
        from hub.inspection.vehicle import forward_command

        return forward_command.run(options)
    if options.task == "mission":
        from hub.inspection.vehicle import mission_command

        return mission_command.run(options)
    if options.task == "key":
        from hub.inspection.vehicle import key_command

        return key_command.run(options)
    from hub.inspection.vehicle import parameters_command

    return parameters_command.run(options)
