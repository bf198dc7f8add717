"""The doctor on TCP ports: whether the hub and its gateway can listen where the robot file says."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import socket
from pathlib import Path

from hub import hub_sockets
from hub.errors import HubError
from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.inspection.doctor.tcp_owners import owner
from hub.ipc.definition import Plane
from hub.ipc.endpoints import TcpEndpoint, parse_endpoint, tcp_endpoint
from hub.robots.description import RobotDescription

_PORTS = 1 + 2 * len(Plane)
"""Number of ports: one for control messages, and two for each plane."""
_CONNECTIONS = Path("/proc/sys/net/ipv4/ip_local_port_range")


def tcp(robot: RobotDescription) -> list[Finding]:
    """Whether the ports for clients with the hub's token are free."""
    if not robot.listen:
        return [ok("the hub opens no TCP port for clients of this machine")]
    try:
        place = tcp_endpoint(robot.listen)
    except HubError as error:
        return [problem(str(error), "correct [hub], key 'listen'")]
    return _row(robot, place) or [_crossed(place.port) or ok(f"{_named(place)} are free")]


def gateway(robot: RobotDescription) -> list[Finding]:
    """Whether the gateway's address is one of this machine, and its ports are free."""
    if not robot.gateway:
        return [ok("none in the robot file: only this machine may connect")]
    try:
        place = parse_endpoint(robot.gateway, beyond_loopback=True)
        own = tcp_endpoint(robot.listen) if robot.listen else None
    except HubError as error:
        return [problem(str(error), "correct [hub], keys 'gateway' and 'listen'")]
    if not isinstance(place, TcpEndpoint):
        return [problem(f"{robot.gateway} is no tcp:// address", "write tcp://0.0.0.0:1481")]
    if own is not None and _overlap(place, own.port):
        text = f"the gateway at {place} and the hub at {own} want the same ports"
        return [problem(text, f"leave {_PORTS} ports between them")]
    return _row(robot, place) or [ok(f"{_named(place)} are free")]


def _row(robot: RobotDescription, place: TcpEndpoint) -> list[Finding]:
    """Why the ports of a place cannot be used; empty: they are free."""
    faults = _faults(place.host, place.port)
    if errno.EADDRNOTAVAIL in faults.values():
        text = f"{place.host} is no address of this machine"
        return [problem(text, "see `ip address`, or take 0.0.0.0 for all addresses")]
    if faults and _is_of_running_hub(robot.name, next(iter(faults))):
        return [ok(f"the hub that runs has {place}")]
    return [
        _taken(f"port {port} of {place.host}", port, fault, "choose another port in [hub]")
        for port, fault in faults.items()
    ]


def _named(place: TcpEndpoint) -> str:
    return f"ports {place.port} to {place.port + _PORTS - 1} of {place.host}"


def _overlap(place: TcpEndpoint, port: int) -> bool:
    """Whether the gateway there would have some of the ports of the hub at `port`."""
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
    found = owner(port)
    who = f" (pid {found.pid}: {found.name})" if found else ""
    return problem(f"{what} is used by another program{who}", f"end it, or {advice}")


def _is_of_running_hub(name: str, port: int) -> bool:
    """Whether the owner of a port is the hub of this name, as far as the system shows it."""
    found = owner(port)
    return found is not None and str(found.pid) == hub_sockets.process_at(hub_sockets.NAMED + name)
