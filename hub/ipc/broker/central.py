"""Central: the broker that modules and consoles connect to.

It owns the sockets and the threads of the broker. Broadcasts run through ZeroMQ's own proxy, one a
plane, and central only watches copies of them; control messages go to the registry. It never
decodes the payload of a message.
"""

from __future__ import annotations

import errno
import functools
import logging
import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zmq

from hub.errors import CodecError, EndpointError, FrameError, HubError, NotAllowedError
from hub.ipc import roles
from hub.ipc.broker import binding
from hub.ipc.broker.admission import Admission
from hub.ipc.broker.command_filter import CommandFilter
from hub.ipc.broker.gateway import Gateway
from hub.ipc.broker.peers import Caller, Outgoing, Peer
from hub.ipc.broker.quotas import Accounts
from hub.ipc.broker.registry import Registry
from hub.ipc.broker.subscription_floods import FloodWatch
from hub.ipc.definition import Plane
from hub.ipc.endpoints import IpcEndpoint, TcpEndpoint, parse_endpoint
from hub.ipc.roles import LOCAL, Principal
from hub.ipc.security.keyring import Keyring
from hub.ipc.security.removed_keys import RemovedKeys
from hub.ipc.transport import file_descriptors, heap, sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.wire import control, control_codec, frames

_logger = logging.getLogger(__name__)

_LISTEN_S = 1.0
_BATCH = 256
_GATEWAY_TURN_S = 2e-3
"""How long control messages of the gateway are taken before clients of this machine again [s]."""
_CONTROL_QUEUE, _CONTROL_BACKLOG = 1000, 20_000
"""Control messages that wait from one peer and for one: a new one is told much at once."""
_FAR_QUEUE, _FAR_BACKLOG = 100, 5000
"""The same at the gateway, where a peer may send long ones, or read none."""
_LOOK_S = 0.1
_TRIM_S = 5.0
_LOOKING_S, _LOOKING_CLOSER_S = 1e-3, 20e-3
"""How long broadcasts are looked at each time: while all is well, after something wrong [s]."""
_COPIES = {Plane.STATE: 400, Plane.COMMAND: 400, Plane.PICTURE: 8}
"""Broadcasts that wait to be looked at, at most; each holds its memory until then."""
_HANDSHAKE_FAILURES = (
    zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL,
    zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL,
    zmq.EVENT_HANDSHAKE_FAILED_AUTH,
)
_WATCHED = zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED | sum(_HANDSHAKE_FAILURES)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEntrance:
    """A way in for control messages.

    Attributes:
        router: Its socket.
        send: Sends on it.
        ports: TCP ports of each plane in turn, in and out, for who came in here.
        paths: ipc:// paths of the same.
        guarded: Whether the frames carry who sent them, because only keys open it.
    """

    router: sockets.Socket
    send: Callable[[bytes, int], Any]
    ports: tuple[int, ...]
    paths: tuple[str, ...] = ("",) * (2 * len(sockets.PLANES))
    guarded: bool = False


class Central:
    """A running broker; its threads end with `close`.

    Attributes:
        endpoints: Where clients connect, with the real ports.
        faults: What was dropped, by reason.
    """

    def __init__(
        self,
        endpoints: Sequence[str],
        *,
        gateway: str = "",
        keyring: Keyring | None = None,
        reserved: frozenset[str] = frozenset(),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Bind and start.

        Args:
            endpoints: tcp:// and ipc:// addresses for clients on this machine. A TCP port p takes
                p to p + 6; port 0 takes free ones.
            gateway: tcp:// address for clients with keys on other machines; empty for none.
            keyring: The hub's keys and who else has one; needed for a gateway.
            reserved: Names that only the robot's own modules may have.
            clock: Monotonic time [s].

        Raises:
            EndpointError: An address is malformed, not allowed, or busy.
            KeyFileError: The keys for the gateway cannot be used.
        """
        heap.keep_heap()
        file_descriptors.allow_many()
        self.faults = FaultCounter(_logger, clock)
        self._clock = clock
        self._reserve = file_descriptors.Reserve(self.faults)
        # The second thread is for the gateway: strangers take no time from local modules.
        self._context: sockets.Context = zmq.Context(2 if gateway else 1)
        self._stopping = threading.Event()
        self._threads: list[threading.Thread] = []
        self._steering: list[sockets.Socket] = []
        self._gateway: Gateway | None = None
        self._accounts = Accounts()
        self._admission = Admission(
            self._accounts,
            clock=clock,
            faults=self.faults,
            answer=lambda to, said: self._send([Outgoing(identity=to, message=said)]),
            hang_up=self._hang_up,
            holds=lambda principal: self._keys.holds(principal),  # noqa: PLW0108 - made later
        )
        self._registry = Registry(clock=clock, faults=self.faults, reserved=reserved)
        try:
            self._bind([parse_endpoint(endpoint) for endpoint in endpoints])
            if gateway:
                self._open_gateway(gateway, keyring)
        except HubError:
            self._context.destroy(linger=0)
            raise
        except zmq.ZMQError as error:  # such as: too many open files
            self._context.destroy(linger=0)
            text = f"central cannot make its sockets: {error}"
            raise EndpointError(text) from error
        for target in (self._serve, *self._proxies):
            thread = threading.Thread(target=target, name=target.__name__, daemon=True)
            thread.start()
            self._threads.append(thread)

    def connected(self) -> tuple[str, ...]:
        """Names of the modules and consoles that are connected now."""
        return self._registry.connected()

    def peer_of(self, publisher: int) -> Peer | None:
        """The module or console of this number in frame headers; None if it is not connected."""
        return self._registry.peer_of(publisher)

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
        for socket in (*self._steering, *self._proxied):
            socket.close(0)
        self._context.destroy(linger=0)
        for path in self._files:
            path.unlink(missing_ok=True)

    def _bind(self, wanted: Sequence[TcpEndpoint | IpcEndpoint]) -> None:
        router = self._control_socket(zmq.ROUTER)
        router.router_mandatory = True
        # Without it libzmq 4.3.5 loses memory with each stranger that claims a taken identity.
        router.router_handover = True
        self._monitors = {self._monitor(router): "control"}
        self._tap = sockets.make(self._context, zmq.SUB, 1)
        self._tap.subscribe(b"")
        self._told = self._steered("control")
        self._proxies: list[Callable[[], None]] = []
        self._proxied: list[sockets.Socket] = []
        self._floods: dict[str, FloodWatch] = {}
        ends = [router]
        for plane in sockets.PLANES:
            inward = sockets.make_plane(self._context, zmq.XSUB, plane)
            outward = sockets.make_plane(self._context, zmq.XPUB, plane)
            for end, address in zip((inward, outward), _inner(plane), strict=True):
                end.bind(address)
            ends += [inward, outward]
            self._monitors[self._monitor(inward)] = f"{plane.value} in"
            self._monitors[self._monitor(outward)] = where = f"{plane.value} out"
            self._floods[where] = FloodWatch(outward, where, self.faults)
            self._proxies.append(self._proxy(plane, inward, outward))
        self.endpoints: list[str] = []
        self._files: list[Path] = []
        ports, paths = [0] * (len(ends) - 1), [""] * (len(ends) - 1)
        if len({type(endpoint) for endpoint in wanted}) < len(wanted):
            text = "central listens at one tcp:// and one ipc:// endpoint; name only one of each"
            raise EndpointError(text)
        for endpoint in wanted:
            bound = [
                binding.bind(end, binding.sibling(endpoint, index))
                for index, end in enumerate(ends)
            ]
            self.endpoints.append(bound[0])
            rest = [address.partition("://")[2] for address in bound[1:]]
            if isinstance(endpoint, TcpEndpoint):
                ports = [int(address.rpartition(":")[2]) for address in rest]
            else:
                paths = rest
                self._files += [Path(endpoint.path), *map(Path, rest)]
        send = sockets.sender(router)
        self._doors = [
            ControlEntrance(router=router, send=send, ports=tuple(ports), paths=tuple(paths))
        ]

    def _control_socket(self, kind: int) -> sockets.Socket:
        made = sockets.make(self._context, kind, _CONTROL_QUEUE)
        made.sndhwm = _CONTROL_BACKLOG
        return made

    def _monitor(self, socket: sockets.Socket) -> sockets.Socket:
        return socket.get_monitor_socket(_WATCHED)

    def _proxy(
        self, plane: Plane, inward: sockets.Socket, outward: sockets.Socket
    ) -> Callable[[], None]:
        """The function that forwards one plane until it is told to terminate."""
        name = plane.value
        copies = sockets.make(self._context, zmq.PUB, _COPIES[plane])
        copies.bind(f"inproc://copies-{name}")
        self._tap.connect(f"inproc://copies-{name}")
        told = self._steered(name)

        def forward() -> None:
            zmq.proxy_steerable(inward, outward, copies, told)

        self._proxied += [inward, outward, copies, told]
        forward.__name__ = f"central-{name}"
        return forward

    def _steered(self, name: str) -> sockets.Socket:
        """A socket that hears when its thread shall end."""
        told, telling = self._context.socket(zmq.PAIR), self._context.socket(zmq.PAIR)
        told.bind(f"inproc://steering-{name}")
        telling.connect(f"inproc://steering-{name}")
        self._steering.append(telling)
        return told

    def _open_gateway(self, wanted: str, keyring: Keyring | None) -> None:
        endpoint = parse_endpoint(wanted, beyond_loopback=True)
        if not isinstance(endpoint, TcpEndpoint) or keyring is None:
            text = f"the gateway at {wanted!r} needs a tcp:// address and a folder of keys"
            raise EndpointError(text)

        def make(kind: int, plane: str) -> sockets.Socket:
            if plane == roles.CONTROL:
                made = self._control_socket(kind)
                made.rcvhwm, made.sndhwm = _FAR_QUEUE, _FAR_BACKLOG
                return made
            return sockets.make_plane(self._context, kind, Plane(plane))

        inner = {plane.value: _inner(plane) for plane in sockets.PLANES}
        self._keys = RemovedKeys(keyring, self._admitted, self._end_key)
        door = CommandFilter(
            self._registry.peer_of,
            self._keys.holds,
            self.faults,
            self._clock,
            accounts=self._accounts,
        )
        self._gateway = Gateway(
            self._context,
            endpoint,
            keyring,
            inner,
            self.faults,
            make=make,
            accounts=self._accounts,
            clock=self._clock,
            judge=door.admit,
        )
        self._gateway.control.router_mandatory = True
        self.endpoints.append(str(self._gateway.endpoint))
        self._doors.append(
            ControlEntrance(
                router=self._gateway.control,
                send=sockets.sender(self._gateway.control),
                ports=self._gateway.ports,
                guarded=True,
            )
        )

    def _serve(self) -> None:
        """The thread of control messages, of what the monitors see, and of the watched copies."""
        loop = Loop(clock=self._clock)
        files: list[int] = []
        for number, door in enumerate(self._doors):
            files.append(loop.register(door.router, functools.partial(self._answer, number)))
        self._routers = files
        self._loop = loop
        for monitor, where in self._monitors.items():
            loop.register(monitor, functools.partial(self._watch, monitor, where))
        for polled in self._gateway.polled if self._gateway else ():
            loop.register(polled, functools.partial(self._serve_gateway, polled))
        loop.register(self._told, self._told_to_end)
        loop.every(_LOOK_S, self._look)
        loop.every(_LOOK_S, self._look_for_floods)
        loop.every(_TRIM_S, heap.give_back)
        loop.every(_LOOK_S, lambda: self._send(self._registry.expire()))
        while not self._stopping.is_set():
            try:
                loop.listen(_LISTEN_S)
            except zmq.ContextTerminated:
                break
            except Exception:  # a fault of ours must not end the broker
                self.faults.count("internal fault", "central goes on after it")
                if self.faults.counts["internal fault"] == 1:
                    _logger.exception("the first internal fault")
        loop.close()
        if self._gateway is not None:
            self._gateway.close()
        for monitor in self._monitors:
            monitor.close(0)
        self._told.close(0)
        self._doors[0].router.close(0)
        self._tap.close(0)

    def _watch(self, monitor: sockets.Socket, where: str) -> bool:
        """See who came, who went, and who sent something that is not ZeroMQ."""
        while True:
            try:
                raw = monitor.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return False
            event, descriptor = sockets.parse_event(raw)
            if event in _HANDSHAKE_FAILURES:
                self.faults.count(
                    f"bad handshake on {where}",
                    "a peer left in the middle of it, or does not speak this protocol",
                )
            elif event == zmq.EVENT_ACCEPTED:
                self._reserve.admit(descriptor, where)
                if where in self._floods:
                    self._floods[where].connected(descriptor)
            elif where in self._floods:
                self._floods[where].disconnected(descriptor)
            elif where == "control":
                self._send(self._registry.disconnected(descriptor))

    def _look_for_floods(self) -> None:
        now = self._clock()
        for watch in self._floods.values():
            watch.look(now)
        if self._gateway is not None:
            self._gateway.look(self._registry.has_connection)
            self._keys.look(now)

    def _told_to_end(self) -> bool:
        # Looking at it also clears what ZeroMQ itself signals through its descriptor.
        if self._told.poll(0):
            self._stopping.set()
        return False

    def _see_who_left(self) -> None:
        """Take what was noticed of control connections up to now.

        ZeroMQ tells of an end before it frees the descriptor, which the next connection may get.
        """
        for monitor, where in self._monitors.items():
            if where == "control":
                self._watch(monitor, where)
        if self._gateway is not None:
            for descriptor in self._gateway.ended():
                self._send(self._registry.disconnected(descriptor))

    def _serve_gateway(self, polled: sockets.Socket) -> bool:
        if self._gateway is not None:
            for descriptor in self._gateway.serve({polled: zmq.POLLIN}):
                self._send(self._registry.disconnected(descriptor))
        return bool(int(polled.getsockopt(zmq.EVENTS)) & zmq.POLLIN)

    def _answer(self, number: int) -> bool:
        """Take the control messages at a door; whether there may be more.

        The loop comes to the door of this machine first in each turn, and a turn at the gateway is
        short. ZeroMQ takes a message from each connection in turn.
        """
        door = self._doors[number]
        end = self._clock() + _GATEWAY_TURN_S if door.guarded else math.inf
        for _ in range(_BATCH):
            try:
                parts = door.router.recv_multipart(zmq.NOBLOCK, copy=False)
            except zmq.Again:
                return False
            self._take(number, parts[0].bytes, parts[1:])
            if not sockets.readable(door.router):
                self._loop.settle(self._routers[number])
                return False
            if self._clock() > end:
                break
        return True

    def _take(self, number: int, sender: bytes, body: Sequence[zmq.Frame]) -> None:
        """Serve one control message, if its sender has not asked too much."""
        door = self._doors[number]
        # Two routers may give two connections the same identity.
        identity = bytes([number]) + sender
        principal = LOCAL
        try:
            if door.guarded and body:
                principal = self._admission.principal(body[0])
                if not self._admission.admits(principal, identity, body):
                    return
            if not 1 <= len(body) <= 2:
                text = f"a control message has {len(body)} parts"
                raise FrameError(text)
            message = control_codec.unpack(body[0].buffer)
        except (FrameError, CodecError, NotAllowedError) as error:
            self.faults.count("malformed control frame", str(error))
            return
        if isinstance(message, control.Hello):
            self._see_who_left()  # or this one is taken for who had its descriptor before
        attached = body[1].buffer if len(body) == 2 else None
        caller = Caller(identity, sockets.descriptor_of(body[0]), principal, door.ports, door.paths)
        self._send(self._registry.handle(caller, message, attached))

    def _hang_up(self, frame: zmq.Frame) -> None:
        """End the connection of the gateway that a control frame came in on."""
        if self._gateway is not None:
            self._gateway.hang_up(sockets.descriptor_of(frame))

    def _admitted(self) -> frozenset[Principal]:
        return self._gateway.admitted() if self._gateway is not None else frozenset()

    def _end_key(self, principal: Principal) -> None:
        if self._gateway is not None:
            self._gateway.end_broadcasts()
        for descriptor in self._registry.descriptors_of(principal):
            if self._gateway is not None:
                self._gateway.hang_up(descriptor)
            self._send(self._registry.disconnected(descriptor))

    def _look(self) -> None:
        """Count what is wrong with the broadcasts that pass.

        Not one by one as they do: then each would wake this thread and take the processor from who
        waits for the message. Nor all of them under a flood.
        """
        began, enough = self._clock(), _LOOKING_S
        while self._clock() - began < enough:
            try:
                raw = self._tap.recv(zmq.NOBLOCK)
            except zmq.Again:
                return
            if raw[:1] in (b"\0", b"\1"):
                continue  # the proxy's own subscriptions pass here as well
            try:
                right = self._registry.broadcast(frames.unpack(raw))
            except FrameError as error:
                self.faults.count("malformed frame", str(error))
                right = False
            if not right:
                enough = _LOOKING_CLOSER_S

    def _send(self, outgoing: Sequence[Outgoing]) -> None:
        pending = list(outgoing)
        while pending:
            message = pending.pop(0)
            number = message.identity[0]
            send, packed = self._doors[number].send, control_codec.pack(message.message)
            self._loop.touch(self._routers[number])
            try:
                attached = [] if message.attached is None else [bytes(message.attached)]
                sockets.send_parts(send, [message.identity[1:], packed, *attached])
            except zmq.Again:
                # Without this one it would take something for true that is not: it begins anew.
                self.faults.count("queue full", "a peer does not read its control messages")
                pending += self._registry.unreachable(message.identity)
            except zmq.ZMQError as error:
                if error.errno != errno.EHOSTUNREACH:
                    raise
                pending += self._registry.unreachable(message.identity)


def _inner(plane: Plane) -> tuple[str, str]:
    """Where the gateway finds the sockets of a plane: in, out."""
    return f"inproc://{plane.value}-in", f"inproc://{plane.value}-out"
