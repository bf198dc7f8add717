"""Serves a simulated autopilot over TCP, UDP and pseudo terminals.

Nothing waits: a frame that cannot leave at once is dropped.
"""

from __future__ import annotations

import contextlib
import errno
import os
import selectors
import socket
import time
import tty
from collections.abc import Callable
from typing import Final

from hub.errors import AutopilotSettingError
from hub.robots.simulated_autopilot.autopilot import STEP, SimulatedAutopilot
from hub.robots.simulated_autopilot.station_link import StationLink

_LOOPBACK: Final = "127.0.0.1"
_AT_ONCE: Final = 1 << 16
_MOST_STATIONS: Final = 32


class _Channel:
    """The open end of one link."""

    def __init__(self, read: Callable[[], bytes], write: Callable[[bytes], int]) -> None:
        self.read, self._write = read, write
        self.link: StationLink | None = None
        self._kept = b""

    def send(self, frame: bytes) -> None:
        """Send a frame; one that cannot leave is dropped, unless its first part has left."""
        with contextlib.suppress(OSError):
            if self._kept:
                self._kept = self._kept[self._write(self._kept) :]
            if not self._kept:
                self._kept = frame[self._write(frame) :]


class AutopilotServer:
    """The links of one simulated autopilot; used by one thread.

    Attributes:
        addresses: Where stations find it, as addresses of a vehicle.
    """

    def __init__(
        self, autopilot: SimulatedAutopilot, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Serve a vehicle; it has no links yet.

        Args:
            autopilot: The vehicle.
            clock: The monotonic clock [s].
        """
        self._autopilot, self._clock = autopilot, clock
        self._selector = selectors.DefaultSelector()
        self._channels: dict[int, tuple[_Channel, Callable[[], None]]] = {}
        self._stations: set[int] = set()
        self._numbers = 0
        self._closing: list[Callable[[], None]] = []
        self.addresses: list[str] = []
        autopilot.on_restart(self._end_connections)

    def listen(self, port: int) -> None:
        """Take TCP connections at a port of loopback; 0: a free one.

        Raises:
            AutopilotSettingError: It is not free.
        """
        number = self._next_number()
        try:
            listener = socket.create_server((_LOOPBACK, port))
        except OSError as fault:
            taken = fault.errno == errno.EADDRINUSE
            why = "another program listens there" if taken else fault.strerror
            reason = f"this TCP port cannot be used: {why}; give another one with --tcp, or --tcp 0"
            raise AutopilotSettingError(str(port), reason) from fault
        listener.settimeout(0.0)
        self._closing.append(listener.close)
        self._selector.register(
            listener, selectors.EVENT_READ, lambda: self._accept(listener, number)
        )
        self.addresses.append(f"tcp://{_LOOPBACK}:{listener.getsockname()[1]}")

    def send_to(self, host: str, port: int) -> None:
        """Send datagrams to a station first, as a vehicle with a radio link does.

        Raises:
            AutopilotSettingError: The station's name is not known.
        """
        try:
            family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
            link = socket.socket(family, kind)
            link.connect(address)
        except OSError as fault:
            reason = f"nothing can be sent there: {fault.strerror}"
            place = f"{host}:{port}"
            raise AutopilotSettingError(place, reason) from fault
        link.settimeout(0.0)
        channel = _Channel(lambda: link.recv(_AT_ONCE), link.send)
        self._add(link.fileno(), channel, link.close, self._next_number(), datagrams=True)
        self.addresses.append(f"udp://{host}:{port}")

    def open_terminal(self) -> None:
        """Open a pseudo terminal, which stations use as a serial port."""
        ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(ours, False)
        path = os.ttyname(theirs)
        channel = _Channel(lambda: os.read(ours, _AT_ONCE), lambda data: os.write(ours, data))
        self._closing.append(lambda: os.close(theirs))
        self._add(ours, channel, lambda: os.close(ours), self._next_number())
        self.addresses.append(path)

    def watch(self, file: int, act: Callable[[], None]) -> None:
        """Call this when a file can be read."""
        self._selector.register(file, selectors.EVENT_READ, act)

    def serve_once(self) -> None:
        """Wait for data, a step long at most; take them, and let time pass."""
        for key, _ in self._selector.select(STEP / 4.0):
            key.data()
        self._autopilot.step(self._clock())

    def close(self) -> None:
        """Close all links."""
        for file in list(self._channels):
            self._remove(file)
        for close in self._closing:
            close()
        self._selector.close()

    def _next_number(self) -> int:
        self._numbers += 1
        return self._numbers - 1

    def _accept(self, listener: socket.socket, number: int) -> None:
        try:
            station, _ = listener.accept()
        except OSError:
            return
        if len(self._stations) >= _MOST_STATIONS:
            station.close()
            return
        station.settimeout(0.0)
        station.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

        def read() -> bytes:
            data = station.recv(_AT_ONCE)
            if not data:
                raise ConnectionResetError
            return data

        self._stations.add(station.fileno())
        self._add(station.fileno(), _Channel(read, station.send), station.close, number)

    def _add(
        self,
        file: int,
        channel: _Channel,
        close: Callable[[], None],
        number: int,
        *,
        datagrams: bool = False,
    ) -> None:
        channel.link = self._autopilot.connect(channel.send, number, datagrams=datagrams)
        self._channels[file] = channel, close
        self._selector.register(file, selectors.EVENT_READ, lambda: self._read(file))

    def _read(self, file: int) -> None:
        if file not in self._channels:
            return
        channel = self._channels[file][0]
        try:
            data = channel.read()
        except BlockingIOError:
            return
        except OSError as fault:
            # A UDP station that does not listen yet, or a terminal that no station has open.
            if file in self._stations or fault.errno not in (errno.ECONNREFUSED, errno.EIO):
                self._remove(file)
            return
        if channel.link is not None:
            self._autopilot.received(channel.link, data)

    def _remove(self, file: int) -> None:
        channel, close = self._channels.pop(file)
        self._stations.discard(file)
        self._selector.unregister(file)
        if channel.link is not None:
            self._autopilot.disconnect(channel.link)
        close()

    def _end_connections(self) -> None:
        for file in list(self._stations):
            self._remove(file)
