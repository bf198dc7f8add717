"""What every module process does: connect, announce itself, keep alive, loop, stop.

A module stops on SIGTERM and SIGINT. Started by a daemon, it also stops when the pipe on its
standard input ends: the daemon holds the other end, so that no module outlives it, however it dies.
"""

from __future__ import annotations

import argparse
import logging
import os
import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from hub.errors import CentralUnreachableError, HubError
from hub.gcm.capability import Capability
from hub.gcm.supervision import MODULE_INFO, ModuleInfo
from hub.ipc.client import Client
from hub.logs import start_logging
from hub.robots.description import RobotDescription, read_description

_logger = logging.getLogger(__name__)

_STDIN = 0
_CONNECT_S = 10.0
_LISTEN_S = 0.5


@dataclass(slots=True)
class _Health:
    """What the announcement says of the loop."""

    errors: int = 0
    stopping: bool = False


def run_module(
    name: str,
    purpose: str,
    capabilities: Sequence[Capability],
    build: Callable[[Client, RobotDescription], Callable[[], None]],
    arguments: Sequence[str] | None = None,
) -> int:
    """Be a module process from start to end.

    Args:
        name: Name at central.
        purpose: One sentence for --help.
        capabilities: What the module can do.
        build: Gets the connected client and the robot, subscribes and so on; returns what to call
            at the end, while the connection still stands.
        arguments: Command line; default the process's own.

    Returns:
        The exit code: 0 stopped, 2 a wrong robot file, 3 no hub.
    """
    parser = argparse.ArgumentParser(prog=f"python -m hub.modules.{name}", description=purpose)
    parser.add_argument("--hub", required=True, help="endpoint of central, tcp:// or ipc://")
    parser.add_argument("--robot", required=True, type=Path, help="the robot file")
    parser.add_argument(
        "--stop-with-stdin", action="store_true", help="stop when standard input ends"
    )
    options = parser.parse_args(arguments)
    start_logging(name, logging.INFO)
    try:
        robot, _ = read_description(options.robot)
        client = Client(name, options.hub)
    except HubError as error:
        _logger.error("%s", error)
        return 2
    try:
        file = _STDIN if options.stop_with_stdin else None
        return _serve(client, capabilities, file, lambda: build(client, robot))
    except CentralUnreachableError as error:
        _logger.error("%s", error)
        return 3
    except HubError as error:
        _logger.error("%s", error)
        return 2
    finally:
        client.close()


def _serve(
    client: Client,
    capabilities: Sequence[Capability],
    daemon_pipe: int | None,
    build: Callable[[], Callable[[], None]],
) -> int:
    health = _Health()
    _stop_on_signals(client, health)
    if daemon_pipe is not None:
        _stop_with_daemon(client, health, daemon_pipe)
    finish = build()
    client.wait_connected(_CONNECT_S, give_up=lambda: health.stopping)
    client.wait_defined(_CONNECT_S, give_up=lambda: health.stopping)

    def announce() -> None:
        info = ModuleInfo(
            name=client.name,
            pid=os.getpid(),
            state="stopping" if health.stopping else "running",
            capabilities=" ".join(capabilities),
            errors=health.errors,
        )
        client.publish(MODULE_INFO, info)

    client.every(1.0 / MODULE_INFO.rate_hz, announce)
    if not health.stopping:
        _logger.info("ready")
    while not health.stopping and not client.closed_by:
        try:
            client.listen(_LISTEN_S)
        except Exception:  # one bad message must not end the module
            health.errors += 1
            _logger.exception("the loop goes on after a fault")
    finish()
    announce()
    _logger.info("stopped")
    return 0


def _stop_on_signals(client: Client, health: _Health) -> None:
    def stop(number: int, frame: object) -> None:
        del number, frame
        health.stopping = True
        client.post(lambda: None)

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)


def _stop_with_daemon(client: Client, health: _Health, file: int) -> None:
    """Stop when the pipe that the daemon holds ends."""

    def read() -> None:
        if not os.read(file, 4096):
            client.loop.unwatch(file)
            _logger.warning("the daemon is gone; stopping")
            health.stopping = True

    client.loop.watch(file, read)
