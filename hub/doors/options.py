"""The options of `rune-hub serve`."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hub.command_line import CommandParser, Commands, number_type
from hub.errors import DoorError
from hub.ipc.endpoints import LARGEST_PORT, TcpEndpoint

if TYPE_CHECKING:
    from hub.ipc.client import Client

_FOXGLOVE_PORT = 8765
"""Port that Foxglove suggests."""
_port = number_type(int, 0, LARGEST_PORT, f"port from 0 to {LARGEST_PORT}")
_side = number_type(int, 16, 8192, "number of pixels from 16 to 8192")
_domain = number_type(int, 0, 232, "domain from 0 to 232")
_HOST_NAME = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9.-]{0,251}[A-Za-z0-9])?", re.ASCII)
_rate = number_type(float, 0.1, 60.0, "rate from 0.1 to 60")


def add_serve(commands: Commands, look: CommandParser) -> None:
    """Add the command."""
    serve = commands.add_parser(
        "serve",
        help="open a hub to other systems: Foxglove, ROS 2",
        description="Join a running hub with another system, until Ctrl-C. Exit codes: 0 ended, 2 "
        "wrong usage or a busy port, 3 no hub.",
    )
    doors = serve.add_subparsers(dest="door", required=True, metavar="SYSTEM")
    _add_foxglove(doors, look)
    _add_ros2(doors, look)


def run_serve(options: argparse.Namespace, connect: Callable[[], Client]) -> int:
    """Carry out the command; returns the exit code.

    Args:
        options: Those of the command line.
        connect: Makes the connection to the hub.

    Raises:
        HubError: It cannot be done.
    """
    if options.door == "ros2":
        from hub.doors.ros2 import door as ros2

        return ros2.run(options, connect)
    from hub.doors.foxglove import door

    _check_host(options)
    return door.run(options, connect)


def _add_foxglove(doors: Commands, look: CommandParser) -> None:
    foxglove = doors.add_parser(
        "foxglove",
        parents=[look],
        help="the hub's messages in Foxglove or Lichtblick, and driving from its panels",
        description="Serve a hub's messages to Foxglove and Lichtblick, which open the printed "
        "address, which has a key. What no panel shows costs the robot nothing. With --drive, the "
        "panel Teleop drives the robot: every program with the address can do that then.",
    )
    foxglove.add_argument("--host", default="127.0.0.1", help="where it listens (%(default)s)")
    foxglove.add_argument(
        "--port", type=_port, default=_FOXGLOVE_PORT, help="TCP port; 0: a free one (%(default)s)"
    )
    foxglove.add_argument(
        "--drive", action="store_true", help="let panels drive the robot by the topic /cmd_vel"
    )
    foxglove.add_argument(
        "--allow", type=_host_name, action="append", default=[], metavar="HOST",
        help="another name of this machine, or of a machine whose pages may connect with the key; "
        "may be repeated",
    )  # fmt: skip
    foxglove.add_argument("--tls-cert", type=Path, metavar="FILE.pem", help="certificate, for wss")
    foxglove.add_argument("--tls-key", type=Path, metavar="FILE.pem", help="its key, as PKCS#8")
    _add_pictures(foxglove)
    foxglove.add_argument(
        "--layout", type=Path, metavar="FILE.json", help="write a layout for this robot, and go on"
    )


def _add_ros2(doors: Commands, look: CommandParser) -> None:
    ros2 = doors.add_parser(
        "ros2",
        parents=[look],
        help="the robot as a node of ROS 2, for nodes with rmw_zenoh",
        description="Be a node of ROS 2 that publishes the robot's standard topics. The other "
        "nodes use rmw_zenoh and the same router. A topic without a subscriber costs the robot "
        "nothing. With --drive, every node of the domain can drive the robot.",
    )
    ros2.add_argument(
        "--connect", default="tcp/127.0.0.1:7447", metavar="ENDPOINT",
        help="the Zenoh router (%(default)s)",
    )  # fmt: skip
    ros2.add_argument(
        "--tls", type=Path, metavar="FOLDER",
        help="folder with certificates, for tls/HOST:PORT: authority.pem, and its own",
    )  # fmt: skip
    ros2.add_argument(
        "--domain", type=_domain, default=0, help="domain of ROS, 0 to 232 (%(default)s)"
    )
    ros2.add_argument(
        "--namespace", default="", help="before the names of all topics, such as /rover"
    )
    ros2.add_argument(
        "--drive", action="store_true", help="let nodes drive the robot by the topic /cmd_vel"
    )
    _add_pictures(ros2)


def _add_pictures(door: CommandParser) -> None:
    """Add the options that all doors have."""
    door.add_argument(
        "--pictures", type=_rate, default=10.0, metavar="RATE",
        help="pictures a second of each camera that is shown (%(default)g)",
    )  # fmt: skip
    door.add_argument(
        "--size", type=_side, nargs=2, default=(640, 480), metavar=("WIDTH", "HEIGHT"),
        help="largest size of pictures (640 480)",
    )  # fmt: skip
    door.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    door.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")


def _host_name(text: str) -> str:
    if _HOST_NAME.fullmatch(text) is None:
        refusal = f"{text!r} is no name of a host; write it without http:// and port"
        raise argparse.ArgumentTypeError(refusal)
    return text


def _check_host(options: argparse.Namespace) -> None:
    """Refuse driving from other machines, with TLS too: a key in an address is no login.

    Raises:
        DoorError: Other machines could drive, or a part of TLS is missing.
    """
    if (options.tls_cert is None) != (options.tls_key is None):
        text = "TLS needs both --tls-cert and --tls-key"
        raise DoorError(text)
    host = "127.0.0.1" if options.host == "localhost" else options.host
    if options.drive and not TcpEndpoint(host, 0).on_loopback:
        port = options.port or _FOXGLOVE_PORT
        text = (
            f"--drive on {options.host} would let everybody who reaches it drive, since it has no "
            f"login; leave out --host, and come by `ssh -L {port}:127.0.0.1:{port} robot`"
        )
        raise DoorError(text)
