"""Where central may listen, and to whom a client may talk: this machine only."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass

from hub.errors import EndpointError

DEFAULT_PORT = 1381
DEFAULT_ENDPOINT = f"tcp://127.0.0.1:{DEFAULT_PORT}"
_MAX_IPC_PATH = 100


@dataclass(frozen=True, slots=True)
class TcpEndpoint:
    """A TCP address on this machine; port 0 lets the system choose when binding."""

    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"tcp://{host}:{self.port or '*'}"


@dataclass(frozen=True, slots=True)
class IpcEndpoint:
    """A Unix domain socket."""

    path: str

    def __str__(self) -> str:
        return f"ipc://{self.path}"


def parse_endpoint(text: str) -> TcpEndpoint | IpcEndpoint:
    """The endpoint that a person wrote.

    Raises:
        EndpointError: It is malformed, or it is not on this machine.
    """
    scheme, separator, rest = text.partition("://")
    if separator and scheme == "ipc" and rest:
        if len(rest.encode()) > _MAX_IPC_PATH:
            reason = f"its path is longer than {_MAX_IPC_PATH} bytes"
            raise EndpointError(_refusal(text, reason))
        if "*" in rest:
            raise EndpointError(_refusal(text, "write the path of a socket file"))
        return IpcEndpoint(rest)
    host, colon, port = rest.rpartition(":")
    if not separator or scheme != "tcp" or not colon or not (port.isdigit() and port.isascii()):
        raise EndpointError(_refusal(text, "write tcp://127.0.0.1:1381 or ipc:///a/path"))
    if len(port) > 5 or int(port) > 65529:
        raise EndpointError(_refusal(text, "its port is above 65529"))
    return TcpEndpoint(_loopback(text, host.strip("[]")), int(port))


def connectable(text: str) -> str:
    """The endpoint that a person wrote, as the address a client connects to.

    Raises:
        EndpointError: It is malformed, not on this machine, or names no port.
    """
    endpoint = parse_endpoint(text)
    if isinstance(endpoint, TcpEndpoint) and endpoint.port == 0:
        raise EndpointError(_refusal(text, "port 0 is only for a hub that starts"))
    return str(endpoint)


def _loopback(text: str, host: str) -> str:
    if host == "localhost":
        return "127.0.0.1"
    try:
        local = ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = False
    if not local:
        reason = "only this machine (127.0.0.1) is allowed; reach a robot through ssh -L"
        raise EndpointError(_refusal(text, reason))
    return host


def _refusal(text: str, reason: str) -> str:
    return f"endpoint {text[:80]!r} cannot be used: {reason}"
