"""`rune drive`: finds a robot, starts its hub, and opens the console on it.

| event | next |
| --- | --- |
| a vehicle or robot is found | its robot file is written, and what was found is said |
| there is none, or its address is none | the end, with the reason |
| all of it is safe, or `--yes` | its hub starts, then the console |
| something is unsafe, or it is armed | the same after Enter |
| standard input ends in place of Enter | the end, with the reason |
| the console ends | its hub ends |

With `--ssh` the hub runs on the robot, where Rune is installed there; otherwise it runs here, and
the port of the robot's bridge comes through ssh.
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any, Final, TypeVar
from urllib.parse import urlsplit

from hub import files
from hub.command_line import ExitCode
from hub.errors import RobotFileError
from hub.plain_text import plain
from rune_tui.commands.auto import with_file
from rune_tui.commands.demo import AUTO
from rune_tui.commands.own_hub import OwnHub
from rune_tui.commands.robots_hub import NOT_INSTALLED, RobotsHub
from rune_tui.errors import DriveAddressError
from rune_tui.link.hub_tunnel import tunnel_to
from rune_tui.link.tunnel import PortTunnel, SshTunnel

MAVLINK, ROS = "mavlink", "ros"
"""The kinds of links to robots without a hub, as `rune-hub adopt` names them."""
_ROS_PORTS: Final = {"ws": 8765, "wss": 8765, "zenoh+tcp": 7447, "zenoh+tls": 7447}
"""The schemes of addresses of robots with ROS, and their usual ports."""
_PLAIN_PLACE: Final = re.compile(r"[^/\\]+:[0-9]+")
"""A host with a port, without a kind of network."""

Found = dict[str, Any]
T = TypeVar("T", bound=SshTunnel)


def run(options: argparse.Namespace, log: Path, show: Callable[[str, str], int]) -> int:
    """Drive what is at an address; returns the exit code.

    Args:
        options: Those of the command.
        log: File for the hub's log.
        show: Shows the console with the layout of a path, for the hub at an endpoint.

    Raises:
        DriveAddressError: The address has no kind of link, or the robot file is there already.
        OwnHubError: The robot's hub did not start.
        TunnelError: Ssh failed.
    """
    kind, address = kind_and_address(options.address)
    if options.ssh and kind != ROS:
        text = f"--ssh is for robots with ROS, such as ws://127.0.0.1:8765, not {options.address!r}"
        raise DriveAddressError(text)
    if options.output is not None and options.output.exists():
        text = f"{options.output} is there: give -o another name, or `rune-hub run` that file"
        raise DriveAddressError(text)
    with ExitStack() as stack:
        if options.ssh:
            code, found, endpoint = _through_ssh(stack, address, options, log)
        else:
            code, found, endpoint = _from_here(stack, kind, address, options, log)
        if found is None:
            return code
        hub = endpoint()
        asks = (found["unsafe"] or found["armed"]) and not options.yes
        if asks and not _operator_agrees():
            _say("nobody answered; --yes opens the console all the same")
            return ExitCode.FAULT
        with with_file([AUTO], hub) as (layout,):
            return show(layout, hub)


def kind_and_address(text: str) -> tuple[str, str]:
    """The kind of link of an address, and the address as `rune-hub adopt` takes it.

    Raises:
        DriveAddressError: It has no kind of link.
    """
    scheme, is_url, _ = text.partition("://")
    if is_url and scheme in _ROS_PORTS:
        return ROS, text
    if text.endswith(".toml"):
        refusal = (
            f"{text!r} is a robot file, and `rune drive` takes an address: `rune-hub run "
            f"{shlex.quote(text)}` starts its hub, `rune run auto --hub 127.0.0.1` drives it"
        )
        raise DriveAddressError(refusal)
    kind, _, address = text.partition(":")
    if kind != MAVLINK or not address:
        ros, forms = "ws://HOST:8765", "mavlink:udp://:14550"
        if _PLAIN_PLACE.fullmatch(text):
            ros, forms = f"ws://{text}", f"mavlink:tcp://{text}"
        elif is_url and scheme in _VEHICLE_SCHEMES:
            forms = f"mavlink:{text}"
        refusal = f"{text!r} has no kind of link: write {forms} for an autopilot, {ros} for ROS"
        raise DriveAddressError(refusal)
    if _PLAIN_PLACE.fullmatch(address):
        forms = f"mavlink:tcp://{address} or mavlink:udp://{address}"
        refusal = f"{text!r} has no kind of network: write {forms}"
        raise DriveAddressError(refusal)
    return kind, address


_VEHICLE_SCHEMES = frozenset({"tcp", "udp", "serial"})
"""Schemes of addresses of autopilots, which have the kind of link before them."""

Started = tuple[int, Found | None, Callable[[], str]]
"""Exit code of adopting; what was found, None: nothing; the hub's endpoint, which may wait."""


def _from_here(
    stack: ExitStack,
    kind: str,
    address: str,
    options: argparse.Namespace,
    log: Path,
    tunnel: str = "",
) -> Started:
    """Adopt the robot, and start its hub on this machine.

    Args:
        stack: Ends what is started.
        kind: Kind of its link.
        address: The robot's own address.
        options: Those of the command.
        log: File for the hub's log.
        tunnel: Address of this machine that leads there by ssh; empty: no tunnel.
    """
    folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="rune-drive-"))
    path = options.output or Path(folder) / "robot.toml"
    words = [kind, address, "-o", str(path), *_words(kind, options)]
    settings: list[str] = []
    if tunnel:  # its port is another one each time
        words += ["--through", tunnel]
        known_as = f"ssh {options.ssh} {address}"
        settings = [f"ros.address={tunnel}", f"ros.known_as={known_as}"]
    code, found = _adopted(words)
    if found is None:
        return code, None, str
    _say_found(address, found)
    if options.output is not None:
        _say(f"written: {path}")
    hub = stack.enter_context(closing(OwnHub(str(path), log, settings, keeps=True)))
    return code, found, hub.endpoint


def _write(path: Path, text: str) -> None:
    """Write a robot file.

    Raises:
        RobotFileError: It cannot be written.
    """
    try:
        files.write_output(path, text.encode())
    except OSError as error:
        raise RobotFileError(str(path), [f"cannot be written: {error.strerror}"]) from error
    _say(f"written: {path}")


def _through_ssh(stack: ExitStack, address: str, options: argparse.Namespace, log: Path) -> Started:
    """Start the hub on the robot; where Rune is not installed there, on this machine."""
    robot = options.ssh
    _say(f"going to {robot} by ssh, and looking at {address} from there")
    words = [ROS, address, *_words(ROS, options)]
    there = stack.enter_context(closing(RobotsHub(robot, words, log)))
    found = there.adopted()
    if found is None and there.code_of_adopting != NOT_INSTALLED:
        _say(there.reason or f"`rune-hub adopt` failed on {robot}")
        return there.code_of_adopting, None, str
    if found is None:
        far = urlsplit(address)
        port = far.port or _ROS_PORTS[far.scheme]
        near = stack.enter_context(_open(PortTunnel(robot, far.hostname or "127.0.0.1", port)))
        query = f"?{far.query}" if far.query else ""
        here = f"{far.scheme}://127.0.0.1:{near.port}{query}"
        started = _from_here(stack, ROS, address, options, log, here)
        if started[1] is not None:
            _say(
                f"Rune is not installed on {robot}: the hub runs here, and the bridge comes "
                f"through ssh. When ssh ends, {_left_alone(started[1])}"
            )
        return started
    _say_found(address, found)
    if options.output is not None:
        _write(options.output, found["text"])
    _say(
        f"the hub runs on {robot}. When ssh ends, it stops the robot within 0.3 s; when that "
        f"computer ends, {_left_alone(found)}"
    )

    def endpoint() -> str:
        hub = str(there.listening()["hub"])
        return stack.enter_context(_open(tunnel_to(robot, hub))).endpoint

    return 0, found, endpoint


@contextmanager
def _open(tunnel: T) -> Iterator[T]:
    """A tunnel that is open."""
    with closing(tunnel):
        tunnel.open()
        yield tunnel


def _left_alone(found: Found) -> str:
    """What stops a robot without commands, in words."""
    after = found["stops_after_s"]
    if after is None:
        return "nothing that Rune knows of stops the robot"
    return f"the robot stops by itself after {after:g} s"


def _words(kind: str, options: argparse.Namespace) -> list[str]:
    """The options of `rune-hub adopt`."""
    if kind == ROS:
        given = {"--namespace": options.namespace, "--tls": options.tls}
        return [word for pair in given.items() if pair[1] for word in pair]
    words = ["--system", str(options.system)]
    return [*words, "--key", str(options.key)] if options.key is not None else words


def _adopted(words: list[str]) -> tuple[int, Found | None]:
    """The exit code of `rune-hub adopt`, and what it found; it says itself what is wrong."""
    _say(f"looking for a robot at {words[1]}; this takes some seconds")
    command = [sys.executable, "-m", "hub", "adopt", *words, "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, check=False)
    return done.returncode, json.loads(done.stdout) if done.stdout.strip() else None


def _say_found(address: str, found: Found) -> None:
    _say(f"{address}: a {found['title']}", *found["remarks"])


def _operator_agrees() -> bool:
    """Wait for a line; False: standard input has ended."""
    sys.stderr.write("rune: Enter opens the console all the same, Ctrl-C ends: ")
    sys.stderr.flush()
    answered = bool(sys.stdin.readline())
    if not answered:
        sys.stderr.write("\n")
    return answered


def _say(*lines: str) -> None:
    sys.stderr.writelines(f"rune: {plain(line)}\n" for line in lines)
    sys.stderr.flush()
