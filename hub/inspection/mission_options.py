"""The options of `rune-hub mission`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hub.command_line import CommandParser, Commands, number_type

if TYPE_CHECKING:
    from hub.ipc.client import Client

_whole = number_type(int, 1, 10**6, "whole number above 0")


def run_mission(options: argparse.Namespace) -> int:
    """Carry out a command about the records of missions; no hub needs to run."""
    from hub.inspection import mission_commands

    if options.task == "list":
        return mission_commands.list_all(options.robot, options.folder, as_json=options.json)
    which = options.id, options.robot, options.folder
    if options.task == "show":
        return mission_commands.show(*which, as_json=options.json)
    if options.task == "export":
        return mission_commands.export(*which, options.output)
    from hub.inspection import score_command

    how = {"arena": options.arena, "berth": options.berth, "operators": options.operators}
    return score_command.show(*which, **how, as_json=options.json)


def order_mission(client: Client, options: argparse.Namespace) -> int:
    """Carry out a command for the robot that keeps the mission."""
    from hub.gcm.mission import MissionAction
    from hub.inspection import mission_commands

    name = " ".join(getattr(options, "name", ()))
    return mission_commands.order(client, MissionAction[options.task.upper()], name)


def add_missions(commands: Commands, look: CommandParser) -> None:
    """Add the command."""
    mission = commands.add_parser("mission", help="what robots have kept, and the one that runs")
    tasks = mission.add_subparsers(dest="task", required=True, metavar="TASK")
    where = CommandParser(add_help=False)
    where.add_argument(
        "--robot", default="", help="a name of column 'robot' of the list, or a robot file"
    )
    where.add_argument("--folder", default="", help="folder of the missions, if not the usual one")
    listing = tasks.add_parser("list", parents=[where], help="all missions, the oldest first")
    show = tasks.add_parser("show", parents=[where], help="marks and events of a mission")
    export = tasks.add_parser("export", parents=[where], help="write a mission into files")
    score = tasks.add_parser(
        "score", parents=[where], help="compare the marks of a mission with an arena's victims"
    )
    score.add_argument("--arena", required=True, help="a shipped arena, or an arena file")
    score.add_argument(
        "--berth", default="", help="kind of the robot that started at its berth; without: [start]"
    )
    score.add_argument("--operators", type=_whole, default=1, help="how many (%(default)s)")
    for command in (show, export, score):
        command.add_argument("id", nargs="?", default="", help="which; without: the newest")
    for command in (listing, show, score):
        command.add_argument("--json", action="store_true", help="JSON, one line a mission")
    export.add_argument("-o", "--output", type=Path, help="folder for the files; without: ./ID")
    begin = tasks.add_parser("begin", parents=[look], help="have the robot begin a mission")
    begin.add_argument("name", nargs="*", metavar="NAME", help="its name; without: date and time")
    name = tasks.add_parser("name", parents=[look], help="give the mission another name")
    name.add_argument("name", nargs="+", metavar="NAME", help="that")
    tasks.add_parser("end", parents=[look], help="end the mission; its folder stays")
