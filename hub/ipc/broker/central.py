"""Central: the broker that modules and consoles connect to.

It owns the thread of control messages, which go to the registry. Broadcasts run through ZeroMQ's
own proxy, a thread for each plane, and central only checks copies of them. It never decodes the
payload of a message.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import logging
import math
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.errors import (
    CodecError,
    EndpointError,
    FrameError,
    HubError,
    NotAllowedError,
    OtherVersionError,
)
from hub.ipc.broker import binding
from hub.ipc.broker.entrance_monitors import EntranceMonitors
from hub.ipc.broker.gateways import CentralAccess, ControlEntrance, Gateway, GatewayOpener
from hub.ipc.broker.local_entrance import LocalEntrance
from hub.ipc.broker.peers import Caller, Outgoing, Peer
from hub.ipc.broker.plane_proxies import PlaneProxies, inner_addresses
from hub.ipc.broker.registry import Registry
from hub.ipc.broker.zap import ZapHandler
from hub.ipc.endpoints import IpcEndpoint, parse_endpoint
from hub.ipc.roles import CONTROL, LOCAL
from hub.ipc.transport import file_descriptors, heap, sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.transport.sender_tickets import SenderTickets
from hub.ipc.wire import control, control_codec, frames

_logger = logging.getLogger(__name__)

_LISTEN_S = 1.0
_BATCH = 256
_GATEWAY_TURN_S = 2e-3
"""Longest turn of a gateway before clients of this machine have theirs again [s]."""
_CHECK_S = 0.1
_TRIM_S = 5.0


class Central:
    """A running broker; its threads end with `close`.

    Attributes:
        endpoints: Where clients connect, with the real ports; those of gateways come last.
        faults: What was dropped, by reason.
    """

    def __init__(
        self,
        endpoints: Sequence[str],
        *,
        gateways: Sequence[GatewayOpener] = (),
        reserved: frozenset[str] = frozenset(),
        forwarder: str = "",
        clock: Callable[[], float] = time.monotonic,
        line_delay: Callable[[], float] = lambda: 0.0,
    ) -> None:
        """Bind and start.

        Args:
            endpoints: ipc:// addresses for clients on this machine, and at most one of tcp:// for
                those that have its token. A TCP port p takes p to p + 6; port 0 takes free ones.
            gateways: Openers of the gateways for other machines.
            reserved: Names that only the robot's own modules may have.
            forwarder: The client of this process that forwards messages under the numbers of
                others; empty: none does.
            clock: Monotonic time [s].
            line_delay: Round trip of a line behind this central, which its clients have to allow
                for [s]: PING is answered later by it.

        Raises:
            EndpointError: An address is malformed, not allowed, or busy.
            KeyFileError: The keys for a gateway, or the token of a port, cannot be used.
        """
        heap.keep_heap()
        file_descriptors.allow_many()
        self.faults = FaultCounter(_logger, clock)
        self._clock = clock
        self._line_delay = line_delay
        # The second thread serves gateways: other machines take no time from local modules.
        self._context: sockets.Context = zmq.Context(2 if gateways else 1)
        self._stopping = threading.Event()
        tickets = SenderTickets(self.faults)
        self.registry = Registry(
            clock=clock,
            faults=self.faults,
            reserved=reserved,
            key=tickets.key,
            forwarder=forwarder,
        )
        self.gateways: list[Gateway] = []
        self.endpoints: list[str] = []
        try:
            self._zap = ZapHandler(self._context, self.faults)
            self._planes = PlaneProxies(self._context, self.faults, clock, tickets)
            self._steered, self._steering = sockets.pair(self._context, "inproc://steering-control")
            self.entrances = [self._bind(endpoints)]
            for open_gateway in gateways:
                self._add_gateway(open_gateway)
        except (HubError, zmq.ZMQError) as error:
            for gateway in self.gateways:
                gateway.close()
            self._context.destroy(linger=0)
            if isinstance(error, HubError):
                raise
            text = f"central cannot make its sockets: {error}"  # such as: too many open files
            raise EndpointError(text) from error
        self._sends = [sockets.sender(entrance.router) for entrance in self.entrances]
        self.loop = Loop(clock=clock)
        self._thread = threading.Thread(target=self._serve, name="central-control", daemon=True)
        self._thread.start()
        self._planes.start()

    def connected(self) -> tuple[str, ...]:
        """Names of the modules and consoles that are connected now."""
        return self.registry.connected()

    def numbers(self) -> tuple[int, ...]:
        """Numbers in frame headers of the modules and consoles that are connected now."""
        return self.registry.peers.numbers()

    def peer_of(self, publisher: int) -> Peer | None:
        """The module or console of this number in frame headers; None if it is not connected."""
        return self.registry.peer_of(publisher)

    def listen_again(self, endpoint: str) -> None:
        """Bind again at an ipc:// address whose socket files were removed.

        Connections stay. Call it in the thread that closes central.
        """
        path = parse_endpoint(endpoint)
        ends = [binding.sibling(path, index) for index in range(1 + len(self._planes.ends))]
        files = [each for each in ends if isinstance(each, IpcEndpoint)]
        self._planes.bind_more(dict(zip(self._planes.ends, files[1:], strict=True)))

        def bind_control() -> None:
            try:
                binding.bind(self.entrances[0].router, files[0])
            except EndpointError as error:
                self.faults.count("cannot listen again", str(error))

        self.loop.post(bind_control)

    def close(self) -> None:
        """End the threads and free the endpoints."""
        if self._stopping.is_set():
            return
        self._steering.send(b"TERMINATE", zmq.NOBLOCK)
        self._planes.stop()
        self._stopping.set()  # only now: a thread that has ended reads no message
        self._thread.join()
        self._planes.close()
        self._steering.close(0)
        self._context.destroy(linger=0)
        self._local.close()

    def _bind(self, endpoints: Sequence[str]) -> ControlEntrance:
        """Bind the sockets for clients of this machine."""
        router = sockets.make_router(self._context)
        # Without it libzmq 4.3.5 loses memory when a connection claims an identity that is taken.
        router.router_handover = True
        self._monitors = EntranceMonitors(
            {CONTROL: router, **self._planes.ends},
            self._planes.floods,
            disconnected=self._disconnected,
            faults=self.faults,
            clock=self._clock,
        )
        ends = [router, *self._planes.ends.values()]
        epoch = self.registry.epoch
        self._local = LocalEntrance(ends, endpoints, self._zap, self.faults, epoch)
        self.endpoints += self._local.endpoints
        return self._local.entrance

    def _add_gateway(self, open_gateway: GatewayOpener) -> None:
        gateway = open_gateway(
            CentralAccess(
                context=self._context,
                planes={plane: inner_addresses(plane) for plane in sockets.PLANES},
                peer_of=self.registry.peer_of,
                has_connection=self.registry.has_connection,
                descriptors_of=self.registry.descriptors_of,
                disconnected=self._disconnected,
                send=lambda to, message: self._send([Outgoing(identity=to, message=message)]),
                faults=self.faults,
                clock=self._clock,
                zap=self._zap,
            )
        )
        self.gateways.append(gateway)
        self.entrances += gateway.entrances
        self.endpoints.append(gateway.endpoint)

    def _serve(self) -> None:
        """Serve control messages, monitors and copies of broadcasts, in a thread."""
        loop = self.loop
        self._register(loop)
        while not self._stopping.is_set():
            try:
                loop.listen(_LISTEN_S)
            except zmq.ContextTerminated:
                break
            except Exception:  # central survives a fault of its own
                self.faults.count("internal fault", "central goes on after it")
                if self.faults.counts["internal fault"] == 1:
                    _logger.exception("the first internal fault")
        loop.close()
        for gateway in self.gateways:
            gateway.close()
        self._monitors.close()
        for socket in (self._steered, self.entrances[0].router, self._planes.copies):
            socket.close(0)
        self._zap.close()

    def _register(self, loop: Loop) -> None:
        self._routers = [
            loop.register(entrance.router, functools.partial(self._take, number))
            for number, entrance in enumerate(self.entrances)
        ]
        loop.register(self._zap.socket, self._zap.serve)
        self._monitors.register(loop)
        for gateway in self.gateways:
            for polled in gateway.polled:
                loop.register(polled, functools.partial(self._serve_gateway, gateway, polled))
        loop.register(self._steered, self._read_stop)
        loop.every(_CHECK_S, lambda: self._planes.check(self.registry.broadcast))
        loop.every(_CHECK_S, self._check)
        loop.every(_TRIM_S, heap.give_back)
        loop.every(_CHECK_S, lambda: self._send(self.registry.expire()))

    def _check(self) -> None:
        now = self._clock()
        for watch in self._planes.floods.values():
            watch.check(now)
        for gateway in self.gateways:
            gateway.check()

    def _read_stop(self) -> bool:
        # This read also clears what ZeroMQ itself signals through its descriptor.
        if self._steered.poll(0):
            self._stopping.set()
        return False

    def _disconnected(self, descriptor: int) -> None:
        self._send(self.registry.disconnected(descriptor))

    def _read_ended(self) -> None:
        """Read the pending ends of control connections.

        ZeroMQ reports an end before it frees the descriptor, which the next connection may get.
        """
        self._monitors.read_ended()
        for gateway in self.gateways:
            gateway.report_ended()

    def _serve_gateway(self, gateway: Gateway, polled: sockets.Socket) -> bool:
        gateway.serve(polled)
        return sockets.readable(polled)

    def _take(self, number: int) -> bool:
        """Read the control messages at an entrance; whether there may be more.

        Each turn of the loop starts with the entrance of this machine, and a turn at a gateway
        is short. ZeroMQ reads from its connections in turn.
        """
        entrance = self.entrances[number]
        end = math.inf if entrance.guard is None else self._clock() + _GATEWAY_TURN_S
        for _ in range(_BATCH):
            try:
                parts = entrance.router.recv_multipart(zmq.NOBLOCK, copy=False)
            except zmq.Again:
                return False
            self._handle(number, parts[0].bytes, parts[1:])
            if not sockets.readable(entrance.router):
                self.loop.settle(self._routers[number])
                return False
            if self._clock() > end:
                break
        return True

    def _handle(self, number: int, sender: bytes, body: Sequence[zmq.Frame]) -> None:
        """Handle one control message, if the guard of its entrance admits it."""
        entrance = self.entrances[number]
        # Two routers may give two connections the same identity.
        identity = bytes([number]) + sender
        principal = LOCAL
        try:
            if entrance.guard is not None and body:
                principal = entrance.guard.principal_of(body[0])
                if not entrance.guard.admits(principal, identity, body):
                    return
            if not 1 <= len(body) <= 2:
                text = f"a control message has {len(body)} parts"
                raise FrameError(text)
            message = control_codec.unpack(body[0].buffer)
        except (FrameError, CodecError, NotAllowedError) as error:
            self.faults.count("malformed control frame", str(error))
            if body and (version := control_codec.other_version(body[0].buffer)):
                self._refuse_version(identity, version)
            return
        if isinstance(message, control.Hello):
            self._read_ended()  # or it is mistaken for the peer that had its descriptor before
        attached = body[1].buffer if len(body) == 2 else None
        descriptor = sockets.descriptor_of(body[0])
        caller = Caller(identity, descriptor, principal, entrance.ports, entrance.paths)
        outgoing = self.registry.handle(caller, message, attached)
        if isinstance(message, control.Ping) and (delay := self._line_delay()) > 0.0:
            self.loop.after(delay, lambda: self._send(outgoing))
        else:
            self._send(outgoing)

    def _refuse_version(self, identity: bytes, version: int) -> None:
        """Tell a client of another protocol version why it gets no WELCOME."""
        self.loop.touch(self._routers[identity[0]])
        with contextlib.suppress(zmq.ZMQError):  # it is gone, or does not read
            parts = [identity[1:], _version_refusal(version)]
            sockets.send_parts(self._sends[identity[0]], parts)

    def _send(self, outgoing: Sequence[Outgoing]) -> None:
        pending = list(outgoing)
        while pending:
            message = pending.pop(0)
            number = message.identity[0]
            self.loop.touch(self._routers[number])
            try:
                sockets.send_parts(self._sends[number], _parts(message))
            except zmq.Again:
                # It missed this message, so its state may be wrong: it has to start over.
                self.faults.count("queue full", "a peer does not read its control messages")
                pending += self.registry.unreachable(message.identity)
            except zmq.ZMQError as error:
                if error.errno != errno.EHOSTUNREACH:
                    raise
                pending += self.registry.unreachable(message.identity)


def _parts(message: Outgoing) -> list[bytes]:
    """The frames of a control message: identity, message, and its frame if it has one."""
    attached: list[Any] = [] if message.attached is None else [bytes(message.attached)]
    return [message.identity[1:], control_codec.pack(message.message), *attached]


def _version_refusal(version: int) -> bytes:
    """What a client of another protocol version gets, in its version."""
    text = (
        f"the hub is of another version of Rune (protocol {frames.VERSION}, this program "
        f"{version}); install the same version for both, and start the hub again"
    )
    refusal = control.Refused(subject="", error=OtherVersionError.__name__, text=text)
    return control_codec.pack(refusal, version)
