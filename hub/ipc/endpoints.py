"""Endpoints: the addresses at which a hub may listen and a client may connect; pure.

Without keys the bus stays on this machine.
"""

from __future__ import annotations

import ipaddress
import re

from hub.errors import EndpointError
from hub.hub_sockets import LONGEST_NAME, NAMED, PREFERRED
from hub.values import dataclass

DEFAULT_PORT = 1381
"""TCP port of a hub that listens at one."""
DEFAULT_ENDPOINT = NAMED
LARGEST_PORT = 65529
"""Of a hub, which takes the six ports behind it as well."""
DIRECT_PREFIX = "ipc://@rune-"
"""Prefix of the direct addresses of clients on this machine."""
GATHER_PREFIX = f"{DIRECT_PREFIX}gather-"
"""Prefix of those whose client looks at them now and then."""
_MAX_DIRECT = 100
_MAX_IPC_PATH = 100
_HOST_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]{0,251}[A-Za-z0-9])?")


@dataclass(frozen=True, slots=True)
class TcpEndpoint:
    """A TCP address; port 0 lets the system choose when binding."""

    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"tcp://{host}:{self.port or '*'}"

    @property
    def on_loopback(self) -> bool:
        """Whether it accepts only this machine."""
        return _is_loopback(self.host)


@dataclass(frozen=True, slots=True)
class IpcEndpoint:
    """A Unix domain socket."""

    path: str

    def __str__(self) -> str:
        return f"ipc://{self.path}"


def endpoint_of(hub: str) -> str:
    """The name of a hub, a host and its port, or a whole endpoint, as an endpoint.

    This machine's own name for itself, such as 127.0.0.1, means its only hub.
    """
    if "://" in hub:
        return hub
    if hub in ("", "localhost") or _is_loopback(hub):
        return NAMED
    if ":" in hub:
        return f"tcp://{hub}"
    return f"tcp://{hub}:{DEFAULT_PORT}" if _is_address(hub) else f"{NAMED}{hub}"


def shown(endpoint: str) -> str:
    """An endpoint for people."""
    if not endpoint.startswith(NAMED):
        return endpoint
    name = endpoint.removeprefix(NAMED)
    return "this machine" if name[:1] in ("", PREFERRED) else f"{name} on this machine"


def parse_endpoint(text: str, *, beyond_loopback: bool = False) -> TcpEndpoint | IpcEndpoint:
    """The endpoint in a text, for a hub to listen at.

    Args:
        text: Such as tcp://127.0.0.1:1381 or ipc:///a/path.
        beyond_loopback: Whether other machines are allowed, which takes keys.

    Raises:
        EndpointError: It is malformed, or beyond this machine without permission.
    """
    scheme, separator, rest = text.partition("://")
    if separator and scheme == "ipc" and rest:
        if len(rest.encode()) > _MAX_IPC_PATH:
            reason = f"its path is longer than {_MAX_IPC_PATH} bytes"
            raise EndpointError(_refusal(text, reason))
        if "*" in rest:
            raise EndpointError(_refusal(text, "write the path of a socket file"))
        return IpcEndpoint(rest)
    endpoint = _tcp(text)
    if endpoint.on_loopback:
        return endpoint
    if not beyond_loopback:
        raise EndpointError(_refusal(text, _NEEDS_KEYS))
    if not _is_address(endpoint.host):
        reason = "write an address of this machine, or 0.0.0.0 for all of them"
        raise EndpointError(_refusal(text, reason))
    return endpoint


def tcp_endpoint(place: str) -> TcpEndpoint:
    """HOST:PORT of this machine, where a hub may listen.

    Raises:
        EndpointError: It is none.
    """
    endpoint = _tcp(f"tcp://{place}")
    if not endpoint.on_loopback:
        raise EndpointError(_refusal(place, "name an address of loopback; a gateway has others"))
    return endpoint


def connectable(text: str, *, with_keys: bool = False) -> str:
    """The endpoint in a text, as the address that a client connects to.

    Args:
        text: Such as hub://magellan or ipc:///a/path; with keys also tcp://robot.example:1481.
        with_keys: Whether the client has keys; only then may it leave this machine.

    Raises:
        EndpointError: It is malformed, names no port, or is beyond this machine and the client
        has no keys.
    """
    if text.startswith(NAMED):
        name = text.removeprefix(NAMED).removeprefix(PREFERRED)
        if "/" in name or not name.isprintable() or len(name) > LONGEST_NAME:
            raise EndpointError(_refusal(text, "write the name of a robot of this machine"))
        return text
    endpoint: TcpEndpoint | IpcEndpoint
    if with_keys and text.startswith("tcp://"):
        endpoint = _tcp(text)
        if not (_is_address(endpoint.host) or _HOST_NAME.fullmatch(endpoint.host)):
            raise EndpointError(_refusal(text, "its host is no name and no address"))
        if _is_address(endpoint.host) and ipaddress.ip_address(endpoint.host).is_unspecified:
            raise EndpointError(_refusal(text, "that is where a hub listens; name its machine"))
    else:
        endpoint = parse_endpoint(text)
    if isinstance(endpoint, TcpEndpoint) and endpoint.port == 0:
        raise EndpointError(_refusal(text, "port 0 is only for a hub that starts"))
    return str(endpoint)


_NEEDS_KEYS = (
    "without keys only this machine works; use `rune run --ssh`, or --keys FILE from "
    "`rune-hub keys make NAME --role operate`"
)


def _tcp(text: str) -> TcpEndpoint:
    scheme, separator, rest = text.partition("://")
    host, colon, port = rest.rpartition(":")
    if not separator or scheme != "tcp" or not colon or not (port.isdigit() and port.isascii()):
        raise EndpointError(_refusal(text, "write tcp://127.0.0.1:1381 or ipc:///a/path"))
    if len(port) > 5 or int(port) > LARGEST_PORT:
        raise EndpointError(_refusal(text, f"its port is above {LARGEST_PORT}"))
    host = host.strip("[]")
    return TcpEndpoint("127.0.0.1" if host == "localhost" else host, int(port))


def _is_address(host: str) -> bool:
    try:
        return not ipaddress.ip_address(host).is_multicast
    except ValueError:
        return False


def _is_loopback(host: str) -> bool:
    return _is_address(host) and ipaddress.ip_address(host).is_loopback


def _refusal(text: str, reason: str) -> str:
    return f"endpoint {text[:80]!r} cannot be used: {reason}"


def is_direct_address(address: str) -> bool:
    """Whether this is an address for direct messages: an abstract socket."""
    return address.startswith(DIRECT_PREFIX) and len(address) <= _MAX_DIRECT
