"""Central: the broker that modules and consoles connect to.

It owns the sockets and the threads of the broker. Broadcasts run through ZeroMQ's own proxy, one a
plane, and central only watches copies of them; control messages go to the registry. It never
decodes the payload of a message.
"""

from __future__ import annotations

import errno
import logging
import socket as socket_module
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import zmq
import zmq.utils.monitor

from hub.errors import CodecError, EndpointError, FrameError
from hub.ipc import control, frames, memory, security, sockets
from hub.ipc.complaints import Complaints
from hub.ipc.peers import Outgoing
from hub.ipc.registry import Registry

_logger = logging.getLogger(__name__)

_POLL_MS = 50
_BATCH = 256
_LOOK_S = 0.05
_LOOKED_AT = 500
_COPIES = 2000
"""Broadcasts that wait to be looked at, at most."""
_HANDSHAKE_FAILURES = (
    zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL,
    zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL,
    zmq.EVENT_HANDSHAKE_FAILED_AUTH,
)
_WATCHED = zmq.EVENT_DISCONNECTED | zmq.EVENT_HANDSHAKE_SUCCEEDED | sum(_HANDSHAKE_FAILURES)

_Socket = zmq.Socket[bytes]


class Central:
    """A running broker; its threads end with `close`.

    Attributes:
        endpoints: Where clients connect, with the real ports.
        complaints: What was dropped, by reason.
    """

    def __init__(
        self, endpoints: Sequence[str], *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Bind and start.

        Args:
            endpoints: tcp:// and ipc:// addresses for clients. A TCP port p takes p to p + 6;
                port 0 takes free ones.
            clock: Monotonic time [s].

        Raises:
            EndpointError: An address is malformed, not allowed, or busy.
        """
        memory.keep_heap()
        self.complaints = Complaints(_logger, clock)
        self._clock = clock
        self._next_look = 0.0
        self._context: zmq.Context[_Socket] = zmq.Context()
        self._stopping = threading.Event()
        self._threads: list[threading.Thread] = []
        self._steering: list[_Socket] = []
        try:
            self._bind([security.parse_endpoint(endpoint) for endpoint in endpoints])
        except EndpointError:
            self._context.destroy(linger=0)
            raise
        except zmq.ZMQError as error:  # such as: too many open files
            self._context.destroy(linger=0)
            text = f"central cannot make its sockets: {error}"
            raise EndpointError(text) from error
        self._registry = Registry(
            clock=clock, complaints=self.complaints, ports=self._ports, paths=self._paths
        )
        for target in (self._serve, *self._proxies):
            thread = threading.Thread(target=target, name=target.__name__, daemon=True)
            thread.start()
            self._threads.append(thread)

    def connected(self) -> tuple[str, ...]:
        """Names of the modules and consoles that are connected now."""
        return self._registry.connected()

    def close(self) -> None:
        """End the threads and free the endpoints."""
        if self._stopping.is_set():
            return
        for steering in self._steering:
            steering.send(b"TERMINATE", zmq.NOBLOCK)
        # Only now: a thread that had ended already could not be told any more.
        self._stopping.set()
        for thread in self._threads:
            thread.join()
        for steering in self._steering:
            steering.close()
        self._context.destroy(linger=0)
        for path in self._files:
            path.unlink(missing_ok=True)

    def _bind(self, wanted: Sequence[security.TcpEndpoint | security.IpcEndpoint]) -> None:
        self._router = sockets.make(self._context, zmq.ROUTER, 1000)
        self._router.router_mandatory = True
        self._monitors = {self._monitor(self._router): "control"}
        self._tap = sockets.make(self._context, zmq.SUB, _COPIES)
        self._tap.subscribe(b"")
        self._told = self._steered("control")
        self._proxies: list[Callable[[], None]] = []
        ends = [self._router]
        for plane in sockets.PLANES:
            inward = sockets.make_plane(self._context, zmq.XSUB, plane)
            outward = sockets.make_plane(self._context, zmq.XPUB, plane)
            ends += [inward, outward]
            self._monitors[self._monitor(inward)] = f"{plane.value} in"
            self._monitors[self._monitor(outward)] = f"{plane.value} out"
            self._proxies.append(self._proxy(plane.value, inward, outward))
        self.endpoints: list[str] = []
        self._files: list[Path] = []
        self._ports, self._paths = [0] * (len(ends) - 1), [""] * (len(ends) - 1)
        if len({type(endpoint) for endpoint in wanted}) < len(wanted):
            text = "central listens at one tcp:// and one ipc:// endpoint; name only one of each"
            raise EndpointError(text)
        for endpoint in wanted:
            bound = [_bind(end, _sibling(endpoint, index)) for index, end in enumerate(ends)]
            self.endpoints.append(bound[0])
            rest = [address.partition("://")[2] for address in bound[1:]]
            if isinstance(endpoint, security.TcpEndpoint):
                self._ports = [int(address.rpartition(":")[2]) for address in rest]
            else:
                self._paths = rest
                self._files += [Path(endpoint.path), *map(Path, rest)]

    def _monitor(self, socket: _Socket) -> _Socket:
        return socket.get_monitor_socket(_WATCHED)

    def _proxy(self, name: str, inward: _Socket, outward: _Socket) -> Callable[[], None]:
        """The function that forwards one plane until it is told to terminate."""
        copies = sockets.make(self._context, zmq.PUB, _COPIES)
        copies.bind(f"inproc://copies-{name}")
        self._tap.connect(f"inproc://copies-{name}")
        told = self._steered(name)

        def forward() -> None:
            zmq.proxy_steerable(inward, outward, copies, told)
            for socket in (inward, outward, copies, told):
                socket.close(0)

        forward.__name__ = f"central-{name}"
        return forward

    def _steered(self, name: str) -> _Socket:
        """A socket that hears when its thread shall end."""
        told, telling = self._context.socket(zmq.PAIR), self._context.socket(zmq.PAIR)
        told.bind(f"inproc://steering-{name}")
        telling.connect(f"inproc://steering-{name}")
        self._steering.append(telling)
        return told

    def _serve(self) -> None:
        """The thread of control messages, of what the monitors see, and of the watched copies."""
        poller = zmq.Poller()
        for socket in (self._told, self._router, *self._monitors):
            poller.register(socket, zmq.POLLIN)
        while not self._stopping.is_set():
            ready = dict(poller.poll(_POLL_MS))
            try:
                self._serve_ready(ready)
            except zmq.ContextTerminated:
                break
            except Exception:  # a fault of ours must not end the broker
                self.complaints.count("internal fault", "central goes on after it")
                if self.complaints.counts["internal fault"] == 1:
                    _logger.exception("the first internal fault")
        for monitor in self._monitors:
            monitor.close(0)
        self._told.close(0)
        self._router.close(0)
        self._tap.close(0)

    def _serve_ready(self, ready: dict[_Socket, int]) -> None:
        for monitor, where in self._monitors.items():
            if monitor in ready:
                self._watch(monitor, where)
        if self._router in ready:
            self._answer()
        now = self._clock()
        if now >= self._next_look:
            self._next_look = now + _LOOK_S
            self._look()
            self._send(self._registry.expire())

    def _watch(self, monitor: _Socket, where: str) -> None:
        """See who came, who went, and who sent something that is not ZeroMQ."""
        while monitor.poll(0):
            raw = monitor.recv_multipart(zmq.NOBLOCK)
            event = zmq.utils.monitor.parse_monitor_message(raw)
            if event["event"] in _HANDSHAKE_FAILURES:
                self.complaints.count(
                    f"bad handshake on {where}",
                    "a peer left in the middle of it, or does not speak this protocol",
                )
            elif event["event"] == zmq.EVENT_DISCONNECTED and where == "control":
                self._send(self._registry.disconnected(int(event["value"])))

    def _answer(self) -> None:
        for _ in range(_BATCH):
            try:
                parts = self._router.recv_multipart(zmq.NOBLOCK, copy=False)
            except zmq.Again:
                return
            identity, body = parts[0].bytes, parts[1:]
            if not 1 <= len(body) <= 2:
                self.complaints.count("malformed control frame", f"{len(body)} parts")
                continue
            try:
                message = control.unpack(body[0].buffer)
            except (FrameError, CodecError) as error:
                self.complaints.count("malformed control frame", str(error))
                continue
            if isinstance(message, control.List):
                self._look()  # so that what was received is also counted
            attached = body[1].buffer if len(body) == 2 else None
            self._send(self._registry.handle(identity, _descriptor(parts[1]), message, attached))

    def _look(self) -> None:
        """Count the broadcasts, and what is wrong with them.

        Not one by one as they pass: then each would wake this thread and take the processor from
        who waits for the message. Nor all of them under a flood; sequence numbers tell the rest.
        """
        for _ in range(_LOOKED_AT):
            try:
                raw = self._tap.recv(zmq.NOBLOCK)
            except zmq.Again:
                return
            if raw[:1] in (b"\0", b"\1"):
                continue  # the proxy's own subscriptions pass here as well
            try:
                self._registry.broadcast(frames.unpack(raw), len(raw))
            except FrameError as error:
                self.complaints.count("malformed frame", str(error))

    def _send(self, outgoing: Sequence[Outgoing]) -> None:
        pending = list(outgoing)
        while pending:
            message = pending.pop(0)
            parts = [message.identity, control.pack(message.message)]
            if message.attached is not None:
                parts.append(bytes(message.attached))
            try:
                self._router.send_multipart(parts, zmq.NOBLOCK)
            except zmq.Again:
                self.complaints.count("queue full", "a peer does not read its control messages")
            except zmq.ZMQError as error:
                if error.errno != errno.EHOSTUNREACH:
                    raise
                pending += self._registry.unreachable(message.identity)


def _descriptor(frame: zmq.Frame) -> int:
    """The connection a frame came in on; -1 where the transport does not say."""
    try:
        return int(frame.get("__fd"))
    except (zmq.ZMQError, ValueError, TypeError):
        return -1


def _sibling(
    endpoint: security.TcpEndpoint | security.IpcEndpoint, index: int
) -> security.TcpEndpoint | security.IpcEndpoint:
    """The address of the socket with this number next to central's own."""
    if index == 0:
        return endpoint
    if isinstance(endpoint, security.TcpEndpoint):
        port = endpoint.port + index if endpoint.port else 0
        return security.TcpEndpoint(endpoint.host, port)
    return security.IpcEndpoint(f"{endpoint.path}.{index}")


def _bind(socket: _Socket, endpoint: security.TcpEndpoint | security.IpcEndpoint) -> str:
    """Bind; the address with its real port."""
    if isinstance(endpoint, security.IpcEndpoint):
        _refuse_taken(endpoint)
    try:
        sockets.bind(socket, str(endpoint))
    except zmq.ZMQError as error:
        reason = f"{error}; choose another endpoint"
        if error.errno == errno.EADDRINUSE:
            reason = "another program uses it; stop that program or choose another port"
        text = f"cannot listen at {endpoint}: {reason}"
        raise EndpointError(text) from error
    return socket.getsockopt_string(zmq.LAST_ENDPOINT).rstrip("\0")


def _refuse_taken(endpoint: security.IpcEndpoint) -> None:
    """Refuse the path of a live socket or of somebody's file: ZeroMQ would delete either."""
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
