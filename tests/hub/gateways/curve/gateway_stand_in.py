"""What a gateway needs in tests: central's local planes, and clients of other machines."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import zmq
import zmq.utils.monitor

from hub.gateways.accounts import Accounts
from hub.gateways.curve.gateway_sockets import GatewaySockets
from hub.ipc.broker.zap import ZapHandler
from hub.ipc.endpoints import TcpEndpoint
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import ClientKeys, read_client_keys
from hub.ipc.security.keyring import Keyring
from hub.ipc.transport.fault_counter import FaultCounter

PLANES = ("state", "command", "picture")
FAILED = (
    zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
    | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
    | zmq.EVENT_HANDSHAKE_FAILED_AUTH
)

_Socket = zmq.Socket[bytes]


class StandIn:
    """Local planes of a central with a gateway, served until `close`.

    Each control message is answered with the User-Id of its sender.
    """

    def __init__(self, folder: Path, port: int = 0, *, serving: bool = True) -> None:
        self.context: zmq.Context[_Socket] = zmq.Context(io_threads=2)
        self.outside: zmq.Context[_Socket] = zmq.Context()
        self.keyring = Keyring(folder)
        self.now = 0.0
        self.logged: list[str] = []
        logger = logging.getLogger(f"gateway {folder}")
        logger.addHandler(_Collecting(self.logged))
        self.faults = FaultCounter(logger, lambda: self.now)
        self.zap = ZapHandler(self.context, self.faults)
        self.ended: list[int] = []
        self._stopping = threading.Event()
        self._outcomes = 0
        self._made: list[_Socket] = []
        self._steering: list[_Socket] = []
        self._threads = [self._proxy(plane) for plane in PLANES]
        try:
            self.gateway = self.open_gateway(port)
        except BaseException:
            self._close_local()
            raise
        self._serving = serving
        if serving:
            self._threads.append(threading.Thread(target=self._serve, name="stand-in"))
            self._threads[-1].start()

    def open_gateway(self, port: int) -> GatewaySockets:
        return GatewaySockets(
            self.context,
            TcpEndpoint("127.0.0.1", port),
            self.keyring,
            {plane: (f"inproc://{plane}-in", f"inproc://{plane}-out") for plane in PLANES},
            self.faults,
            make=lambda kind, _: self.bare(self.context, kind),
            accounts=Accounts(),
            clock=lambda: self.now,
            judge=lambda raw, _: raw,
            zap=self.zap,
        )

    def socket(self, context: zmq.Context[_Socket], kind: int) -> _Socket:
        """A socket that is closed at the end."""
        self._made.append(self.bare(context, kind))
        return self._made[-1]

    def bare(self, context: zmq.Context[_Socket], kind: int) -> _Socket:
        made = context.socket(kind)
        made.linger = 0
        made.reconnect_ivl = 20
        made.handshake_ivl = 3000  # as everywhere on the bus: one that hangs is tried again
        return made

    def keys(self, role: Role, name: str = "") -> ClientKeys:
        return read_client_keys(self.keyring.make(name or f"a-{role.value}", role))

    def port(self, place: str) -> int:
        if place == "control":
            return self.gateway.endpoint.port
        plane, _, way = place.partition(" ")
        return self.gateway.ports[PLANES.index(plane) * 2 + (way == "out")]

    def local(self, kind: int, place: str) -> _Socket:
        """A socket on this machine, without keys."""
        made = self.socket(self.context, kind)
        made.connect(f"inproc://{place.replace(' ', '-')}")
        return made

    def remote(self, kind: int, place: str, keys: ClientKeys | None) -> _Socket:
        """A socket on another machine."""
        made = self.socket(self.outside, kind)
        if keys is not None:
            keys.apply(made)
        made.connect(f"tcp://127.0.0.1:{self.port(place)}")
        return made

    def outcome(self, kind: int, place: str, keys: ClientKeys | None) -> str:
        """How the first handshake at this place ends: "in", "refused" or "nothing"."""
        made = self.bare(self.outside, kind)
        # Named by us: pyzmq makes the name of a descriptor, which may have been another's just now.
        self._outcomes += 1
        events = zmq.EVENT_HANDSHAKE_SUCCEEDED | FAILED
        monitor = made.get_monitor_socket(events, f"inproc://outcome-{self._outcomes}")
        try:
            if keys is not None:
                keys.apply(made)
            made.connect(f"tcp://127.0.0.1:{self.port(place)}")
            if not monitor.poll(10_000):
                return "nothing"
            event = zmq.utils.monitor.recv_monitor_message(monitor)["event"]
            return "in" if event == zmq.EVENT_HANDSHAKE_SUCCEEDED else "refused"
        finally:
            made.disable_monitor()  # else ZeroMQ can wait for ever with an event for it
            made.close()
            monitor.close()

    def close(self) -> None:
        self._stopping.set()
        if self._serving:
            self._threads.pop().join()
        self.gateway.close()
        self._close_local()

    def _close_local(self) -> None:
        for steering in self._steering:
            steering.send(b"TERMINATE")
        for thread in self._threads:
            thread.join()
        for made in self._made:
            made.close()
        self.zap.close()
        self.outside.term()  # hangs if a socket was left
        self.context.term()

    def _proxy(self, plane: str) -> threading.Thread:
        inward = self.socket(self.context, zmq.XSUB)
        outward = self.socket(self.context, zmq.XPUB)
        inward.bind(f"inproc://{plane}-in")
        outward.bind(f"inproc://{plane}-out")
        told = self.socket(self.context, zmq.PAIR)
        self._steering.append(self.socket(self.context, zmq.PAIR))
        told.bind(f"inproc://stand-in-{plane}")
        self._steering[-1].connect(f"inproc://stand-in-{plane}")

        def forward() -> None:
            zmq.proxy_steerable(inward, outward, None, told)

        thread = threading.Thread(target=forward, name=f"stand-in {plane}")
        thread.start()
        return thread

    def _serve(self) -> None:
        poller = zmq.Poller()
        for socket in (self.zap.socket, *self.gateway.polled, self.gateway.control):
            poller.register(socket, zmq.POLLIN)
        while not self._stopping.is_set():
            ready = dict(poller.poll(20))
            self.zap.serve()
            self.ended += self.gateway.serve(ready)
            if self.gateway.control in ready:
                sender, frame = self.gateway.control.recv_multipart(copy=False)
                user_id = frame.get("User-Id")
                assert isinstance(user_id, str)
                self.gateway.control.send_multipart([sender.bytes, user_id.encode()])


class _Collecting(logging.Handler):
    def __init__(self, lines: list[str]) -> None:
        super().__init__()
        self._lines = lines

    def emit(self, record: logging.LogRecord) -> None:
        self._lines.append(record.getMessage())


@contextmanager
def standing_in(folder: Path, port: int = 0, *, serving: bool = True) -> Iterator[StandIn]:
    """A stand-in that is closed at the end."""
    made = StandIn(folder, port, serving=serving)
    try:
        yield made
    finally:
        made.close()
