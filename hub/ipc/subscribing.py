"""The receiving side of a client's broadcasts: an inlet for each message it subscribes to."""

from __future__ import annotations

import functools
from collections import OrderedDict, deque
from collections.abc import Sequence
from typing import Any

import zmq

from hub.errors import CodecError, FrameError
from hub.ipc import control, frames, publishing, ring, sockets
from hub.ipc.complaints import Complaints
from hub.ipc.connection import Connection
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.inbox import Inbox
from hub.ipc.inlet import Arrival, Handler, Inlet, Source
from hub.ipc.loop import Loop
from hub.ipc.reception import Reception

_BATCH = 256
_SLICE_S = 0.005
"""After so long of handling, what has come meanwhile is looked at: it may be more urgent [s]."""
_MAX_RINGS = 8


def _topics(name: str) -> list[bytes]:
    """What stands before the NUL of a frame of this message."""
    return [frames.topic(name, kind)[:-1] for kind in (b"", frames.FAR, frames.RING)]


_new = tuple.__new__


class _Opened:
    """Messages of one publisher on their way to the handlers.

    Attributes:
        messages: Stamp [ns] and payload, or the numbers of a flat format, of each that is left.
        sequence: Number of the next.
        accepted: Whether their numbers were looked at before.
    """

    __slots__ = ("accepted", "inlet", "kind", "messages", "publisher", "sequence", "source")

    def __init__(self, inlet: Inlet, arrival: Arrival, *, accepted: bool = False) -> None:
        self.inlet: Inlet | None = inlet
        self.publisher, self.sequence, self.kind, messages = arrival
        self.source = inlet.source(self.publisher)
        self.messages = iter(messages)
        self.accepted = accepted


class Inlets:
    """All inlets of one client, and the sockets they share.

    Attributes:
        pending: Whether messages wait that were taken from the sockets.
    """

    def __init__(
        self,
        context: sockets.Context,
        loop: Loop,
        connection: Connection,
        complaints: Complaints,
    ) -> None:
        self._context = context
        self._loop = loop
        self._connection = connection
        self._hub_time = connection.hub_time
        self._clock = loop.clock
        self._complaints = complaints
        self._sockets: dict[Plane, sockets.Socket] = {}
        self._files: dict[Plane, int] = {}
        self._inboxes: dict[Plane, Inbox] = {}
        self._inlets: dict[str, Inlet] = {}
        self._topics: dict[bytes, Inlet] = {}
        self._under_way: dict[str, Inlet] = {}
        self._tokens = 0
        self._waits = 0
        self._opened: list[_Opened] = []
        self._carriages: deque[bytes] = deque()
        self._queues: dict[int, deque[_Opened]] = {0: deque()}
        self._rings: OrderedDict[tuple[int, int, int], ring.RingReader] = OrderedDict()
        self._near = False
        self._where: dict[Plane, str] = {}

    @property
    def pending(self) -> bool:
        """Whether messages were taken from the sockets and not handed on yet."""
        return self._waits > 0 or bool(self._opened) or bool(self._carriages)

    @property
    def standing(self) -> bool:
        """Whether every subscription has reached everybody who publishes its message."""
        return bool(self._sockets) and not self._under_way

    def connect(self, addresses: Sequence[str], *, near: bool, same_run: bool) -> None:
        """Connect to a central that does not know us: where each plane comes out."""
        self.disconnect()
        self._near = near
        self._where = dict(zip(sockets.PLANES, addresses, strict=True))
        # Commands first: they must not wait behind a burst of states.
        for plane in (Plane.COMMAND, Plane.STATE, Plane.PICTURE):
            self._connect(plane)
        for inlet in self._inlets.values():
            if not same_run:  # else what was missed meanwhile shows in the numbers
                inlet.forget()
            inlet.in_ring = self._may_ring(inlet.definition)

    def drop_pictures(self) -> None:
        """Connect the plane of pictures anew: what lies there is old."""
        if Plane.PICTURE in self._sockets:
            self._disconnect(Plane.PICTURE)
            self._connect(Plane.PICTURE)
            for inlet in self._inlets.values():
                if inlet.definition.plane is Plane.PICTURE:
                    self._ask_for(inlet)

    def _connect(self, plane: Plane) -> None:
        socket = sockets.make_plane(self._context, zmq.SUB, plane, self._connection.keys)
        sockets.connect(socket, self._where[plane])
        self._sockets[plane] = socket
        self._files[plane] = self._loop.register(socket, functools.partial(self._take, socket))
        if self._near:
            self._inboxes[plane] = Inbox(self._context, self._loop, plane, self._take)

    def subscribe_all(self) -> None:
        """Subscribe anew, at a central that knows the definitions now."""
        for inlet in self._inlets.values():
            self._ask_for(inlet)

    def disconnect(self) -> None:
        """Central is gone; what was taken is still handed on."""
        for plane in tuple(self._sockets):
            self._disconnect(plane)
        self._under_way.clear()
        while self._rings:
            self._rings.popitem()[1].close()

    def _disconnect(self, plane: Plane) -> None:
        self._loop.unregister(self._files[plane])
        self._sockets.pop(plane).close(0)
        inbox = self._inboxes.pop(plane, None)
        if inbox is not None:
            inbox.close()

    def subscribe(
        self,
        definition: MessageDefinition[Any],
        handler: Handler,
        *,
        raw: bool = False,
        queue: int | None = None,
        priority: int | None = None,
    ) -> Inlet:
        """Hand every message of `definition` to `handler` too."""
        inlet = self._inlets.get(definition.name)
        new = inlet is None
        if inlet is None:
            inlet = self._inlets[definition.name] = Inlet(definition)
            inlet.in_ring = self._may_ring(definition)
            for topic in _topics(definition.name):
                self._topics[topic] = inlet
        inlet.add(handler, raw=raw)
        if queue is not None:
            inlet.limit = queue
        if priority is not None:
            inlet.priority = priority
            self._queues.setdefault(priority, deque())
            self._queues = dict(sorted(self._queues.items(), reverse=True))
        if new and self._connection.publisher:
            self._ask_for(inlet)
        return inlet

    def unsubscribe(self, name: str, handler: Handler | None) -> None:
        """Hand the message to `handler` no longer, or to nobody; what waits is not handed on."""
        inlet = self._inlets.get(name)
        if inlet is None:
            return
        inlet.handlers = [each for each in inlet.handlers if handler not in (None, each[0])]
        if inlet.handlers:
            return
        del self._inlets[name]
        for topic in _topics(name):
            del self._topics[topic]
        if self._sockets:
            self._filter(inlet, on=False)
            self._stands(inlet.token)
            self._connection.tell(control.Unsubscribe(name=name))

    def subscribed(self, message: control.Subscribed) -> None:
        """Central says that a subscription stands."""
        self._stands(message.token)

    def reports(self) -> tuple[control.Received, ...]:
        """What came to each inlet since the last time."""
        made = (inlet.report() for inlet in self._inlets.values())
        return tuple(report for report in made if report is not None)

    def turn(self) -> None:
        """Hand on what waits."""
        self._finish()
        if self._waits:
            self._hand_on()

    def _finish(self) -> None:
        """Hand on what was begun: a handler that raised or listened itself has left it so."""
        while self._opened:
            self._hand_out(self._opened[-1])
        while self._carriages:
            self._take_frame(self._carriages.popleft())

    def accept(self, frame: frames.Frame) -> None:
        """Hand on a message that came another way, such as the last value that was asked for."""
        inlet = self._inlets.get(frame.name)
        if inlet is None:
            return
        inbox = self._inbox(inlet)
        if inbox is not None:
            # What was sent before has come by now, and would be taken for repeated behind this.
            inbox.take()
        source = inlet.source(frame.publisher)
        if frame.sequence <= source.arrived:
            return
        source.arrived = frame.sequence
        self._deliver(
            inlet,
            source,
            frame.kind,
            frame.publisher,
            frame.sequence,
            frame.stamp_ns,
            frame.payload,
        )

    def _ask_for(self, inlet: Inlet) -> None:
        """Subscribe, and have central say when nothing can be missed any more."""
        definition = inlet.definition
        self._under_way.pop(inlet.token, None)
        self._tokens += 1
        inlet.token = f"{self._connection.publisher}.{self._tokens}"
        self._under_way[inlet.token] = inlet
        self._filter(inlet, on=True)
        inbox = self._inbox(inlet)
        self._connection.tell(
            control.Subscribe(
                name=definition.name,
                token=inlet.token,
                inbox=inbox.address if inbox else "",
                in_ring=inlet.in_ring,
            )
        )
        if not self._connection.may_publish(definition.plane):
            # Who only listens cannot see its own mark come back.
            self._connection.tell(control.Ready(token=inlet.token))

    def _inbox(self, inlet: Inlet) -> Inbox | None:
        return self._inboxes.get(Plane.STATE if inlet.in_ring else inlet.definition.plane)

    def _stands(self, token: str) -> None:
        """The mark of a subscription has done its work."""
        inlet = self._under_way.pop(token, None)
        if inlet is not None:
            inlet.token = ""
            plane = inlet.definition.plane
            for topic in self._filters(inlet):
                self._sockets[plane].unsubscribe(publishing.mark(topic, token))
            self._loop.touch(self._files[plane])

    def _may_ring(self, definition: MessageDefinition[Any]) -> bool:
        return self._near and ring.available and definition.plane is Plane.PICTURE

    def _filter(self, inlet: Inlet, *, on: bool) -> None:
        plane = inlet.definition.plane
        socket = self._sockets[plane]
        self._loop.touch(self._files[plane])
        change = socket.subscribe if on else socket.unsubscribe
        for topic in self._filters(inlet):
            change(topic)
            if on:
                socket.subscribe(publishing.mark(topic, inlet.token))

    def _filters(self, inlet: Inlet) -> list[bytes]:
        """What comes from central: what neighbours send only if we are none."""
        kinds = (frames.FAR,) if self._near else (frames.FAR, b"")
        return [frames.topic(inlet.definition.name, kind) for kind in kinds]

    def _go_plain(self, inlet: Inlet, why: str) -> None:
        """Ask for the payloads themselves from now on."""
        if inlet.in_ring and self._sockets:
            self._complaints.count("no shared memory", f"{inlet.definition.name}: {why}")
            self._stands(inlet.token)
            self._filter(inlet, on=False)
            inlet.in_ring = False
            self._ask_for(inlet)

    def _take(self, socket: sockets.Socket) -> bool:
        """Take a batch from a socket; whether there may be more.

        What is kept in full and has no priority is handed on as it is read, as long as nothing
        waits; all else when everything was read, since something newer or more urgent may come.
        """
        self._finish()
        receive = socket.recv
        end = self._clock() + _SLICE_S
        for _ in range(_BATCH):
            try:
                raw = receive(zmq.NOBLOCK)
            except zmq.Again:
                return False
            if frames.is_train(raw):
                self._take_train(raw)
            else:
                self._take_frame(raw)
            if self._clock() > end:
                return True
        return True

    def _take_train(self, raw: bytes) -> None:
        try:
            carriages = frames.carriages(raw)
        except FrameError as error:
            self._complaints.count("malformed frame", str(error))
            return
        self._carriages += carriages
        self._finish()

    def _take_frame(self, raw: bytes) -> None:
        inlet = self._topics.get(raw[: raw.find(b"\0")])
        if inlet is None:
            self._strange(raw)
            return
        at_once = inlet.limit is None and inlet.priority == 0 and not self._waits
        if at_once and inlet.flat is not None and (found := inlet.flat.unpack(raw)):
            _, publisher, _, sequence, stamp_ns, _ = found[:6]
            source = inlet.source(publisher)
            if self._arrived(inlet, source, sequence):
                self._deliver(
                    inlet, source, frames.INLINE, publisher, sequence, stamp_ns, found[6:]
                )
            return
        try:
            arrival = inlet.read(raw)
        except FrameError as error:
            self._complaints.count("malformed frame", str(error))
        except CodecError as error:
            self._complaints.count("wrong format", str(error))
        else:
            if at_once:
                self._opened.append(_Opened(inlet, arrival))
                self._hand_out(self._opened[-1])
            else:
                self._put(inlet, arrival)

    def _put(self, inlet: Inlet, arrival: Arrival) -> None:
        """Let messages wait; a limit lets the oldest of their publisher go."""
        publisher, sequence, kind, messages = arrival
        source = inlet.source(publisher)
        for number, message in enumerate(messages, sequence):
            if not self._arrived(inlet, source, number):
                continue
            waiting = _Opened(inlet, Arrival(publisher, number, kind, [message]), accepted=True)
            if inlet.limit is not None:
                if len(source.waiting) >= inlet.limit:
                    source.waiting.popleft().inlet = None
                source.waiting.append(waiting)
            self._queues[inlet.priority].append(waiting)
            self._waits += 1

    def _arrived(self, inlet: Inlet, source: Source, sequence: int) -> bool:
        """Whether a message of this number may be handed on; a gap before it is counted."""
        last = source.arrived
        if not source.accepts(sequence):
            detail = f"{inlet.definition.name} {sequence} after {last}"
            self._complaints.count("out of order", detail)
            return False
        if source.arrived:
            inlet.lost += sequence - source.arrived - 1
        source.arrived = sequence
        return True

    def _strange(self, raw: bytes) -> None:
        """A frame that is none of ours, or came after it was unsubscribed."""
        try:
            frames.unpack(raw)
        except FrameError as error:
            self._complaints.count("malformed frame", str(error))

    def _hand_on(self) -> None:
        """Hand on what waits, most urgent first; after a while, look what has come meanwhile."""
        end = self._clock() + _SLICE_S
        for queue in self._queues.values():
            while queue:
                waiting = queue.popleft()
                self._waits -= 1
                if waiting.inlet is None:
                    continue  # a newer one came
                if waiting.source.waiting and waiting.source.waiting[0] is waiting:
                    waiting.source.waiting.popleft()
                self._opened.append(waiting)
                self._hand_out(waiting)
                if self._clock() > end:
                    return

    def _hand_out(self, opened: _Opened) -> None:
        """Hand messages to their handlers; after one that raises, the rest comes later."""
        inlet, source, publisher, kind = opened.inlet, opened.source, opened.publisher, opened.kind
        if inlet is None:
            return
        for stamp_ns, message in opened.messages:
            sequence = opened.sequence
            opened.sequence = sequence + 1
            if not opened.accepted:
                if sequence == source.arrived + 1 and sequence != 1:
                    source.arrived = sequence
                elif not self._arrived(inlet, source, sequence):
                    continue
            self._deliver(inlet, source, kind, publisher, sequence, stamp_ns, message)
        if opened in self._opened:  # not if a handler listened, and so had the rest handed out
            self._opened.remove(opened)

    def _deliver(
        self,
        inlet: Inlet,
        source: Source,
        kind: int,
        publisher: int,
        sequence: int,
        stamp_ns: int,
        message: Any,
    ) -> None:
        """Hand one message to its handlers, unless it is too old or cannot be read."""
        now = self._clock()
        measured = stamp_ns * 1e-9 - self._hub_time.offset
        age = now - measured
        if age < 0.0:
            age, measured = 0.0, now
        if age > inlet.oldest:
            inlet.oldest = age
        if age > inlet.lifespan_s:
            inlet.expired += 1
            self._complaints.count("too old", f"{inlet.definition.name} is {age:.2f} s old")
            return
        if message.__class__ is tuple and inlet.build is not None:
            value = inlet.build(message)
        else:
            message, value = self._decoded(inlet, kind, message)
            if message is None:
                return
        missed = sequence - source.handed_on - 1 if source.handed_on else 0
        source.handed_on = sequence
        inlet.received += 1
        how = _new(Reception, (publisher, sequence, missed, age, measured))
        handlers = inlet.handlers
        for each in handlers:
            if handlers is inlet.handlers or each in inlet.handlers:  # one may unsubscribe another
                handler, raw = each
                handler(message if raw else value, how)

    def _decoded(self, inlet: Inlet, kind: int, message: Any) -> tuple[Any, Any]:
        """The payload and its value; None twice if it is not there or is none."""
        try:
            payload = self._payload(inlet, kind, message)
            return payload, None if payload is None else inlet.definition.decode(payload)
        except (CodecError, FrameError) as error:
            self._complaints.count("wrong format", str(error))
            return None, None

    def _payload(self, inlet: Inlet, kind: int, payload: memoryview) -> memoryview | None:
        """The payload itself; None if it is not there any more."""
        if kind == frames.INLINE:
            return payload
        if kind == frames.NO_RING:
            self._go_plain(inlet, "its publisher has none")
            return None
        place = ring.Place.unpack(payload)
        try:
            found = self._ring(place).read(place)
        except OSError as error:
            self._go_plain(inlet, str(error))
            return None
        if found is None:
            inlet.lost += 1
            self._complaints.count("overwritten", f"{inlet.definition.name}: read too late")
        return found

    def _ring(self, place: ring.Place) -> ring.RingReader:
        key = (place.process, place.file, place.ring)
        reader = self._rings.get(key)
        if reader is None:
            reader = self._rings[key] = ring.RingReader(place)
            if len(self._rings) > _MAX_RINGS:
                self._rings.popitem(last=False)[1].close()
        return reader
