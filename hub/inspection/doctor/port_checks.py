"""The doctor on ports: whether central and the gateway can listen at the robot file's ports."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import socket
from contextlib import closing
from pathlib import Path

from hub.errors import HubError
from hub.inspection import message_commands
from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.inspection.doctor.tcp_owners import owner
from hub.inspection.kept import not_kept
from hub.ipc.client import Client
from hub.ipc.definition import Plane
from hub.ipc.endpoints import TcpEndpoint, parse_endpoint
from hub.robots.description import RobotDescription

_PORTS = 1 + 2 * len(Plane)
"""Number of ports: one for control messages, and two for each plane."""
_ANSWER_S = 2.0
_LOCAL = "127.0.0.1"
_CONNECTIONS = Path("/proc/sys/net/ipv4/ip_local_port_range")


def ports(robot: RobotDescription) -> list[Finding]:
    """Whether central's ports are free, or a hub runs there already."""
    if robot.port == 0:
        return [ok("central takes free ports")]
    row = f"ports {robot.port} to {robot.port + _PORTS - 1} of this machine"
    faults = _faults(_LOCAL, robot.port)
    if not faults:
        return [_crossed(robot.port) or ok(f"{row} are free")]
    if robot.port in faults and (modules := modules_of_hub(robot.port)) is not None:
        return [ok(f"a hub runs at {robot.port}{_who(robot.port)}, with {modules}")]
    return [
        _taken(f"port {port}", port, fault, "choose another port in [hub]")
        for port, fault in faults.items()
    ]


def gateway(robot: RobotDescription) -> list[Finding]:
    """Whether the gateway's address is one of this machine, and its ports are free."""
    if not robot.gateway:
        return [ok("none in the robot file: only this machine may connect")]
    try:
        place = parse_endpoint(robot.gateway, beyond_loopback=True)
    except HubError as error:
        return [problem(str(error), "correct [hub], key 'gateway'")]
    if not isinstance(place, TcpEndpoint):
        return [problem(f"{robot.gateway} is no tcp:// address", "write tcp://0.0.0.0:1481")]
    if _overlap(place, robot.port):
        text = f"{place} and central at {robot.port} want the same ports"
        return [problem(text, f"leave {_PORTS} ports between them")]
    faults = _faults(place.host, place.port)
    if errno.EADDRNOTAVAIL in faults.values():
        text = f"{place.host} is no address of this machine"
        return [problem(text, "see `ip address`, or take 0.0.0.0 for all addresses")]
    if not faults:
        return [ok(f"{place} and the ports after it are free")]
    if _is_of_running_hub(robot.port, next(iter(faults))):
        return [ok(f"the hub that runs has {place}")]
    return [
        _taken(f"port {port} of {place.host}", port, fault, "choose another gateway")
        for port, fault in faults.items()
    ]


def _overlap(place: TcpEndpoint, port: int) -> bool:
    """Whether the gateway there would have some of the ports of central at `port`."""
    everywhere = ipaddress.ip_address(place.host).is_unspecified or place.on_loopback
    return everywhere and place.port > 0 < port and abs(place.port - port) < _PORTS


def _crossed(port: int) -> Finding | None:
    """Warn if the system itself may use the ports, for connections of programs."""
    with contextlib.suppress(OSError, ValueError):
        low, high = (int(word) for word in _CONNECTIONS.read_text().split())
        if port + _PORTS > low and port <= high:
            text = (
                f"ports {port} to {port + _PORTS - 1} are free now, but connections may take them"
            )
            return warning(text, f"choose a port below {low - _PORTS} in [hub]")
    return None


def _faults(host: str, first: int) -> dict[int, int]:
    """Why we cannot listen, by port [errno]; empty if we can."""
    found = {}
    for port in range(first, first + _PORTS) if first else (0,):
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            # As in ZeroMQ: a port that was just closed can be opened again.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((host, port))
            except OSError as fault:
                found[port] = fault.errno or errno.EINVAL
    return found


def _taken(what: str, port: int, fault: int, advice: str) -> Finding:
    if fault != errno.EADDRINUSE:
        reason = errno.errorcode.get(fault, str(fault))
        return problem(f"{what} cannot be used ({reason})", advice)
    return problem(f"{what} is used by another program{_who(port)}", f"end it, or {advice}")


def _who(port: int) -> str:
    found = owner(port)
    return f" (pid {found.pid}: {found.name})" if found else ""


def modules_of_hub(port: int) -> str | None:
    """The clients of the hub at this port; None: no hub answers."""
    with contextlib.suppress(HubError), closing(_client_of(port)) as client:
        peers = client.directory.listing(_ANSWER_S).peers
        names = sorted(peer.name for peer in peers if peer.name != client.name)
        return ", ".join(names[:20]) or "nobody connected"
    return None


def kept(robot: RobotDescription) -> list[Finding]:
    """Whether the hub that runs keeps its recording and its mission."""
    if robot.port == 0 or modules_of_hub(robot.port) is None:
        return [ok("no hub runs here that has a recording or a mission")]
    with closing(_client_of(robot.port)) as client:
        lost = not_kept(client)
    advice = "look at the room on its disk and at the folders in the robot file"
    return [problem(each, advice) for each in lost] or [ok("the hub that runs reports no loss")]


def _client_of(port: int) -> Client:
    """A client of the hub at a port of this machine.

    Raises:
        HubError: No hub answers.
    """
    return message_commands.connect(f"tcp://{_LOCAL}:{port}", "doctor", None)


def _is_of_running_hub(port: int, taken: int) -> bool:
    """Whether the owner of a port is also the hub at `port`, as far as the system shows it."""
    if port == 0 or port not in _faults(_LOCAL, port) or modules_of_hub(port) is None:
        return False
    return owner(taken) == owner(port)
