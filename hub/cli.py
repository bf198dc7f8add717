"""`rune-hub`: arguments, errors in one sentence, exit codes."""

from __future__ import annotations

import argparse
import errno
import functools
import gc
import io
import logging
import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from hub import hub_sockets
from hub.command_line import (
    CommandParser,
    Commands,
    ExitCode,
    ShowVersion,
    add_completion,
    leave,
    number_type,
    write_completion,
)
from hub.command_output import print_error
from hub.doors.fleet.options import add_fleet, run_fleet
from hub.doors.options import add_serve, run_serve
from hub.errors import (
    CentralUnreachableError,
    HubError,
    QueryError,
    RosSilentError,
    RouterUnreachableError,
    VehicleSilentError,
)
from hub.inspection import shape_command
from hub.inspection.adopt_options import add_adopt, run_adopt, with_kind
from hub.inspection.log_options import add_log, run_log
from hub.inspection.mission_options import add_missions, order_mission, run_mission
from hub.inspection.record_options import add_record, recording_settings, run_record
from hub.inspection.run_options import add_run
from hub.inspection.sim_autopilot_command import add_sim_autopilot, run_sim_autopilot
from hub.inspection.sim_ros_command import add_sim_ros, run_sim_ros
from hub.inspection.vehicle.options import add_vehicle, run_vehicle
from hub.ipc.endpoints import DEFAULT_ENDPOINT, endpoint_of
from hub.ipc.roles import Role
from hub.nonblocking_logging import LEVELS, start_logging
from hub.plain_text import plain
from hub.values import Making

if TYPE_CHECKING:
    from hub.ipc.client import Client


_NOT_THERE = (
    CentralUnreachableError,
    QueryError,
    RosSilentError,
    RouterUnreachableError,
    VehicleSilentError,
)
_OF_MODULES = ("modules", "capabilities", "start", "stop", "restart", "want", "logs")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `rune-hub`; returns the exit code."""
    # NumPy's own threads, for products of large matrices, cost each process time at its start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # messages hold any text
    words = with_kind(sys.argv[1:] if arguments is None else arguments)
    options = command_parser().parse_args(words)
    if options.command != "run":  # the daemon forks before it has a thread
        start_logging("hub", logging.WARNING)
    try:
        return run_command(options)
    except KeyboardInterrupt:
        _end_interrupted(options.command)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of the output has ended
        return ExitCode.OK
    except HubError as error:
        sys.stderr.write(f"rune-hub: {plain(str(error), lines=True)}\n")
        if isinstance(error, _NOT_THERE):
            return ExitCode.NO_HUB
        return ExitCode.USAGE
    except Exception as error:
        why = f"the output cannot be written: {getattr(error, 'strerror', '')}"
        if getattr(error, "errno", 0) in (errno.EMFILE, errno.ENFILE):  # ZeroMQ's have it too
            why = "the system lets this program open no more files; `ulimit -n 1024` allows more"
        elif not isinstance(error, OSError):
            raise
        sys.stderr.write(f"rune-hub: {why}\n")
        return ExitCode.FAULT


def _end_interrupted(command: str) -> NoReturn:
    """End after Ctrl-C; a stop of the robot has failed then."""
    if command != "halt":
        leave(ExitCode.OK)
    print_error("interrupted: the robot may still move; use its emergency stop")
    leave(ExitCode.FAULT)


def run_command(options: argparse.Namespace) -> int:
    """Do what the options of the command line say; returns the exit code."""
    if options.command == "completion":
        return write_completion(command_parser, options.shell)
    if options.command == "log":
        return run_log(options)
    if options.command == "mission" and options.task in ("list", "show", "export", "score"):
        return run_mission(options)
    if options.command in _WITHOUT_CLIENT:
        return _WITHOUT_CLIENT[options.command](options)
    if options.command == "halt" and options.hub == DEFAULT_ENDPOINT:
        from hub.inspection.halt_command import halt_each

        hubs = hub_sockets.running()
        if len(hubs) > 1:  # no time to choose: all of them stop
            return halt_each(hubs, lambda hub: _inspect(options, hub))
    return _inspect(options)


def _inspect(options: argparse.Namespace, hub: hub_sockets.RunningHub | None = None) -> int:
    """Carry out a command that inspects a hub; None: that of the options."""
    from hub.inspection import message_commands

    endpoint = options.hub if hub is None else hub.endpoint
    name = "" if hub is None else hub.name
    as_json = getattr(options, "json", False)
    with message_commands.failures_explained(options.command, as_json=as_json, hub=name):
        client = message_commands.connect(endpoint, options.command, options.keys)
        try:
            return _run_inspection(client, options, hub=name)
        except KeyboardInterrupt:
            _end_interrupted(options.command)
        finally:
            client.close()


def _run_inspection(client: Client, options: argparse.Namespace, *, hub: str) -> int:
    """Carry out a command that inspects a running hub; `hub` names it if there are several."""
    from hub.inspection import message_commands

    if options.command in ("status", "trace", "close", "log-level"):
        return _run_central_command(client, options)
    if options.command == "control":
        return _run_control_command(client, options)
    if options.command == "halt":
        from hub.inspection import halt_command

        return halt_command.halt(client, as_json=options.json, hub=hub)
    if options.command == "mission":
        return order_mission(client, options)
    if options.command in _OF_MODULES:
        return _run_module_command(client, options)
    if options.command == "list":
        return message_commands.list_all(client, as_json=options.json)
    if options.command == "echo":
        return message_commands.echo(
            client, options.name, count=options.count, as_json=options.json
        )
    if options.command == "rate":
        return message_commands.rate(
            client, options.name, seconds=options.seconds, as_json=options.json
        )
    if options.command == "send":
        return message_commands.send(
            client,
            options.name,
            options.fields,
            rate_hz=options.rate,
            zero_first=options.zero_first,
        )
    return message_commands.query(
        client, options.name, options.fields, timeout=options.timeout, as_json=options.json
    )


def _run_central_command(client: Client, options: argparse.Namespace) -> int:
    """Carry out a command about central itself."""
    from hub.inspection import central_commands

    if options.command == "status":
        return central_commands.status(client, as_json=options.json)
    if options.command == "trace":
        return central_commands.trace(
            client, options.names, with_data=options.data, count=options.count
        )
    if options.command == "close":
        return central_commands.close(client, options.module)
    return central_commands.log_level(client, options.level)


def _run_control_command(client: Client, options: argparse.Namespace) -> int:
    """Carry out a command about the control of the robot."""
    from hub.inspection import control_commands

    if options.task == "release":
        return control_commands.release(client, force=options.force)
    return control_commands.show(client, as_json=options.json)


def _run_module_command(client: Client, options: argparse.Namespace) -> int:
    """Carry out a command for the daemon that runs the modules."""
    from hub.inspection import module_commands

    if options.command == "modules":
        return module_commands.modules(client, as_json=options.json)
    if options.command == "capabilities":
        return module_commands.capabilities(client, as_json=options.json)
    if options.command == "want":
        return module_commands.want(client, options.capabilities, seconds=options.seconds)
    if options.command == "logs":
        return module_commands.logs(
            client, options.module, lines=options.lines, follow=options.follow
        )
    return module_commands.order(client, options.module, options.command)


def _run_machine_command(options: argparse.Namespace) -> int:
    """Carry out a command about this machine; no hub needs to run."""
    from hub.robomon.module_table import load_robot_table

    if options.command == "doctor":
        from hub.inspection.doctor import doctor
        from hub.robots.robot_file import DEFAULT_ROBOT

        robot = options.robot or DEFAULT_ROBOT
        return doctor.examine(robot, load_robot_table, as_json=options.json)
    if options.command == "check":
        from hub.inspection import check_command

        return check_command.check(load_robot_table(options.robot).robot, as_json=options.json)
    from hub.robomon import systemd_unit

    return systemd_unit.write_unit(load_robot_table(options.robot), options.robot, options.user)


def _show_arena(options: argparse.Namespace) -> int:
    from hub.inspection import arena_command

    name, as_json = options.arena, options.json
    if name is None:
        return arena_command.list_all(as_json=as_json)
    return arena_command.show(name, options.output, size=options.size, as_json=as_json)


def _serve(options: argparse.Namespace) -> int:
    from hub.inspection.message_commands import connect

    return run_serve(options, functools.partial(connect, options.hub, "serve", options.keys))


def _run_key_command(options: argparse.Namespace) -> int:
    from hub.inspection import key_commands

    keyring = key_commands.keyring(options.folder)
    if options.task == "make":
        return key_commands.make(keyring, options.name, Role(options.role))
    if options.task == "remove":
        return key_commands.remove(keyring, options.name)
    return key_commands.list_all(keyring, as_json=options.json)


def _run_daemon(options: argparse.Namespace) -> int:
    import dataclasses

    Making.at_once = True  # modules are forked from this process
    gc.disable()  # imported objects never become garbage
    try:
        from hub.robomon import daemon
        from hub.robomon.module_table import load_robot_table

        table = load_robot_table(options.robot, [*options.set, *recording_settings(options.record)])
    finally:
        gc.enable()
    if options.listen:
        table = dataclasses.replace(
            table, robot=dataclasses.replace(table.robot, listen=options.listen)
        )
    return daemon.run(
        table,
        name=options.name,
        spawn=options.spawn,
        as_json=options.json,
        stop_with_stdin=options.stop_with_stdin,
    )


_WITHOUT_CLIENT: Mapping[str, Callable[[argparse.Namespace], int]] = {
    "run": _run_daemon,
    "keys": _run_key_command,
    "arena": _show_arena,
    **dict.fromkeys(("record", "play"), run_record),
    "shape": shape_command.run,
    "serve": _serve,
    "adopt": run_adopt,
    "fleet": run_fleet,
    "sim-autopilot": run_sim_autopilot,
    "sim-ros": run_sim_ros,
    "vehicle": run_vehicle,
    **dict.fromkeys(("check", "doctor", "service"), _run_machine_command),
}
_positive = number_type(float, sys.float_info.min, 1e6, "number above 0")
_whole = number_type(int, 1, math.inf, "whole number above 0")


def command_parser() -> CommandParser:
    """The parser of the whole command line."""
    parser = CommandParser(
        prog="rune-hub",
        description="The hub on a robot: carries messages between modules and keeps them alive.",
        epilog="Exit codes: 0 ok, 1 a fault or what was asked for cannot be done, 2 wrong usage or "
        "robot file, 3 no hub or no answer.",
    )
    parser.add_argument("--version", action=ShowVersion)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    _add_machine_commands(commands)

    look = CommandParser(add_help=False)
    look.add_argument(
        "--hub",
        type=endpoint_of,
        default=DEFAULT_ENDPOINT,
        help="name of a hub of this machine, HOST:PORT or an endpoint; without: the only hub here",
    )
    look.add_argument("--keys", type=Path, help="file of your key or token, for a hub at TCP")
    name = CommandParser(add_help=False, parents=[look])
    name.add_argument("name", help="message name; `rune-hub list` shows all")
    fields = CommandParser(add_help=False, parents=[name])
    fields.add_argument(
        "fields",
        nargs="*",
        metavar="FIELD=VALUE",
        help="twist.linear.x=0.5; fields left out are zero",
    )

    halt = commands.add_parser(
        "halt",
        parents=[look],
        help="stop the robot, and wait until it stands",
        description="Stop the robot, whoever has control. It drives again only after a neutral "
        "command. Exit codes: 0 it stands, 1 it does not report that in time, 3 no hub.",
    )
    listing = commands.add_parser("list", parents=[look], help="modules and messages of a hub")
    echo = commands.add_parser("echo", parents=[name], help="show messages as they come")
    echo.add_argument("-n", "--count", type=_whole, default=0, help="end after so many")
    rate = commands.add_parser("rate", parents=[name], help="show how often a message comes")
    rate.add_argument("--seconds", type=_positive, default=0.0, help="end after so long")
    send = commands.add_parser("send", parents=[fields], help="publish a message")
    send.add_argument("-r", "--rate", type=_positive, default=0.0, help="repeat so often a second")
    send.add_argument(
        "--zero-first", action="store_true", help="send it once with all fields zero before"
    )
    query = commands.add_parser("query", parents=[fields], help="ask, and show the answer")
    query.add_argument("--timeout", type=_positive, default=2.0, help="wait so long [s]")
    state = commands.add_parser(
        "status", parents=[look], help="modules, rates, bytes, what was missed, how old it is"
    )
    trace = commands.add_parser(
        "trace", parents=[look], help="one line for each message, and from whom"
    )
    trace.add_argument("names", nargs="+", metavar="NAME", help="message name")
    trace.add_argument("--data", action="store_true", help="with its fields")
    trace.add_argument("-n", "--count", type=_whole, default=0, help="end after so many")
    close = commands.add_parser(
        "close", parents=[look], help="disconnect a module; under the daemon it is started again"
    )
    close.add_argument("module", help="its name; `rune-hub list` shows all")
    level = commands.add_parser("log-level", parents=[look], help="how much central logs")
    level.add_argument("level", choices=LEVELS)
    tables = _add_supervision(commands, look)
    for command in (halt, listing, echo, rate, query, state, *tables):
        command.add_argument("--json", action="store_true", help="JSON, one line a message")
    _add_control(commands, look)
    add_missions(commands, look)
    add_record(commands, look)
    add_log(commands)
    add_adopt(commands)
    add_vehicle(commands)
    shape_command.add_parser(commands, look)
    add_serve(commands, look)
    add_sim_autopilot(commands)
    add_fleet(commands)
    add_sim_ros(commands)
    _add_keys(commands.add_parser("keys", help="who may connect from other machines"))
    add_completion(commands)
    return parser


def _add_machine_commands(commands: Commands) -> None:
    """Add the commands that need no running hub."""
    add_run(commands)
    check = commands.add_parser("check", help="show the robot of a file, or all mistakes in it")
    check.add_argument("robot", help="a robot file, or the name of a shipped one")
    check.add_argument("--json", action="store_true", help="the robot as JSON, on one line")
    service = commands.add_parser("service", help="print a systemd unit that runs a robot's hub")
    service.add_argument("robot", help="a robot file, or the name of a shipped one")
    service.add_argument("--user", default="rune", help="as whom it is to run (%(default)s)")
    doctor = commands.add_parser("doctor", help="say what is wrong on this machine, and what to do")
    doctor.add_argument("robot", nargs="?", help="robot file; default: a shipped robot")
    doctor.add_argument("--json", action="store_true", help="JSON, one line a finding")
    arena = commands.add_parser(
        "arena",
        help="what is in an arena of simulated robots, and its picture from above",
        description="Show what is in an arena, and draw it from above, north up. In the picture, a "
        "green disc is the rover's start, blue arrows are the berths of other robots, numbered red "
        "discs are victims, diamonds are landmarks, rings are rings to read. Lines are a metre "
        "apart. Without an arena: list those that come with the hub.",
    )
    arena.add_argument(
        "arena", nargs="?", help="an arena file (TOML), or the name of a shipped one"
    )
    arena.add_argument("-o", "--output", type=_png_file, metavar="FILE.png", help="draw it there")
    arena.add_argument(
        "--size",
        type=number_type(int, 64, 4096, "number of pixels from 64 to 4096"),
        default=720,
        help="longer side of the picture in pixels (%(default)s)",
    )
    arena.add_argument("--json", action="store_true", help="JSON, one line a thing")


def _png_file(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() != ".png":
        message = f"{text!r} does not end in .png"
        raise argparse.ArgumentTypeError(message)
    return path


def _add_supervision(commands: Commands, look: CommandParser) -> list[CommandParser]:
    """Add the commands for the daemon; those that show a table."""
    modules = commands.add_parser(
        "modules", parents=[look], help="the robot's modules, what they do and take, and why"
    )
    capabilities = commands.add_parser(
        "capabilities", parents=[look], help="what the robot can do, and who wants it"
    )
    for order, text in (
        ("start", "start a module, also one that was given up"),
        ("stop", "end a module until it is started again; `halt` stops the robot"),
        ("restart", "end a module and start it again"),
    ):
        command = commands.add_parser(order, parents=[look], help=text)
        command.add_argument("module", help="its name; `rune-hub modules` shows all")
        if order == "stop":
            command.advice = "`rune-hub halt` stops the robot"
    want = commands.add_parser(
        "want", parents=[look], help="have capabilities running as long as this command runs"
    )
    want.add_argument("capabilities", nargs="+", metavar="CAP", help="such as PRO_MAP")
    want.add_argument("--seconds", type=_positive, default=0.0, help="end after so long")
    logs = commands.add_parser("logs", parents=[look], help="what a module has written lately")
    logs.add_argument("module", help="its name; `rune-hub modules` shows all")
    logs.add_argument("-f", "--follow", action="store_true", help="go on as it writes more")
    logs.add_argument("-n", "--lines", type=_whole, default=100, help="how many (%(default)s)")
    return [modules, capabilities]


def _add_control(commands: Commands, look: CommandParser) -> None:
    control = commands.add_parser(
        "control", parents=[look], help="who has control of the robot, and who asks for it"
    )
    control.add_argument("--json", action="store_true", help="JSON, one line")
    control.add_argument(
        "task", nargs="?", choices=("release",), help="with --force: take it from whoever has it"
    )
    control.add_argument("--force", action="store_true", help="release what somebody else has")


def _add_keys(keys: CommandParser) -> None:
    where = CommandParser(add_help=False)
    where.add_argument("--folder", type=Path, help="folder of the keys (~/.config/rune/keys)")
    tasks = keys.add_subparsers(dest="task", required=True, metavar="TASK")

    make = tasks.add_parser("make", parents=[where], help="make a key and say where its file is")
    make.advice = f"--role is one of {', '.join(role.value for role in Role)}"
    make.add_argument("name", help="letters, digits, - and _; the log names the key so")
    make.add_argument(
        "--role",
        choices=[role.value for role in Role],
        required=True,
        metavar="|".join(role.value for role in Role),
        help="observe: see all, and stop the robot; operate: command as well; supervise: also take "
        "control from others, start and stop modules; module: be a part of the robot",
    )
    listing = tasks.add_parser("list", parents=[where], help="show all keys")
    listing.add_argument("--json", action="store_true", help="JSON, one line a key")
    remove = tasks.add_parser("remove", parents=[where], help="refuse a key from now on")
    remove.add_argument("name", help="name of the key")
