"""Ways to have a command count under another number that need more than a wrong number."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
import zmq

from hub.ipc.broker.central import Central
from hub.ipc.definition import Plane
from hub.ipc.node.responders import FrameReply
from hub.ipc.wire import control, control_codec, frames
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.forging_bus import FORGED, TAKEN, Bus, event, stop
from tests.hub.ipc.vocabulary import Number
from tests.support.raw_client import Context
from tests.support.waiting import until

Way = Callable[[Bus, str], zmq.Socket[bytes]]

_ZMTP_2 = b"\xff" + bytes(8) + b"\x7f" + b"\1"
"""Greeting of a peer that knows no properties of connections."""
_PUSH, _PUB = 8, 1

_AS_FORWARDER = """
import sys, zmq
from hub.ipc.wire import control, control_codec
dealer = zmq.Context().socket(zmq.DEALER)
dealer.linger = 0
dealer.connect(sys.argv[1])
dealer.send(control_codec.pack(control.Hello(name="mirror", pid=int(sys.argv[2]))))
assert dealer.poll(10_000)
print(control_codec.unpack(dealer.recv()).ticket)
"""


@pytest.fixture
def bus(tmp_path: Path) -> Iterator[Bus]:
    with ExitStack() as stack:
        yield Bus(tmp_path, stack)


def _own(bus: Bus, way: Way) -> str:
    return bus.inbox.ticket if way is Bus.to_receiver else bus.forger.ticket


def _zmtp_2(address: str, kind: int, frame: bytes) -> socket.socket:
    """Send one frame as an old version of ZeroMQ does."""
    made = socket.socket(socket.AF_UNIX)
    made.connect(address.removeprefix("ipc://").replace("@", "\0", 1))
    made.sendall(_ZMTP_2 + bytes([kind]) + b"\0\0" + bytes([0, len(frame)]) + frame)
    return made


def _send_honest(bus: Bus, way: Way) -> None:
    kind = frames.FAR if way is Bus.to_central else b""
    way(bus, _own(bus, way)).send(event(bus.forger.number, TAKEN, kind=kind))


@pytest.mark.parametrize("way", [Bus.to_receiver, Bus.to_central])
def test_a_damaged_frame_does_not_count_under_another_number(bus: Bus, way: Way) -> None:
    kind = frames.FAR if way is Bus.to_central else b""
    owner = bus.owner.client.number
    forged = event(owner, FORGED, kind=kind)
    padded = event(owner, FORGED, kind=kind, definition=v.COMMAND)
    padding = padded.index(b"\0") + 1  # the reader skips it
    damaged = [padded[:padding] + b"x" + padded[padding + 1 :]]
    if way is Bus.to_receiver:
        damaged += [frames.bundle([each, forged]) for each in (b"x", b"T_Event\0short")]
    sending = way(bus, _own(bus, way))
    for each in damaged:
        sending.send(each)
    sending.send(event(bus.forger.number, TAKEN, kind=kind))
    until(lambda: TAKEN in bus.values(), 10.0)
    assert padded[padding] == 0
    assert bus.values() == [TAKEN]


def test_a_stop_counts_that_comes_together_with_a_forged_command(bus: Bus) -> None:
    forged = event(bus.owner.client.number, FORGED)
    bus.to_receiver("").send(frames.bundle([forged, stop(7)]))
    until(lambda: bus.stops, 10.0)
    assert bus.values() == []
    assert bus.refused() == 1


@pytest.mark.parametrize("way", [Bus.to_receiver, Bus.to_central])
@pytest.mark.parametrize("shown", [b"\xff\xfe", b"9" * 1_000_000], ids=["no text", "long"])
def test_a_strange_ticket_is_none(bus: Bus, way: Way, shown: bytes) -> None:
    kind = frames.FAR if way is Bus.to_central else b""
    socket_kind, address = zmq.PUB, bus.forger.input_of(Plane.COMMAND)
    if way is Bus.to_receiver:
        socket_kind, address = zmq.PUSH, bus.inbox.inbox
    context: Context = zmq.Context.instance()
    with closing(context.socket(socket_kind)) as forging:
        forging.linger = 0
        forging.setsockopt(zmq.METADATA, b"X-Rune-Sender:" + shown)
        forging.connect(address)
        forged = event(bus.owner.client.number, FORGED, kind=kind)
        until(bus.refused, 10.0, meanwhile=lambda: forging.send(forged))
    _send_honest(bus, way)
    until(lambda: bus.values() == [TAKEN], 10.0, lambda: f"{bus.values()}")


@pytest.mark.parametrize("way", [Bus.to_receiver, Bus.to_central])
def test_a_peer_without_properties_shows_no_ticket(bus: Bus, way: Way) -> None:
    owner = bus.owner.client.number
    if way is Bus.to_receiver:
        made = _zmtp_2(bus.inbox.inbox, _PUSH, event(owner, FORGED))
    else:
        address = bus.forger.input_of(Plane.COMMAND)
        made = _zmtp_2(address, _PUB, event(owner, FORGED, kind=frames.FAR))
    with closing(made):
        until(lambda: bus.refused() == 1, 10.0)
    assert bus.values() == []


def test_a_last_value_brings_no_command(bus: Bus) -> None:
    client = bus.receiver.client
    came: list[Number] = []
    for definition in (v.STREAM, v.LOG_TOO):
        bus.receiver.call(lambda definition=definition: client.define(definition))
        bus.receiver.call(lambda: client.wait_defined(5.0))
        bus.forger.say(control.Advertise(name=definition.name))
        bus.forger.heard(control.Advertised)
        bus.receiver.call(
            lambda definition=definition: client.subscribe(
                definition, lambda value, _: came.append(value), last=True
            )
        )
        asked: control.Last = bus.forger.heard(control.Last)
        own = event(bus.forger.number, TAKEN, definition=definition)
        forged = event(bus.owner.client.number, FORGED, 50)
        answer = control_codec.pack(control.Response(number=asked.number))
        frame = own if definition is v.LOG_TOO else forged
        bus.forger.control.send_multipart([answer, frame])
    until(lambda: came, 10.0)  # behind the forged one
    assert bus.values() == []


def test_a_query_under_the_name_of_a_stop_does_not_count(bus: Bus) -> None:
    asked: list[int] = []

    def answer(frame: frames.Frame, reply: FrameReply) -> None:
        asked.append(frame.publisher)
        reply.fail("HandlerFailedError", "it is a test")

    client = bus.receiver.client
    bus.receiver.call(lambda: client.respond_frames(v.ASK, answer))
    bus.receiver.call(lambda: client.directory.listing(5.0))
    query = control_codec.pack(control.Query(number=1, name=v.ASK.name, timeout_s=5.0))
    own = stop(bus.forger.number)
    bus.forger.control.send_multipart([query, own])
    route: control.DirectRoute = bus.forger.heard(control.DirectRoute)
    direct = bus.forger.connect(zmq.DEALER, route.address, route.ticket)
    for each in (stop(bus.owner.client.number), own):
        direct.send_multipart([query, each])
    until(lambda: len(asked) == 2, 10.0)
    assert set(asked) == {bus.forger.number}


def test_a_ticket_ends_with_the_connection_of_its_receiver(bus: Bus) -> None:
    client = bus.receiver.client
    bus.receiver.call(lambda: client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    responder = client.session.direct_responder
    assert responder is not None
    before, of_queries = bus.inbox.inbox, responder.tickets.key
    bus.receiver.call(lambda: client.session.connection.start_over("it is a test"))
    inboxes = client.session.subscriptions.inboxes
    until(
        lambda: (
            client.connected
            and Plane.COMMAND in inboxes
            and inboxes[Plane.COMMAND].address != before
            and responder.tickets.key != of_queries
        ),
        10.0,
    )
    bus.to_receiver(bus.inbox.ticket).send(event(bus.forger.number, FORGED))
    until(lambda: bus.refused() == 1, 10.0)
    assert bus.values() == []


def test_another_process_is_not_taken_for_the_forwarder(tmp_path: Path) -> None:
    endpoint = f"ipc://{tmp_path}/central"
    with closing(Central([endpoint], forwarder="mirror")):
        shown = subprocess.run(
            [sys.executable, "-c", _AS_FORWARDER, endpoint, str(os.getpid())],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    assert shown.partition(".")[0] not in ("", "0")
