"""The options of `rune-hub run`."""

from __future__ import annotations

import argparse
from pathlib import Path

from hub.command_line import Commands
from hub.errors import EndpointError
from hub.hub_sockets import LONGEST_NAME
from hub.ipc.endpoints import tcp_endpoint


def add_run(commands: Commands) -> None:
    """Add the command to the parser."""
    run = commands.add_parser("run", help="start central and a robot's modules; Ctrl-C ends all")
    run.add_argument("robot", help="a robot file (TOML), or the name of a shipped one")
    run.add_argument(
        "--as",
        dest="name",
        type=hub_name,
        default="",
        metavar="NAME",
        help="name of the hub on this machine, for --hub; without: the robot's",
    )
    run.add_argument(
        "--listen",
        type=_listen_place,
        default="",
        metavar="[HOST:]PORT",
        help="also listen at a TCP port of this machine, for clients with the hub's token; 0: a "
        "free one",
    )
    run.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="TABLE.KEY=VALUE",
        help="in place of what the file says, such as simulation.arena=empty; as often as needed",
    )
    run.add_argument("--record", type=Path, metavar="FILE", help="record all into a new file")
    run.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    run.add_argument("--stop-with-stdin", action="store_true", help="stop when standard input ends")
    run.add_argument(
        "--spawn", action="store_true", help="start each module as a new program; do not fork it"
    )


def _listen_place(text: str) -> str:
    """HOST:PORT or PORT of this machine."""
    place = text if ":" in text or not text else f"127.0.0.1:{text}"
    try:
        if place:
            tcp_endpoint(place)
    except EndpointError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return place


def hub_name(text: str) -> str:
    """A name of a hub of this machine."""
    if text.startswith("-") or len(text) > LONGEST_NAME or not text.isprintable():
        message = f"{text!r} is not a name of at most {LONGEST_NAME} characters"
        raise argparse.ArgumentTypeError(message)
    return text
