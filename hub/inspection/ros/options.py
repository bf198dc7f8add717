"""The options of `rune-hub adopt` for robots with ROS."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from hub.command_line import Commands, number_type
from hub.inspection.record_options import reader
from hub.toml_reader import RefusedError, plain_name

_SCHEMES: Final = ("ws://", "wss://", "zenoh+tcp://", "zenoh+tls://")
_seconds = number_type(float, 0.1, 3600.0, "number from 0.1 to 3600")


def with_kind(words: Sequence[str]) -> list[str]:
    """The words of the command line; before an address of ROS the word `ros` may be left out."""
    adopts = len(words) > 1 and words[0] == "adopt" and words[1] not in ("mavlink", "ros")
    if adopts and any(word.startswith(_SCHEMES) for word in words):
        return [words[0], "ros", *words[1:]]
    return list(words)


def _namespace(text: str) -> str:
    from hub.robots.ros_table import ros_name

    if not text:
        return ""
    try:
        return str(ros_name(f"/{text.strip('/')}"))
    except RefusedError as fault:
        raise argparse.ArgumentTypeError(str(fault)) from fault


def add_ros(kinds: Commands) -> None:
    """Add the kind `ros`."""
    ros = kinds.add_parser(
        "ros",
        help="a robot with ROS 1 or ROS 2",
        description="Look at the topics of a robot with ROS, and write its robot file. Nothing "
        "moves. Say where its bridge for Foxglove or its Zenoh router is: ws://HOST:8765, "
        "wss://HOST:8765, zenoh+tcp://HOST:7447?domain=0. The word `ros` may be left out.",
    )
    ros.add_argument("address", help="where the robot is, such as ws://127.0.0.1:8765")
    ros.add_argument(
        "--seconds",
        type=_seconds,
        default=5.0,
        metavar="S",
        help="how long to listen at most (%(default)g)",
    )
    ros.add_argument(
        "--namespace",
        type=_namespace,
        default="",
        metavar="/NAME",
        help="of several robots, the one whose topics begin so",
    )
    ros.add_argument(
        "-o", "--output", type=Path, metavar="FILE.toml", help="new file; without: print it"
    )
    ros.add_argument(
        "--name", type=reader(plain_name(32)), help="the robot's name; without: its own"
    )
    ros.add_argument("--force", action="store_true", help="replace a file of this name")
    ros.add_argument("--json", action="store_true", help="what was found, as JSON on one line")
