"""A link that carries streams of TCP: from when and how much is sent to when it arrives; pure.

All streams of a direction share one radio, in the order in which they send. A stream keeps its
order: a lost packet holds up all that follow it in its stream until it is sent again and
arrives. That is what loss means over TCP.

| a lost packet is sent again | when |
| --- | --- |
| a later packet of its stream arrives | one mean delay back after that |
| none does | after the mean round trip and 4 jitters, or 0.2 s; each time after twice that |

A stream sends as many packets at once as its `CongestionWindow` allows; an answer to each comes
back after the mean delay. Not modelled: answers as traffic.
"""

from __future__ import annotations

import collections
import heapq
import math
from dataclasses import field
from typing import Generic, TypeVar

from hub.shaper.conditions import DirectionConditions
from hub.shaper.congestion import CongestionWindow
from hub.shaper.profile import LinkProfile
from hub.values import dataclass

P = TypeVar("P")

HEADERS = 52
"""IP and TCP with time stamps [bytes]."""
_LEAST_MARGIN_S, _JITTERS = 0.2, 4.0
_LONGEST_RETRY_S = 60.0


@dataclass(slots=True)
class _Packet(Generic[P]):
    """A packet on its way.

    Attributes:
        content: What it carries.
        size: Of that [bytes].
        began: When it came to the link [s].
        sent: When it left last [s].
        due: When it arrives, or is sent again if it is lost [s].
        longest: Longest pause before it is sent again [s].
        tries: How often it was lost.
        lost: Whether it waits to be sent again.
        shown: Whether a later packet showed that it is lost.
        arrived: Whether it waits only for those before it.
    """

    content: P
    size: int
    began: float
    longest: float
    sent: float = 0.0
    due: float = 0.0
    tries: int = 0
    lost: bool = False
    shown: bool = False
    arrived: bool = False


@dataclass(slots=True)
class _Stream(Generic[P]):
    """A stream.

    Attributes:
        packets: All that were not delivered, in their order.
        unsent: Those of them that wait for the window.
        window: How many may be on their way.
        unanswered: How many are.
    """

    packets: collections.deque[_Packet[P]] = field(default_factory=collections.deque)
    unsent: collections.deque[_Packet[P]] = field(default_factory=collections.deque)
    window: CongestionWindow = field(default_factory=CongestionWindow)
    unanswered: int = 0


@dataclass(frozen=True, slots=True)
class Delivery(Generic[P]):
    """A packet that leaves the link.

    Attributes:
        time: Of its arrival [s].
        stream: Number of its stream.
        content: As it was sent.
        size: Of that [bytes].
    """

    time: float
    stream: int
    content: P
    size: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectionCounts:
    """What a direction did since its start.

    Attributes:
        packets: Packets that were sent for the first time.
        bytes: Their content [bytes].
        lost: Packets that were lost, each time counted.
        delivered: Packets that arrived.
        delay: Sum of their times in the link [s].
    """

    packets: int = 0
    bytes: int = 0
    lost: int = 0
    delivered: int = 0
    delay: float = 0.0


class LinkDirection(Generic[P]):
    """One direction: `send` takes packets, `take` returns those that arrived. Times never decrease.

    Attributes:
        conditions: How the link is at a time.
    """

    def __init__(self, conditions: DirectionConditions, profile: LinkProfile) -> None:
        self.conditions = conditions
        whole = profile.up.delay + profile.down.delay
        self._whole = whole
        self._back = whole - conditions.spec.delay
        self._retry = whole + max(_LEAST_MARGIN_S, _JITTERS * profile.jitter)
        self._free = 0.0
        self._streams: dict[int, _Stream[P]] = {}
        self._waiting: collections.deque[tuple[float, int]] = collections.deque()
        self._waiting_bytes = 0
        self._events: list[tuple[float, int, int, _Packet[P]]] = []
        self._answers: list[tuple[float, int, int]] = []
        """Time, number, stream; they come in the order of time."""
        self._number = 0
        self._packets = self._bytes = self._lost = self._delivered = 0
        self._delay = 0.0

    @property
    def due(self) -> float:
        """Time of the next event; infinite while the link is empty [s].

        Answers count while a window is full only: a relay should not wake up for others.
        """
        due = self._events[0][0] if self._events else math.inf
        full = any(each.unanswered >= each.window.size for each in self._streams.values())
        return min(due, self._answers[0][0]) if full and self._answers else due

    @property
    def counts(self) -> DirectionCounts:
        """What it did since its start."""
        return DirectionCounts(
            packets=self._packets,
            bytes=self._bytes,
            lost=self._lost,
            delivered=self._delivered,
            delay=self._delay,
        )

    def waiting(self, now: float) -> int:
        """Bytes that wait to be sent."""
        while self._waiting and self._waiting[0][0] <= now:
            self._waiting_bytes -= self._waiting.popleft()[1]
        return self._waiting_bytes

    def room_at(self, now: float) -> float:
        """When the queue has room for another packet: now, or later [s]."""
        over = self.waiting(now) - self.conditions.spec.room
        time = now
        for sent, size in self._waiting:
            if over < 0:
                break
            time, over = sent, over - size
        return time

    def takes(self, stream: int) -> bool:
        """Whether a packet of this stream would be sent at once."""
        known = self._streams.get(stream)
        return known is None or (not known.unsent and known.unanswered < known.window.size)

    def send(
        self, stream: int, content: P, size: int, now: float, longest: float = _LONGEST_RETRY_S
    ) -> None:
        """Take a packet; take those that arrived until `now` before.

        Args:
            stream: Number of the stream.
            content: Anything.
            size: Without headers [bytes].
            now: [s]
            longest: Longest pause before it is sent again, if it is lost [s].
        """
        known = self._streams.setdefault(stream, _Stream())
        packet = _Packet(content, size, now, longest)
        known.packets.append(packet)
        known.unsent.append(packet)
        self._packets += 1
        self._bytes += size
        self._send_unsent(stream, now)

    def take(self, now: float) -> list[Delivery[P]]:
        """The packets that arrived until `now`, in the order of time."""
        out: list[Delivery[P]] = []
        while (time := self._next()) <= now:
            if self._answers and self._answers[0][0] == time:
                self._answer(heapq.heappop(self._answers)[2], time)
                continue
            _, _, stream, packet = heapq.heappop(self._events)
            known = self._streams.get(stream)
            if known is None:  # it was forgotten
                continue
            if packet.arrived or packet.due != time:  # the event was moved
                continue
            if packet.lost:
                if not packet.shown:
                    known.window.timed_out()
                packet.shown = False
                self._transmit(stream, packet, time)
            else:
                packet.arrived = True
                self._number += 1
                heapq.heappush(self._answers, (time + self._back, self._number, stream))
                self._show_losses(stream, packet, time)
                out += self._deliver(stream, time)
        return out

    def forget(self, stream: int) -> None:
        """Drop the packets of a stream."""
        self._streams.pop(stream, None)

    def _transmit(self, stream: int, packet: _Packet[P], time: float) -> None:
        size = packet.size + HEADERS
        self._free = packet.sent = self.conditions.sent(max(self._free, time), size)
        self._waiting.append((packet.sent, size))
        self._waiting_bytes += size
        packet.lost = self.conditions.lost(packet.sent)
        if packet.lost:
            self._lost += 1
            pause = min(packet.longest, self._retry * 2.0 ** min(packet.tries, 10))
            packet.tries += 1
            self._at(packet.sent + pause, stream, packet)
        else:
            self._at(packet.sent + self.conditions.delay(packet.sent), stream, packet)

    def _next(self) -> float:
        """Time of the next arrival, retransmission or answer [s]."""
        return min(each[0][0] if each else math.inf for each in (self._events, self._answers))

    def _answer(self, stream: int, time: float) -> None:
        known = self._streams.get(stream)
        if known is not None:
            known.window.answered(known.unanswered, time - self._whole)
            known.unanswered -= 1
            self._send_unsent(stream, time)

    def _send_unsent(self, stream: int, time: float) -> None:
        """Send what the window allows."""
        known = self._streams[stream]
        while known.unsent and known.unanswered < known.window.size:
            known.window.use(time, self._retry)
            known.unanswered += 1
            self._transmit(stream, known.unsent.popleft(), time)

    def _show_losses(self, stream: int, later: _Packet[P], time: float) -> None:
        """Have packets sent again that were lost before one that arrived."""
        known, again = self._streams[stream], time + self._back
        for packet in known.packets:
            if packet.lost and packet.sent < later.sent and again < packet.due:
                packet.shown = True
                known.window.showed_loss(packet.sent, again)
                self._at(again, stream, packet)

    def _deliver(self, stream: int, time: float) -> list[Delivery[P]]:
        packets, out = self._streams[stream].packets, []
        while packets and packets[0].arrived:
            packet = packets.popleft()
            out.append(Delivery(time, stream, packet.content, packet.size))
            self._delivered += 1
            self._delay += time - packet.began
        return out

    def _at(self, time: float, stream: int, packet: _Packet[P]) -> None:
        packet.due = time
        self._number += 1
        heapq.heappush(self._events, (time, self._number, stream, packet))


class LinkModel(Generic[P]):
    """Both directions of a link.

    Attributes:
        up: From the console to the hub.
        down: From the hub to the console.
    """

    def __init__(self, profile: LinkProfile, seed: int) -> None:
        self.up: LinkDirection[P] = LinkDirection(
            DirectionConditions(profile, seed, up=True), profile
        )
        self.down: LinkDirection[P] = LinkDirection(
            DirectionConditions(profile, seed, up=False), profile
        )
