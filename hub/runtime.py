"""The life of a module process: connect, announce, run the loop, obey common commands, stop.

| event | action |
| --- | --- |
| SIGTERM, SIGINT, common command STOP | stop, exit code 0 |
| standard input ends, with `--stop-with-stdin` | stop, exit code 0: the daemon is gone |
| common command RESTART | stop, then execute the own command line again |
| common command LOG_LEVEL | set the level of the log |
| another common command but START | announce |
| a fault in a handler | log it, count it, go on |
| an operator disconnects the module | stop, exit code 0 |
| no hub at the start | exit code 3 |
| wrong robot file | exit code 2 |

The daemon holds the other end of standard input. So no module outlives it, however it dies.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import gc
import json
import logging
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from hub.errors import CentralUnreachableError, HubError
from hub.gcm.capability import Abilities
from hub.gcm.common import COMMON_COMMAND, REQUEST_DATA, CommonCommand, RequestData
from hub.gcm.common import CommonCommandKind as Kind
from hub.gcm.supervision import MODULE_INFO, ModuleInfo, announce_every_s
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.endpoints import DEFAULT_ENDPOINT
from hub.ipc.message_info import MessageInfo
from hub.ipc.transport.heap import give_back
from hub.nonblocking_logging import LEVELS, start_logging
from hub.robots.description import RobotDescription, settings
from hub.robots.robot_file import read_description
from hub.values import dataclass

_logger = logging.getLogger(__name__)

_STDIN = 0
_CONNECT_S = 10.0
_LISTEN_S = 0.5


@dataclass(slots=True)
class _Health:
    """State of the loop, for the announcement."""

    errors: int = 0
    stopping: bool = False
    again: bool = False


def run_module(
    name: str,
    purpose: str,
    abilities: Callable[[RobotDescription], Abilities],
    build: Callable[[Client, RobotDescription], Callable[[], None]],
    arguments: Sequence[str] | None = None,
) -> int:
    """Run a module process from start to end.

    Args:
        name: Name at central.
        purpose: One sentence for --help.
        abilities: The capabilities that the module provides on a robot, and those that it needs.
        build: Subscribes and defines, given the client and the robot. Returns a function
            that is called at the end, before the connection closes.
        arguments: Command line; default: that of the process.

    Returns:
        The exit code: 0 stopped, 2 a wrong robot file, 3 no hub.
    """
    options = _parser(name, purpose).parse_args(arguments)
    start_logging(name, logging.INFO)
    gc.freeze()  # loaded code stays: the garbage collector skips it, also at the exit
    health = _Health()
    try:
        robot, _ = read_description(options.robot, options.set)
        can = abilities(robot)
        if options.describe:
            sys.stdout.write(json.dumps(dataclasses.asdict(can)) + "\n")
            return 0
        with _connected(name, options.hub) as client:
            file = _STDIN if options.stop_with_stdin else None
            _serve(client, can, health, file, lambda: build(client, robot))
    except CentralUnreachableError as error:
        _logger.error("%s", error)
        return 3
    except HubError as error:
        _logger.error("%s", error)
        return 2
    if health.again:
        os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])
    return 0


def publish_on_request(
    client: Client, definition: MessageDefinition[Any], publish: Callable[[], None]
) -> None:
    """Call `publish` at each request to publish this message now."""

    def requested(request: RequestData, _reception: MessageInfo) -> None:
        if request.message == definition.name:
            publish()

    client.subscribe(REQUEST_DATA, requested)


def stop_after_sleep(client: Client, stop: Callable[[str], None]) -> None:
    """Call `stop` with the reason after each sleep of this machine, before input is read.

    What was commanded before is older than the sleep, which no monotonic clock shows.
    """
    client.when_slept(lambda time: stop(f"the robot's computer slept for {time:.1f} s"))


def _parser(name: str, purpose: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"python -m hub.modules.{name}",
        description=purpose,
        epilog="Exit codes: 0 stopped, 1 a fault, 2 wrong usage or robot file, 3 no hub.",
    )
    robot_help = "; ".join(filter(None, ("the robot file", settings(name))))
    parser.add_argument("--robot", required=True, type=Path, help=robot_help)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="TABLE.KEY=VALUE",
        help="use this value instead of the file's",
    )
    parser.add_argument("--hub", default=DEFAULT_ENDPOINT, help="endpoint of central (%(default)s)")
    parser.add_argument(
        "--describe",
        action="store_true",
        help="print its capabilities on that robot as JSON, and end",
    )
    parser.add_argument(
        "--stop-with-stdin", action="store_true", help="stop when standard input ends"
    )
    return parser


@contextlib.contextmanager
def _connected(name: str, endpoint: str) -> Iterator[Client]:
    client = Client(name, endpoint)
    try:
        yield client
    finally:
        client.close()


def _serve(
    client: Client,
    can: Abilities,
    health: _Health,
    daemon_pipe: int | None,
    build: Callable[[], Callable[[], None]],
) -> None:
    _stop_on_signals(client, health)
    if daemon_pipe is not None:
        _stop_with_daemon(client, health, daemon_pipe)
    finish = build()
    give_back()  # unused parts of the heap after the start

    def announce() -> None:
        info = ModuleInfo(
            name=client.name,
            pid=os.getpid(),
            state="stopping" if health.stopping else "running",
            capabilities=" ".join(can.provides),
            needs=" ".join(can.needs),
            errors=health.errors,
        )
        client.publish(MODULE_INFO, info)

    publish_on_request(client, MODULE_INFO, announce)
    client.subscribe(COMMON_COMMAND, lambda command, _: _obey(client, health, announce, command))
    client.wait_connected(_CONNECT_S, give_up=lambda: health.stopping)
    client.wait_defined(_CONNECT_S, give_up=lambda: health.stopping)
    client.every(announce_every_s(can.provides), announce)
    if not health.stopping:
        announce()
        _logger.info("ready")
    while not health.stopping and not client.closed_by:
        try:
            client.listen(_LISTEN_S)
        except Exception:  # a fault in one handler must not end the module
            health.errors += 1
            _logger.exception("the loop goes on after a fault")
    finish()
    announce()
    _logger.info("restarts" if health.again else "stopped")


def _obey(
    client: Client, health: _Health, announce: Callable[[], None], command: CommonCommand
) -> None:
    """Carry out a common command that addresses this module or all modules."""
    if command.module not in ("", client.name):
        return
    if command.command in (Kind.STOP, Kind.RESTART):
        health.again = command.command is Kind.RESTART
        health.stopping = True
    elif command.command is Kind.LOG_LEVEL:
        if command.argument not in LEVELS:
            _logger.warning("there is no log level %.20r", command.argument)
            return
        logging.getLogger().setLevel(command.argument.upper())
    elif command.command is not Kind.START:
        announce()


def _stop_on_signals(client: Client, health: _Health) -> None:
    def stop(_number: int, _frame: object) -> None:
        health.stopping = True
        client.post(lambda: None)

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)


def _stop_with_daemon(client: Client, health: _Health, file: int) -> None:
    """Stop when the pipe from the daemon ends."""

    def read() -> None:
        if not os.read(file, 4096):
            client.loop.unwatch(file)
            _logger.warning("the daemon is gone; stopping")
            health.stopping = True

    client.loop.watch(file, read)
