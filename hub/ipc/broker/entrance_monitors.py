"""What ZeroMQ reports of the connections to central's own sockets."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

import zmq

from hub.ipc.broker.subscription_floods import FloodWatch
from hub.ipc.broker.unfinished_handshakes import UnfinishedHandshakes
from hub.ipc.roles import CONTROL
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.file_descriptors import Reserve
from hub.ipc.transport.loop import Loop

_FAILURES = (
    zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL,
    zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL,
    zmq.EVENT_HANDSHAKE_FAILED_AUTH,
)
_WATCHED = (
    zmq.EVENT_ACCEPTED | zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED | sum(_FAILURES)
)


class EntranceMonitors:
    """Counts bad handshakes, and reports connections that begin and end."""

    def __init__(
        self,
        ends: Mapping[str, sockets.Socket],
        floods: Mapping[str, FloodWatch],
        *,
        disconnected: Callable[[int], None],
        faults: FaultCounter,
        clock: Callable[[], float],
    ) -> None:
        """Watch from now on.

        Args:
            ends: Central's sockets, by place: "control", "state in", ...
            floods: Watches the subscribers of places.
            disconnected: Gets the descriptor of each control connection that ends.
            faults: Counts bad handshakes.
            clock: Monotonic time [s].
        """
        self._floods = floods
        self._disconnected = disconnected
        self._faults = faults
        self._reserve = Reserve(faults)
        self._monitors = {place: end.get_monitor_socket(_WATCHED) for place, end in ends.items()}
        self._handshakes = {place: UnfinishedHandshakes(clock) for place in ends}

    def register(self, loop: Loop) -> None:
        """Let a loop serve them."""
        for place, monitor in self._monitors.items():
            loop.register(monitor, functools.partial(self._read, place))

    def read_ended(self) -> None:
        """Read the pending ends of control connections."""
        self._read(CONTROL)

    def close(self) -> None:
        """Close the monitors, before the sockets that they watch."""
        for monitor in self._monitors.values():
            monitor.close(0)

    def _read(self, place: str) -> bool:
        monitor, handshakes = self._monitors[place], self._handshakes[place]
        floods = self._floods.get(place)
        while True:
            try:
                raw = monitor.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return False
            event, descriptor = sockets.parse_event(raw)
            if event == zmq.EVENT_ACCEPTED:
                handshakes.accepted(descriptor)
                self._reserve.admit(descriptor, place)
                if floods is not None:
                    floods.connected(descriptor)
            elif event != zmq.EVENT_DISCONNECTED:
                handshakes.decided()
                if event in _FAILURES:
                    self._bad_handshake(place)
            else:
                for _ in range(handshakes.ended(descriptor)):
                    self._bad_handshake(place)
                if floods is not None:
                    floods.disconnected(descriptor)
                elif place == CONTROL:
                    self._disconnected(descriptor)

    def _bad_handshake(self, place: str) -> None:
        self._faults.count(
            f"bad handshake on {place}",
            "a peer left in the middle of it, or does not speak this protocol",
        )
