"""The planes of central: two sockets each, and ZeroMQ's proxy between them in a thread.

Commands are the exception: a Python thread checks the sender of each. Copies of all broadcasts go
to `copies`; central checks some of them.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Mapping

import zmq

from hub.errors import EndpointError, FrameError
from hub.ipc.broker import binding
from hub.ipc.broker.carrying import Judge, carry
from hub.ipc.broker.subscription_floods import FloodWatch
from hub.ipc.definition import Plane
from hub.ipc.endpoints import IpcEndpoint
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.sender_tickets import SenderTickets
from hub.ipc.wire import frames

_logger = logging.getLogger(__name__)

_COPIES = {Plane.STATE: 400, Plane.COMMAND: 400, Plane.PICTURE: 8}
"""Most broadcasts that wait for their check; each holds its memory until then."""


_CHECK_S, _FAULT_CHECK_S = 1e-3, 20e-3
"""Longest check of broadcasts: while all are right, and after a wrong one [s]."""


def inner_addresses(plane: Plane) -> tuple[str, str]:
    """The inproc addresses of a plane for gateways: in, out."""
    return f"inproc://{plane.value}-in", f"inproc://{plane.value}-out"


class PlaneProxies:
    """All planes; broadcasts pass from `start` to `stop`.

    Attributes:
        ends: The sockets to bind, by place: "state in", "state out", ...
        floods: Watches the subscribers of each plane, by place.
        copies: Copies of the broadcasts (SUB).
    """

    def __init__(
        self,
        context: sockets.Context,
        faults: FaultCounter,
        clock: Callable[[], float],
        tickets: SenderTickets,
    ) -> None:
        """Make the sockets.

        Args:
            context: Central's.
            faults: Counts floods of subscriptions, and malformed broadcasts.
            clock: Monotonic time [s].
            tickets: Check the senders of commands.
        """
        self._tickets = tickets
        self._context = context
        self._faults = faults
        self._clock = clock
        self.copies = sockets.make(context, zmq.SUB, 1)
        self.copies.subscribe(b"")
        self.ends: dict[str, sockets.Socket] = {}
        self.floods: dict[str, FloodWatch] = {}
        self._made: list[sockets.Socket] = []
        self._steering: list[sockets.Socket] = []
        self._threads: list[threading.Thread] = []
        self._stopping = threading.Event()
        self._more: dict[str, queue.SimpleQueue[tuple[sockets.Socket, IpcEndpoint]]] = {}
        for plane in sockets.PLANES:
            inward = sockets.make_plane(context, zmq.XSUB, plane)
            outward = sockets.make_plane(context, zmq.XPUB, plane)
            self._made += [inward, outward]
            # Gateways have checked their commands: they have a socket that no other can reach.
            checked = inward
            if plane is Plane.COMMAND:
                self._made.append(checked := sockets.make_plane(context, zmq.XSUB, plane))
            for end, address in zip((checked, outward), inner_addresses(plane), strict=True):
                end.bind(address)
            self.ends[f"{plane.value} in"] = inward
            self.ends[where := f"{plane.value} out"] = outward
            self.floods[where] = FloodWatch(outward, where, faults)
            forward = self._proxy(plane, inward, outward, checked)
            name = f"central-{plane.value}"
            self._threads.append(threading.Thread(target=forward, name=name, daemon=True))

    def start(self) -> None:
        """Forward broadcasts from now on."""
        for thread in self._threads:
            thread.start()

    def bind_more(self, addresses: Mapping[str, IpcEndpoint]) -> None:
        """Bind ends at further addresses, while broadcasts pass.

        Args:
            addresses: An address for each place.
        """
        for place, address in addresses.items():
            self._more[place.partition(" ")[0]].put((self.ends[place], address))
        for steering in self._steering:
            steering.send(b"TERMINATE", zmq.NOBLOCK)  # the proxy returns, and begins again

    def check(self, is_right: Callable[[frames.Frame], bool]) -> None:
        """Check broadcasts that have passed, and count faults.

        A check at once would wake central's thread, and take the processor from the receiver of the
        message. Under a flood, some broadcasts remain unchecked.

        Args:
            is_right: Counts the faults of a broadcast; whether it has none.
        """
        began, longest = self._clock(), _CHECK_S
        while self._clock() - began < longest:
            try:
                raw = self.copies.recv(zmq.NOBLOCK)
            except zmq.Again:
                return
            if raw[:1] in (b"\0", b"\1"):
                continue  # the proxy's own subscriptions pass here as well
            try:
                right = is_right(frames.unpack(raw))
            except FrameError as error:
                self._faults.count("malformed frame", str(error))
                right = False
            if not right:
                longest = _FAULT_CHECK_S

    def stop(self) -> None:
        """Stop forwarding; the threads end soon."""
        self._stopping.set()
        for steering in self._steering:
            steering.send(b"TERMINATE", zmq.NOBLOCK)

    def close(self) -> None:
        """Wait for the threads and close the sockets, except `copies`."""
        for thread in self._threads:
            thread.join()
        for socket in (*self._steering, *self._made):
            socket.close(0)

    def _admit(self, raw: bytes, frame: zmq.Frame) -> bytes | None:
        try:
            return self._tickets.admit(raw, frame)
        except Exception:  # a fault of the check must not end the thread: no stop would pass
            self._faults.count("internal fault", "the plane of commands goes on after it")
            if self._faults.counts["internal fault"] == 1:
                _logger.exception("the first internal fault")
            return None

    def _proxy(
        self,
        plane: Plane,
        inward: sockets.Socket,
        outward: sockets.Socket,
        checked: sockets.Socket,
    ) -> Callable[[], None]:
        """The function that forwards one plane until `stop`."""
        judges: dict[sockets.Socket, Judge] = {inward: self._admit, checked: lambda raw, _: raw}
        copies = sockets.make(self._context, zmq.PUB, _COPIES[plane])
        copies.bind(f"inproc://copies-{plane.value}")
        self.copies.connect(f"inproc://copies-{plane.value}")
        steered, steering = sockets.pair(self._context, f"inproc://steering-{plane.value}")
        self._made += [copies, steered]
        self._steering.append(steering)

        more = self._more[plane.value] = queue.SimpleQueue()

        def forward() -> None:
            while not self._stopping.is_set():
                if plane is Plane.COMMAND:
                    carry(judges, outward, steered, copies)
                else:
                    zmq.proxy_steerable(inward, outward, copies, steered)
                while not more.empty():  # the sockets are this thread's
                    end, address = more.get()
                    try:
                        binding.bind(end, address)
                    except EndpointError as error:
                        self._faults.count("cannot listen again", str(error))

        return forward
