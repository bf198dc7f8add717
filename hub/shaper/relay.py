"""The relay: carries TCP connections between clients and a hub as a `LinkModel` says.

It knows bytes only, so encrypted connections pass as well. It waits with timers of less than a
millisecond, and holds little: a full link is not read from, so TCP slows the senders down.

| event | action |
| --- | --- |
| a client connects | that goes up; then the relay connects to the hub, and the answer goes down |
| data arrive at a socket | they enter the link, if it has room; else they wait in the socket |
| data leave the link | they are written to the other socket |
| a side ends its data | the end follows them through the link |
| a connection breaks | that goes through the link too; then the other socket is closed |
| too many connections | the new one is closed and counted |
"""

from __future__ import annotations

import selectors
import socket
import time
from collections.abc import Callable, Sequence

from hub.errors import EndpointError
from hub.shaper.carried import (
    SEGMENT,
    WINDOW,
    Carried,
    Content,
    LinkEnd,
    Mark,
    begin_connection,
    make_small,
)
from hub.shaper.model import Delivery, LinkDirection, LinkModel
from hub.shaper.profile import LinkProfile

MOST_CONNECTIONS = 200
"""Most connections at once; `select` takes 1024 descriptors."""
_LARGEST_PIECE = 65_536
_PIECE_S = 0.001
_FAST = 20e6
"""From this rate on, small buffers would only make TCP pause [bit/s]."""
_MARK_BYTES = 0
_OPEN_AGAIN_S = 1.0
"""Clients of the bus give up a connection that is not made, and begin another [s]."""
_LONGEST_WAIT_S = 0.5
_LISTENING = "listening"


class Relay:
    """Relays connections until it is closed.

    Attributes:
        address: Where it listens.
        model: The link.
        ports: Its ports, in the order of the hub's addresses.
        started: When its conditions began, on the clock [s].
        refused: Connections that were one too many.
    """

    def __init__(
        self,
        address: str,
        hub: Sequence[tuple[str, int]],
        profile: LinkProfile,
        seed: int,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Listen at the hub's ports at another address.

        Args:
            address: Of this machine; the relay connects to a hub on this machine from there too.
            hub: The hub's addresses.
            profile: How the link behaves.
            seed: Which of its courses.
            clock: Monotonic time [s].

        Raises:
            EndpointError: A port is busy there, or this machine has no such address.
        """
        self.address = address
        self.model: LinkModel[Content] = LinkModel(profile, seed)
        self.ports = tuple(port for _, port in hub)
        self.refused = 0
        self._hub = hub
        self._clock = clock
        self._small = min(profile.up.rate, profile.down.rate) < _FAST
        self.started = clock()
        self._carried: dict[int, Carried] = {}
        self._numbers: dict[LinkEnd, int] = {}
        self._next = 0
        self._selector = selectors.SelectSelector()  # its time-outs are finer than those of epoll
        self._listening: list[socket.socket] = []
        try:
            for place, (_, port) in enumerate(hub):
                self._listening.append(socket.create_server((address, port)))
                self._listening[-1].settimeout(0.0)
                if self._small:
                    make_small(self._listening[-1])
                self._selector.register(
                    self._listening[-1], selectors.EVENT_READ, (_LISTENING, place)
                )
        except OSError as error:
            self.close()
            text = f"the link shaper cannot listen at {address}:{port}: "
            text += f"{error.strerror}; name another address of this machine, such as 127.0.0.9"
            raise EndpointError(text) from error

    @property
    def connections(self) -> int:
        """How many there are."""
        return len(self._carried)

    def held(self) -> tuple[int, int]:
        """Content in the link, up and down [bytes]."""
        carried = list(self._carried.values())
        up = sum(each.near.held for each in carried)
        return up, sum(each.far.held for each in carried if each.far is not None)

    def run(self, ended: Callable[[], bool]) -> None:
        """Relay until `ended`, which is asked twice a second at least."""
        while not ended():
            self.turn(_LONGEST_WAIT_S)

    def turn(self, longest: float) -> None:
        """Wait for the next event, for `longest` at most [s], and handle all that are due."""
        now = self._now()
        for direction in (self.model.up, self.model.down):
            for delivery in direction.take(now):
                if delivery.stream in self._carried:
                    self._deliver(direction, delivery, now)
        due = self._watch_all(now)
        ready = self._selector.select(max(0.0, min(longest, due - now)))
        now = self._now()
        # A direction may have room for one of them only: each gets its turn.
        ready.sort(key=lambda found: getattr(found[0].data, "served", 0.0))
        for key, events in ready:
            if isinstance(key.data, LinkEnd):
                self._serve(key.data, events, now)
            else:
                self._accept(key.fileobj, key.data[1], now)  # type: ignore[arg-type]

    def close(self) -> None:
        """Close all connections."""
        for number in list(self._carried):
            self._end(number)
        for each in self._listening:
            each.close()
        self._selector.close()

    def _now(self) -> float:
        return self._clock() - self.started

    def _watch_all(self, now: float) -> float:
        """Watch all sockets; returns when something is due without any of them [s]."""
        up, down = self.model.up.room_at(now), self.model.down.room_at(now)
        for number, carried in self._carried.items():
            self._watch(carried.near, room=up <= now and self.model.up.takes(number))
            if carried.far is not None:
                self._watch(carried.far, room=down <= now and self.model.down.takes(number))
        rooms = (room for room in (up, down) if room > now)
        return min(self.model.up.due, self.model.down.due, *rooms)

    def _watch(self, end: LinkEnd, *, room: bool) -> None:
        """Have the selector wait for what this socket may do."""
        reads, writes = room and end.reads, end.writes
        events = reads * selectors.EVENT_READ | writes * selectors.EVENT_WRITE
        if events == end.events or end.broken:
            return
        if not events:
            self._selector.unregister(end.socket)
        elif end.events:
            self._selector.modify(end.socket, events, end)
        else:
            self._selector.register(end.socket, events, end)
        end.events = events

    def _accept(self, listening: socket.socket, place: int, now: float) -> None:
        try:
            near, _ = listening.accept()
        except OSError:  # it has gone already
            return
        if len(self._carried) >= MOST_CONNECTIONS:
            self.refused += 1
            near.close()
            return
        self._next += 1
        self._carried[self._next] = Carried(self._end_of(near), place)
        self._numbers[self._carried[self._next].near] = self._next
        self.model.up.send(self._next, Mark.OPEN, _MARK_BYTES, now, _OPEN_AGAIN_S)

    def _end_of(self, own: socket.socket, *, connecting: bool = False) -> LinkEnd:
        direction = self.model.down if connecting else self.model.up
        window = max(WINDOW, direction.conditions.spec.queue)
        return LinkEnd(own, window, connecting=connecting)

    def _serve(self, end: LinkEnd, events: int, now: float) -> None:
        number = self._numbers.get(end)
        if number is None:  # it ended in this turn
            return
        carried = self._carried[number]
        direction = self.model.up if end is carried.near else self.model.down
        if end.connecting:
            self._connected(carried, number, end, now)
            return
        try:
            if events & selectors.EVENT_WRITE:
                self._written(carried, end, end.write())
            if events & selectors.EVENT_READ and direction.room_at(now) <= now:
                self._read(direction, number, end, now)
        except OSError:
            self._broke(direction, number, end, now)
        self._end_if_finished(number)

    def _connected(self, carried: Carried, number: int, end: LinkEnd, now: float) -> None:
        """The connection to the hub is made, or refused."""
        end.connecting = False
        if end.failure():
            self._drop(end)
            carried.far = None
        else:
            end.open = True
        answer = Mark.OPEN if end.open else Mark.RESET
        self.model.down.send(number, answer, _MARK_BYTES, now, _OPEN_AGAIN_S)

    def _read(
        self, direction: LinkDirection[Content], number: int, end: LinkEnd, now: float
    ) -> None:
        data = end.read(self._piece(direction))
        end.served = now
        if data:
            end.held += len(data)
            direction.send(number, data, len(data), now)
        elif data is not None:
            direction.send(number, Mark.END, _MARK_BYTES, now)

    def _piece(self, direction: LinkDirection[Content]) -> int:
        """Largest packet: a segment of TCP, more on fast links without losses [bytes]."""
        spec = direction.conditions.spec
        return (
            SEGMENT
            if spec.loss
            else min(_LARGEST_PIECE, max(SEGMENT, int(spec.rate * _PIECE_S / 8.0)))
        )

    def _broke(
        self, direction: LinkDirection[Content], number: int, end: LinkEnd, now: float
    ) -> None:
        """One socket is gone; the other side learns it through the link."""
        self._drop(end)
        end.ended = True
        other = self.model.down if direction is self.model.up else self.model.up
        other.forget(number)
        direction.send(number, Mark.RESET, _MARK_BYTES, now)

    def _deliver(
        self, direction: LinkDirection[Content], delivery: Delivery[Content], now: float
    ) -> None:
        number, content = delivery.stream, delivery.content
        carried = self._carried[number]
        up = direction is self.model.up
        end = carried.far if up else carried.near
        try:
            if content is Mark.OPEN:
                self._open(carried, number, up=up)
            elif content is Mark.RESET or end is None:
                self._end(number)
            elif end.broken:
                self._written(carried, end, delivery.size)
            elif content is Mark.END:
                end.end_writing()
            elif isinstance(content, bytes):
                self._written(carried, end, end.write(content))
        except OSError:
            if end is None:
                self._end(number)
            else:
                self._broke(self.model.down if up else self.model.up, number, end, now)
        self._end_if_finished(number)

    def _open(self, carried: Carried, number: int, *, up: bool) -> None:
        if not up:
            carried.near.open = True
            return
        address = self._hub[carried.place]
        source = self.address if address[0].startswith("127.") else ""
        made = begin_connection(address, source, small=self._small)
        carried.far = self._end_of(made, connecting=True)
        self._numbers[carried.far] = number

    def _written(self, carried: Carried, end: LinkEnd, count: int) -> None:
        """Free the window of the other socket, where these bytes come from."""
        source = carried.near if end is carried.far else carried.far
        if source is not None:
            source.held -= count

    def _end_if_finished(self, number: int) -> None:
        carried = self._carried.get(number)
        if carried is not None and all(each.finished for each in carried.ends):
            self._end(number)

    def _drop(self, end: LinkEnd) -> None:
        """Close a socket."""
        if end.events:
            self._selector.unregister(end.socket)
        end.events, end.broken, end.connecting = 0, True, False
        end.socket.close()
        self._numbers.pop(end, None)

    def _end(self, number: int) -> None:
        """Close a connection, and drop what is on its way."""
        carried = self._carried.pop(number)
        for each in carried.ends:
            self._drop(each)
        for direction in (self.model.up, self.model.down):
            direction.forget(number)
