"""Where central listens: the addresses of its sockets, and binding to them."""

from __future__ import annotations

import errno
import socket as socket_module
from collections.abc import Callable
from pathlib import Path

import zmq

from hub.errors import EndpointError
from hub.ipc import endpoints
from hub.ipc.transport import sockets


def sibling(
    endpoint: endpoints.TcpEndpoint | endpoints.IpcEndpoint, index: int
) -> endpoints.TcpEndpoint | endpoints.IpcEndpoint:
    """The address of the socket with this number next to central's own."""
    if index == 0:
        return endpoint
    if isinstance(endpoint, endpoints.TcpEndpoint):
        port = endpoint.port + index if endpoint.port else 0
        return endpoints.TcpEndpoint(endpoint.host, port)
    return endpoints.IpcEndpoint(f"{endpoint.path}.{index}")


TOKEN_DOMAIN = "tcp of this machine"
"""ZAP domain of central's own TCP sockets."""
FILE_DOMAIN = "socket file of this machine"
"""ZAP domain of socket files that are bound after TCP; a domain cannot be taken away again."""


Protect = Callable[[sockets.Socket], None]
"""Sets what a socket demands of its clients."""


def bind(
    socket: sockets.Socket,
    endpoint: endpoints.TcpEndpoint | endpoints.IpcEndpoint,
    protect: Protect | None = None,
) -> str:
    """Bind; the address with its real port.

    Args:
        socket: The socket.
        endpoint: The address.
        protect: Demands proof of clients at TCP: ZeroMQ asks who may connect. None: not at TCP.
    """
    if protect is not None:
        protect(socket)
        socket.zap_domain = TOKEN_DOMAIN.encode()
    elif socket.getsockopt_string(zmq.ZAP_DOMAIN).rstrip("\0"):
        socket.plain_server, socket.zap_domain = False, FILE_DOMAIN.encode()
    if isinstance(endpoint, endpoints.IpcEndpoint):
        _refuse_taken(endpoint)
        if endpoint.path.startswith("@"):
            sockets.allow_own_user_only(socket, root=True)
    try:
        sockets.bind(socket, str(endpoint))
    except zmq.ZMQError as error:
        reason = f"{error}; choose another endpoint"
        if error.errno == errno.EADDRINUSE:
            reason = "another program uses it; stop that program or choose another port"
        text = f"cannot listen at {endpoint}: {reason}"
        raise EndpointError(text) from error
    return socket.getsockopt_string(zmq.LAST_ENDPOINT).rstrip("\0")


def _refuse_taken(endpoint: endpoints.IpcEndpoint) -> None:
    """Refuse the path of a live socket or of a file: ZeroMQ would delete either."""
    path = Path(endpoint.path)
    if endpoint.path.startswith("@") or not path.exists():
        return
    if not path.is_socket():
        text = f"cannot listen at {endpoint}: a file is there; choose another path"
        raise EndpointError(text)
    with socket_module.socket(socket_module.AF_UNIX) as probe:
        try:
            probe.connect(endpoint.path)
        except OSError:
            return  # left behind by a program that ended
    text = f"cannot listen at {endpoint}: another program uses it; stop it or choose another path"
    raise EndpointError(text)
