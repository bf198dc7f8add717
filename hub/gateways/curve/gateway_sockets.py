"""The sockets of the gateway: a copy of central's sockets, with CURVE.

ZeroMQ's proxy relays broadcasts between these sockets and central's own ones, with a thread for
each direction of a plane. Incoming commands are the exception: a Python thread checks each one.
Control messages arrive at a ROUTER of the gateway, which central polls beside its own.
"""

from __future__ import annotations

import errno
import threading
from collections.abc import Callable, Mapping
from typing import TypeAlias

import zmq

from hub.errors import EndpointError
from hub.gateways.accounts import Accounts
from hub.gateways.curve import command_filter
from hub.gateways.curve.connection_rates import ConnectionRates
from hub.gateways.curve.key_judge import KeyJudge
from hub.gateways.curve.received_bytes import ReceivedBytes
from hub.ipc.broker.carrying import Judge, carry
from hub.ipc.broker.subscription_floods import Bounds, FloodWatch
from hub.ipc.broker.zap import ZapHandler
from hub.ipc.endpoints import TcpEndpoint
from hub.ipc.roles import COMMANDS, CONTROL, Principal, Role
from hub.ipc.security.client_keys import KeyPair
from hub.ipc.security.keyring import Keyring
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.file_descriptors import BEYOND, Reserve, ends_of, hang_up

_FAILED = zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
_WATCHED = _FAILED | zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED
_BROADCASTS = frozenset({"state in", "state out", "picture in", "picture out"})
_BATCH = 16
"""Most events of one place per turn, before clients of this machine have theirs."""
_RELAY_QUEUE = 200
"""Queue between two proxies of this process; it fills only while one of them gets no time."""

_Socket: TypeAlias = "zmq.Socket[bytes]"


class GatewaySockets:
    """Central's sockets for other machines, open from the start to `close`.

    The polling thread calls all methods but `close`, which comes after its end.

    Attributes:
        endpoint: Address for clients, with the real port.
        control: ROUTER of the control messages. Its frames carry a User-Id (role, name, key).
        ports: TCP ports in the order of the planes: first plane in, out, second plane in, ...
        polled: Sockets to poll for input, without `control`; then call `serve`.
    """

    def __init__(
        self,
        context: zmq.Context[_Socket],
        endpoint: TcpEndpoint,
        keyring: Keyring,
        planes: Mapping[str, tuple[str, str]],
        faults: FaultCounter,
        *,
        make: Callable[[int, str], _Socket],
        accounts: Accounts,
        clock: Callable[[], float],
        judge: Judge,
        zap: ZapHandler,
    ) -> None:
        """Bind and start.

        Args:
            context: Central's. CURVE uses its second I/O thread, if there is one, so that other
                machines take no time from local modules.
            endpoint: Port p takes p and two more for each plane; 0 takes free ports.
            keyring: The keys that may connect, and the hub's own keys.
            planes: By name, the bound inproc addresses of central's XSUB and XPUB.
            faults: Counts refusals.
            make: Makes a socket with the bus's options: ZeroMQ type, plane or `roles.CONTROL`.
            accounts: The accounts of the keys.
            clock: Monotonic time [s].
            judge: Admits commands; called by a thread of the gateway.
            zap: Answers handshakes; its owner serves it.

        Raises:
            EndpointError: A port is busy.
            KeyFileError: The hub's keys cannot be used.
        """
        self._faults = faults
        self._clock = clock
        self._rates = ConnectionRates(faults, self.hang_up)
        self._bytes = ReceivedBytes(faults, self.hang_up)
        self._judge = judge
        self._reserve = Reserve(faults, part=BEYOND)  # other machines leave some to local modules
        self._made: list[_Socket] = []
        self._steering: list[_Socket] = []
        self._threads: list[threading.Thread] = []
        self._monitors: dict[_Socket, str] = {}
        self._floods: dict[str, FloodWatch] = {}
        keys = keyring.hub_keys()
        keyring.holders()  # report an unreadable list now, not at the first handshake
        self._judge_of_keys = KeyJudge(keyring, faults, accounts=accounts, clock=clock)
        places = [f"{plane} {way}" for plane in planes for way in ("in", "out")]
        zap.decide((CONTROL, *places), self._judge_of_keys.judge)
        self._affinity = 2 if context.get(zmq.IO_THREADS) > 1 else 0
        try:
            self._open(context, endpoint, keys, planes, make)
        except (zmq.ZMQError, EndpointError) as error:
            self._close_sockets()
            if isinstance(error, EndpointError):
                raise
            text = f"the gateway cannot make its sockets: {error}"
            raise EndpointError(text) from error
        self.polled = tuple(self._monitors)
        for thread in self._threads:
            thread.start()

    def serve(self, ready: Mapping[_Socket, int]) -> list[int]:
        """Note connections that came and ended; returns without waiting.

        Args:
            ready: Sockets with input; others' sockets are ignored.

        Returns:
            The descriptors of control connections that ended.
        """
        ended: list[int] = []
        for monitor, place in self._monitors.items():
            if monitor in ready:
                ended += self._watch(monitor, place)
        return ended

    def ended(self) -> list[int]:
        """Descriptors of all control connections that have ended."""
        ended: list[int] = []
        for monitor, place in self._monitors.items():
            while place == CONTROL and monitor.poll(0):
                ended += self._watch(monitor, place)
        return ended

    def check(self, known: Callable[[int], bool]) -> None:
        """Detect floods of subscriptions and silent connections; call it about ten times a second.

        Args:
            known: Whether a connected client has this descriptor.
        """
        now = self._clock()
        for flood in self._floods.values():
            flood.check(now)
        self._bytes.check(now)
        self._rates.end_silent(known, now)

    def identified(self, descriptor: int, role: Role) -> None:
        """Note the role of the key of a control connection."""
        self._bytes.identified(descriptor, role)

    def hang_up(self, descriptor: int) -> None:
        """End a connection of the gateway, but no other one with its descriptor."""
        ends = ends_of(descriptor)
        if ends is not None and ends[0] in self._all_ports:
            hang_up(descriptor)

    def end_broadcasts(self) -> None:
        """End all connections of states and pictures; clients with a key return at once.

        ZeroMQ does not show which of them belong to a key. Connections of commands stay, so no stop
        is lost: the filter checks each frame there.
        """
        for monitor, place in self._monitors.items():
            while place in _BROADCASTS and monitor.poll(0):
                self._watch(monitor, place)  # some may be new
        for descriptor in self._rates.at(_BROADCASTS):
            self.hang_up(descriptor)

    def admitted(self) -> frozenset[Principal]:
        """The keys admitted since the start."""
        return self._judge_of_keys.admitted()

    def close(self) -> None:
        """End the relays, and free the ports."""
        for steering in self._steering:
            steering.send(b"TERMINATE", zmq.NOBLOCK)
        for thread in self._threads:
            thread.join()
        self._close_sockets()

    def _open(
        self,
        context: zmq.Context[_Socket],
        endpoint: TcpEndpoint,
        keys: KeyPair,
        planes: Mapping[str, tuple[str, str]],
        make: Callable[[int, str], _Socket],
    ) -> None:
        def secure(kind: int, plane: str, place: str) -> _Socket:
            socket = make(kind, plane)
            self._made.append(socket)
            self._secure(socket, place, keys)
            return socket

        def inner(kind: int, plane: str, address: str) -> _Socket:
            socket = make(kind, plane)
            self._made.append(socket)
            socket.sndhwm = socket.rcvhwm = max(_RELAY_QUEUE, socket.rcvhwm)
            socket.connect(address)
            return socket

        self.control = secure(zmq.ROUTER, CONTROL, CONTROL)
        ends = [self.control]
        relays: list[tuple[str, _Socket, _Socket]] = []
        for plane, (inward, outward) in planes.items():
            for place, outer_kind, inner_kind, address in (
                (f"{plane} in", zmq.XSUB, zmq.XPUB, inward),
                (f"{plane} out", zmq.XPUB, zmq.XSUB, outward),
            ):
                outer = secure(outer_kind, plane, place)
                if place == COMMANDS:
                    outer.maxmsgsize, outer.rcvhwm = command_filter.LONGEST, command_filter.QUEUE
                if outer_kind == zmq.XPUB:
                    where = f"the gateway's {place}"
                    self._floods[place] = FloodWatch(outer, where, self._faults, Bounds())
                ends.append(outer)
                relays.append((place, outer, inner(inner_kind, plane, address)))
        ports = _bind_in_a_row(ends, endpoint)
        self.endpoint = TcpEndpoint(endpoint.host, ports[0])
        self.ports = tuple(ports[1:])
        self._all_ports = frozenset(ports)
        for place, outer, partner in relays:
            self._threads.append(self._relay(context, place, outer, partner))

    def _secure(self, socket: _Socket, place: str, keys: KeyPair) -> None:
        socket.curve_server = True
        socket.curve_publickey = keys.public.encode()
        socket.curve_secretkey = keys.secret.encode()
        socket.zap_domain = place.encode()
        # Without this ZeroMQ admits every client while no handler answers for the domain.
        socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 1)
        socket.affinity = self._affinity
        self._monitors[socket.get_monitor_socket(_WATCHED)] = place

    def _relay(
        self, context: zmq.Context[_Socket], place: str, outer: _Socket, inner: _Socket
    ) -> threading.Thread:
        """The thread that forwards in both directions until `close`."""
        address = f"inproc://gateway-steering-{place.replace(' ', '-')}"
        steered, steering = sockets.pair(context, address)
        self._made.append(steered)
        self._steering.append(steering)

        def hand_on() -> None:
            if place == COMMANDS:
                carry({outer: self._judge}, inner, steered)
            else:
                zmq.proxy_steerable(outer, inner, None, steered)

        return threading.Thread(target=hand_on, name=f"gateway {place}", daemon=True)

    def _watch(self, monitor: _Socket, place: str) -> list[int]:
        ended: list[int] = []
        for _ in range(_BATCH):
            try:
                raw = monitor.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                break
            event, descriptor = sockets.parse_event(raw)
            flood = self._floods.get(place)
            if event == zmq.EVENT_DISCONNECTED:
                self._rates.ended(descriptor)
                self._bytes.disconnected(descriptor)
                if flood is not None:
                    flood.disconnected(descriptor)
                elif place == CONTROL:
                    ended.append(descriptor)
            elif event == zmq.EVENT_ACCEPTED:
                self._reserve.admit(descriptor, f"the gateway's {place}")
                ends = ends_of(descriptor)
                if ends is None:  # it has ended already
                    continue
                if not self._rates.admit(descriptor, ends[1], place, self._clock()):
                    hang_up(descriptor)
                    continue
                self._bytes.connected(descriptor, place)
                if flood is not None:
                    flood.connected(descriptor, ends[1])
            else:
                self._faults.count(
                    f"bad handshake at the gateway's {place}",
                    "a peer left before it was over, or has no key, or another hub's, "
                    "or does not speak this protocol",
                )
        return ended

    def _close_sockets(self) -> None:
        for socket in (*self._made, *self._steering):
            if not socket.closed:
                # ZeroMQ's own thread would block at an event for a closed monitor, and a
                # closed socket still has events until that thread has freed it.
                socket.disable_monitor()
            socket.close(0)
        self._steering.clear()
        for monitor in self._monitors:
            monitor.close(0)


def _bind_in_a_row(ends: list[_Socket], endpoint: TcpEndpoint) -> list[int]:
    """Bind to consecutive ports; returns the real ports."""
    last = endpoint.port + len(ends) - 1
    if last > 65535:
        text = f"the gateway at {endpoint} needs the ports up to {last}; choose a lower one"
        raise EndpointError(text)
    ports = []
    for index, end in enumerate(ends):
        wanted = TcpEndpoint(endpoint.host, endpoint.port and endpoint.port + index)
        end.ipv6 = ":" in endpoint.host
        try:
            end.bind(str(wanted))
        except zmq.ZMQError as error:
            reason = f"{error}; choose another endpoint"
            if error.errno == errno.EADDRINUSE:
                reason = "another program uses it; stop that program or choose another port"
            text = f"the gateway cannot listen at {wanted}: {reason}"
            raise EndpointError(text) from error
        ports.append(int(end.getsockopt_string(zmq.LAST_ENDPOINT).rstrip("\0").rpartition(":")[2]))
    return ports
