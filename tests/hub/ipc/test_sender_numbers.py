"""A command counts under the number that central gave to its connection, and under no other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
import zmq

from hub.ipc.broker.central import Central
from hub.ipc.definition import Plane
from hub.ipc.node.responders import Reply
from hub.ipc.transport.sender_tickets import ticket
from hub.ipc.wire import control, control_codec, frames
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.forging_bus import FORGED, TAKEN, Bus, event, stop
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until


@pytest.fixture
def bus(tmp_path: Path) -> Iterator[Bus]:
    with ExitStack() as stack:
        yield Bus(tmp_path, stack)


Way = Callable[[Bus, str], zmq.Socket[bytes]]


@pytest.mark.parametrize(
    ("way", "kind", "own"),
    [
        (Bus.to_receiver, b"", lambda bus: bus.inbox.ticket),
        (Bus.to_central, frames.FAR, lambda bus: bus.forger.ticket),
    ],
    ids=["to the receiver", "through central"],
)
def test_a_command_counts_under_the_number_in_the_ticket_of_its_connection_only(
    bus: Bus, way: Way, kind: bytes, own: Callable[[Bus], str]
) -> None:
    numbers = (bus.owner.client.number, bus.forger.number, 0, 9)
    without = {
        "none": "",
        "another receiver's": ticket("0" * 32, bus.forger.number),
        "for any number": ticket("0" * 32, 0),
    }
    count = 0
    for shown in without.values():
        forging = way(bus, shown)
        for number in numbers:
            forging.send(event(number, FORGED, kind=kind))
            forging.send(frames.bundle([event(number, FORGED, kind=kind)]))
        # Only subscribed topics go to central: no bundle does.
        count += len(numbers) * (1 if way is Bus.to_central else 2)
        until(lambda count=count: bus.refused() >= count, 10.0, lambda: str(bus.refused()))
    honest = way(bus, own(bus))
    for sequence, number in enumerate((bus.owner.client.number, 0, 9), 1):
        honest.send(event(number, FORGED, sequence, kind))
    honest.send(event(bus.forger.number, TAKEN, kind=kind))
    until(lambda: bus.values() == [TAKEN], 10.0, lambda: f"{bus.values()}")
    assert bus.received[-1][1].publisher == bus.forger.number


def test_a_command_does_not_come_in_as_a_state(bus: Bus) -> None:
    forging = bus.to_receiver(bus.inbox.ticket, Plane.STATE)
    log = frames.pack(
        frames.prefix(v.LOG.name),
        publisher=9,
        fingerprint=v.LOG.fingerprint,
        sequence=1,
        stamp_ns=0,
        payload=v.LOG.encode(Number(value=3)),
    )
    forged = event(bus.owner.client.number, FORGED, 50)
    for raw in (forged, frames.bundle([forged, log])):
        forging.send(raw)
    until(lambda: bus.states, 10.0)
    assert bus.values() == []
    assert bus.refused() == 2


@pytest.mark.parametrize("way", [Bus.to_receiver, Bus.to_central])
def test_a_stop_counts_whoever_sends_it(bus: Bus, way: Way) -> None:
    kind = frames.FAR if way is Bus.to_central else b""
    way(bus, "").send(stop(7, kind))
    until(lambda: bus.stops, 10.0)
    assert bus.refused() == 0


def test_a_forwarder_sends_under_the_numbers_of_others(tmp_path: Path) -> None:
    with ExitStack() as stack:
        endpoint = f"ipc://{tmp_path}/central"
        central = stack.enter_context(closing(Central([endpoint], forwarder="mirror")))
        near, far = (Peer(name, endpoint, near=name == "near") for name in ("near", "far"))
        mirror, other = Peer("mirror", endpoint), Peer("other", endpoint)
        for each in (near, far, mirror, other):
            stack.callback(each.close)
            each.connect()
        received = [each.collect(v.EVENT) for each in (near, far)]
        for each in (near, far):
            each.stands()
        frame = frames.unpack(event(77, TAKEN))
        for sender in (other, mirror):
            sender.open(v.EVENT)
            sender.call(lambda sender=sender: sender.client.forward(v.EVENT, frame))
        for came in received:
            until(lambda came=came: any(value.value == TAKEN for value, _ in came), 10.0)
            assert [how.publisher for value, how in came if value.value == TAKEN] == [77]
        until(
            lambda: (
                central.faults.counts["forged number"] == 1
                and near.client.faults.counts["forged number"] == 1
            ),
            10.0,
        )


def test_a_direct_query_counts_under_the_number_of_its_asker_only(bus: Bus) -> None:
    asked: list[int] = []

    def answer(ask: Number, reply: Reply[Number]) -> None:
        asked.append(reply.asker)
        reply.answer(ask)

    client = bus.receiver.client
    bus.receiver.call(lambda: client.respond_later(v.ASK, v.ANSWER, answer))
    bus.receiver.call(lambda: client.wait_defined(5.0))
    bus.receiver.call(lambda: client.directory.listing(5.0))
    query = control_codec.pack(control.Query(number=1, name=v.ASK.name, timeout_s=5.0))

    def frame(number: int) -> bytes:
        return frames.pack(
            frames.prefix(v.ASK.name),
            publisher=number,
            fingerprint=v.ASK.fingerprint,
            sequence=1,
            stamp_ns=0,
            payload=v.ASK.encode(Number(value=5)),
        )

    bus.forger.control.send_multipart([query, frame(bus.forger.number)])  # through central
    route: control.DirectRoute = bus.forger.heard(control.DirectRoute)
    for shown in ("", route.ticket):
        direct = bus.forger.connect(zmq.DEALER, route.address, shown)
        for number in (bus.owner.client.number, 9):
            direct.send_multipart([query, frame(number)])
    direct.send_multipart([query, frame(bus.forger.number)])
    until(lambda: len(asked) == 2 and bus.refused() == 4, 10.0, lambda: f"{asked}")
    assert set(asked) == {bus.forger.number}
