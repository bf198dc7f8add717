"""`rune-hub sim-ros`: a simulated robot with ROS, to try Rune without a real one."""

from __future__ import annotations

import argparse
import contextlib
import signal
from pathlib import Path

from hub.command_line import CommandParser, Commands, ExitCode, number_type
from hub.errors import EndpointError

_LARGEST_PORT = 65_535
_DEFAULT_PORT = 8765
_MOST_SEED = 0xFFFF_FFFF
_FARTHEST_S = 1e6
_seed = number_type(int, 0, _MOST_SEED, f"whole number from 0 to {_MOST_SEED}")
_port = number_type(int, 0, _LARGEST_PORT, f"port from 0 to {_LARGEST_PORT}")
_seconds = number_type(
    float, -_FARTHEST_S, _FARTHEST_S, f"number from {-_FARTHEST_S:.0f} to {_FARTHEST_S:.0f}"
)


def add_sim_ros(commands: Commands) -> None:
    """Add the command."""
    command: CommandParser = commands.add_parser(
        "sim-ros",
        help="a simulated robot with ROS 2 or ROS 1 behind a bridge for Foxglove",
        description="A simulated robot on two wheels, with a laser scanner and a camera, behind a "
        "bridge for Foxglove as ROS robots have it: topics, parameters, the service /e_stop, the "
        "graph of nodes. It takes geometry_msgs/TwistStamped at /cmd_vel and stops 0.5 s after the "
        "last one, as diff_drive_controller does. It has navigation of its own: Nav2's action "
        "/navigate_to_pose, or with --ros1 /move_base. It prints its address, "
        "ws://127.0.0.1:8765. It needs the extra tools: pip install 'robot-user-nexus[tools]'.",
        epilog="Example: rune-hub sim-ros --twist --arena orange",
    )
    command.add_argument(
        "--port",
        type=_port,
        default=_DEFAULT_PORT,
        help="TCP port of loopback (%(default)s); 0: a free one",
    )
    command.add_argument(
        "--ros1", action="store_true", help="ROS 1: its encoding and types, and Twist"
    )
    command.add_argument(
        "--twist", action="store_true", help="take geometry_msgs/Twist, which has no header"
    )
    command.add_argument(
        "--no-timeout",
        action="store_true",
        help="the last velocity holds for ever, as with firmware that has no watchdog",
    )
    command.add_argument(
        "--clock",
        type=_seconds,
        default=0.0,
        metavar="SECONDS",
        help="the robot's clock is so far ahead of this machine's",
    )
    command.add_argument(
        "--other-publisher",
        action="append",
        default=[],
        metavar="NODE",
        help="a node that publishes /cmd_vel too, such as /teleop_joy",
    )
    command.add_argument(
        "--no-navigation",
        action="store_true",
        help="no navigation of its own, as behind a bridge without include_hidden",
    )
    command.add_argument("--arena", default="", metavar="ARENA", help="where it is (yellow)")
    command.add_argument("--seed", type=_seed, default=1, help="of its noise (%(default)s)")
    command.add_argument(
        "--trace",
        type=Path,
        metavar="FILE",
        help="add each command and motion to this file, a line of JSON each",
    )
    command.add_argument("--json", action="store_true", help="print the address as JSON")
    command.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")


def run_sim_ros(options: argparse.Namespace) -> int:
    """Serve until it is ended; returns the exit code.

    Raises:
        EndpointError: foxglove-sdk is missing, the port is not free, or a file cannot be written.
        ArenaError: There is no such arena.
    """
    from hub.command_output import put, put_json, stdin_ended

    try:
        from hub.robots.simulated_ros.bridge import BridgeSettings, SimulatedBridge
    except ImportError as error:
        text = "foxglove-sdk is missing; install it with pip install 'robot-user-nexus[tools]'"
        raise EndpointError(text) from error
    from hub.robots.simulated_ros.controller import TIMEOUT
    from hub.robots.simulated_ros.flavour import ROS_1, ROS_2
    from hub.robots.simulated_ros.motion_trace import MotionTrace
    from hub.robots.simulated_ros.robot import SimulatedRosRobot

    timeout = 0.0 if options.no_timeout else TIMEOUT
    robot = SimulatedRosRobot(options.arena, options.seed, timeout=timeout)
    settings = BridgeSettings(
        flavour=ROS_1 if options.ros1 else ROS_2,
        stamped=not (options.twist or options.ros1),
        clock_ahead=options.clock,
        other_publishers=tuple(options.other_publisher),
        navigates=not options.no_navigation,
    )
    try:
        trace = MotionTrace(options.trace) if options.trace is not None else None
    except OSError as error:
        text = f"{options.trace} cannot be written: {error.strerror}"
        raise EndpointError(text) from error
    with contextlib.closing(SimulatedBridge(robot, settings, options.port, trace)) as bridge:
        address = f"ws://127.0.0.1:{bridge.port}"
        if options.json:
            put_json({"event": "listening", "address": address})
        else:
            put(address)
            put(f"Drive it from another terminal: rune drive {address}")
            put("Ctrl-C ends it.")
        ended: list[int] = []
        signal.signal(signal.SIGTERM, lambda number, _: ended.append(number))
        while not ended and not (options.stop_with_stdin and stdin_ended()):
            bridge.serve_once()
    return ExitCode.OK
