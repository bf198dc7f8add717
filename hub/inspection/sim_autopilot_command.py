"""`rune-hub sim-autopilot`: a simulated vehicle with MAVLink, to try Rune without a real one."""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import time
from typing import TYPE_CHECKING

from hub.command_line import CommandParser, Commands, ExitCode, number_type

if TYPE_CHECKING:
    from hub.robots.simulated_autopilot.motion import VehicleMotion

_KINDS = ("rover", "sub", "blimp")
_LARGEST_PORT = 65_535
_DEFAULT_PORT = 5760
_MOST_SEED = 0xFFFF_FFFF
_BODIES = {"rover": "magellan", "sub": "rov", "blimp": "blimp"}
"""The shipped robot that moves as each of them, in an arena."""
_seed = number_type(int, 0, _MOST_SEED, f"whole number from 0 to {_MOST_SEED}")
_port = number_type(int, 0, _LARGEST_PORT, f"port from 0 to {_LARGEST_PORT}")


def add_sim_autopilot(commands: Commands) -> None:
    """Add the command."""
    command: CommandParser = commands.add_parser(
        "sim-autopilot",
        help="a simulated rover, Sub or blimp with an autopilot that speaks MAVLink",
        description="A simulated vehicle that speaks MAVLink as ArduPilot 4.7 does: modes, arming, "
        "failsafes, streams. It prints its addresses, such as tcp://127.0.0.1:5760, for the robot "
        "file's key mavlink.address. Without --tcp, --udp and --pty it listens at TCP port 5760. "
        "It takes 43 s to know its place, as a real one does; --fast-boot takes one.",
        epilog="Example: rune-hub sim-autopilot rover --fast-boot --parameters FS_TIMEOUT=0.1",
    )
    command.add_argument("vehicle", choices=_KINDS, help="what it is")
    command.add_argument(
        "--tcp",
        type=_port,
        action="append",
        default=[],
        metavar="PORT",
        help="listen at this TCP port of loopback, for any number of stations; 0: a free one",
    )
    command.add_argument(
        "--udp",
        type=_station,
        action="append",
        default=[],
        metavar="HOST:PORT",
        help="send datagrams to a station there",
    )
    command.add_argument(
        "--pty", action="store_true", help="open a pseudo terminal, as serial port"
    )
    command.add_argument(
        "--parameters",
        type=_setting,
        nargs="+",
        default=[],
        metavar="NAME=VALUE",
        help="values of parameters; SIM_RC_FAIL=1: it has no radio receiver",
    )
    command.add_argument(
        "--arena",
        default="",
        metavar="ARENA",
        help="move as a simulated robot in this arena; without: on a free plane, as recorded ones",
    )
    command.add_argument(
        "--seed", type=_seed, default=1, help="of the noise in an arena (%(default)s)"
    )
    command.add_argument("--fast-boot", action="store_true", help="know the place after a second")
    command.add_argument("--json", action="store_true", help="print the addresses as JSON")
    command.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")


def run_sim_autopilot(options: argparse.Namespace) -> int:
    """Serve until it is ended; returns the exit code.

    Raises:
        AutopilotSettingError: A port is not free, or there is no such parameter.
        ArenaError: There is no such arena, or the vehicle cannot be in it.
    """
    from hub.command_output import put, put_json, stdin_ended
    from hub.robots.simulated_autopilot.autopilot import SimulatedAutopilot
    from hub.robots.simulated_autopilot.kinds import AUTOPILOT_KINDS, robot_file
    from hub.robots.simulated_autopilot.motion import FittedMotion
    from hub.robots.simulated_autopilot.parameters import ParameterStore
    from hub.robots.simulated_autopilot.server import AutopilotServer

    name = options.vehicle
    autopilot = SimulatedAutopilot(
        AUTOPILOT_KINDS[name],
        _arena_motion(options) if options.arena else FittedMotion(name),
        ParameterStore(name, dict(options.parameters)),
        time.monotonic(),
        fast_start=options.fast_boot,
    )
    with contextlib.closing(AutopilotServer(autopilot)) as server:
        ports = options.tcp or ([] if options.udp or options.pty else [_DEFAULT_PORT])
        for port in ports:
            server.listen(port)
        for host, port in options.udp:
            server.send_to(host, port)
        if options.pty:
            server.open_terminal()
        if options.json:
            said = {"vehicle": name, "addresses": server.addresses, "robot": str(robot_file(name))}
            put_json({"event": "listening", **said})
        else:
            for address in server.addresses:
                put(address)
            put(f"Drive it from another terminal: rune drive mavlink:{server.addresses[0]}")
            put("Ctrl-C ends it.")
        ended: list[int] = []
        signal.signal(signal.SIGTERM, lambda number, _: ended.append(number))
        while not ended and not (options.stop_with_stdin and stdin_ended()):
            server.serve_once()
    return ExitCode.OK


def _arena_motion(options: argparse.Namespace) -> VehicleMotion:
    """The motion of a simulated robot in an arena.

    Raises:
        ArenaError: There is no such arena, or the vehicle cannot be in it.
    """
    from hub.robots.registry import kind_of
    from hub.robots.robot_file import find_robot_file, read_description
    from hub.robots.simulated_autopilot.arena_motion import ArenaMotion
    from hub.sim.arena import load_arena

    settings = [f"simulation.arena={options.arena}", f"simulation.seed={options.seed}"]
    robot, _ = read_description(find_robot_file(_BODIES[options.vehicle]), settings)
    water = load_arena(robot.arena).water
    surface = water.surface if water is not None and options.vehicle == "sub" else 0.0
    return ArenaMotion(kind_of(robot).open_body(robot), surface)


def _station(text: str) -> tuple[str, int]:
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isdecimal() or not 0 < int(port[:6]) <= _LARGEST_PORT:
        message = f"{text!r} is no HOST:PORT of a station, such as 127.0.0.1:14550"
        raise argparse.ArgumentTypeError(message)
    return host.strip("[]"), int(port)


def _setting(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    with contextlib.suppress(ValueError):
        if name and math.isfinite(number := float(value)):
            return name.upper(), number
    message = f"{text!r} is no NAME=VALUE of a parameter, such as FS_TIMEOUT=0.1"
    raise argparse.ArgumentTypeError(message)
