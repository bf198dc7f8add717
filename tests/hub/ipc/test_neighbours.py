"""Broadcasts that pass central by: nothing missed, nothing twice, and no stranger gets in."""

from __future__ import annotations

import errno
import os
import random
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zmq

from hub.errors import CodecError, HandlerFailedError, QueryError
from hub.ipc import control, frames, sockets
from hub.ipc.central import Central
from hub.ipc.control import Advertise, Advertised, Ready, Subscribe, Subscribed, Subscriber
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.hub_time import this_neighbourhood
from hub.ipc.registry import MAX_PEERS
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.test_registry import Bench
from tests.hub.ipc.vocabulary import Number
from tests.waiting import until

pytestmark = pytest.mark.skipif(not this_neighbourhood(), reason="this system has no neighbours")

Make = Callable[..., Peer]
INBOX = "ipc://@rune-state-1"


@pytest.fixture
def wanted_endpoint() -> str:
    return "tcp://127.0.0.1:0"


@pytest.fixture
def make(central: Central) -> Iterator[Make]:
    """Makes connected peers: name, and whether they are near."""
    made: list[Peer] = []

    def make(name: str, *, near: bool = True) -> Peer:
        made.append(Peer(name, central.endpoints[0], near=near))
        return made[-1].connect()

    yield make
    for peer in made:
        peer.close()


def _stands(peer: Peer) -> None:
    peer.call(lambda: peer.client.wait_subscribed(5.0))


def _open(peer: Peer, *definitions: Any) -> None:
    """Publish -1 of each, and wait until it has left."""
    for each in definitions:
        peer.publish(each, Number(value=-1))
    peer.call(lambda: peer.client.wait_published(5.0))


def _values(received: list[Any]) -> list[int]:
    return [value.value for value, _ in received]


def _takers(peer: Peer, definition: Any = v.LOG) -> int:
    return len(peer.client._outlets.of(definition).takers.whole)


@pytest.mark.parametrize("first", ["publisher", "subscriber"])
@pytest.mark.parametrize("definition", [v.LOG, v.EVENT], ids=["state", "command"])
def test_each_message_reaches_near_and_far_subscribers_once_from_near_and_far_publishers(
    make: Make, definition: Any, first: str
) -> None:
    publishers = [make("near publisher"), make("far publisher", near=False)]
    subscribers = [make("near subscriber"), make("far subscriber", near=False)]
    expected: list[int] = []
    if first == "publisher":
        for number, peer in enumerate(publishers):
            peer.publish(definition, Number(value=-1 - number))
            peer.call(lambda peer=peer: peer.client.wait_published(5.0))
    received = [peer.collect(definition) for peer in subscribers]
    for peer in subscribers:
        _stands(peer)
    for start, peer in zip((0, 1000), publishers, strict=True):
        for number in range(200):
            peer.publish(definition, Number(value=start + number))
            expected.append(start + number)
    for each in received:
        until(lambda each=each: len(each) >= 400, 5.0)
        assert sorted(_values(each)) == expected
        assert all(how.missed == 0 for _, how in each)
        assert [x for x in _values(each) if x < 1000] == expected[:200]


def test_what_goes_to_neighbours_alone_is_not_sent_to_central(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    _stands(other)
    one.publish(v.LOG, Number(value=1))
    until(lambda: received, 5.0)
    outlet = one.client._outlets.of(v.LOG)
    assert len(outlet.takers.whole) == 1
    assert not one.client._outlets.is_wanted(outlet.topic)


def test_messages_of_several_names_arrive_in_the_order_of_publishing(make: Make) -> None:
    one, other = make("one"), make("other")
    received: list[tuple[str, int]] = []
    names = (v.LOG, v.LOG_TOO)
    for each in names:
        other.call(
            lambda each=each: other.client.subscribe(
                each, lambda value, _, name=each.name: received.append((name, value.value))
            )
        )
    _stands(other)
    _open(one, *names)
    sent = [(names[i % 2].name, i) for i in range(3000)]

    def publish() -> None:
        for i in range(3000):
            one.client.publish(names[i % 2], Number(value=i))

    one.call(publish)
    until(lambda: len(received) == 3000 + len(names), 5.0)
    assert received[len(names) :] == sent


def test_after_a_handler_that_raises_or_listens_the_rest_still_comes_in_order(make: Make) -> None:
    one, other = make("one"), make("other")
    received: list[int] = []

    def handle(value: Number, how: Any) -> None:
        del how
        received.append(value.value)
        if value.value < 0:
            return
        if value.value % 50 == 7:
            other.client.listen(0.0)
        if value.value % 50 == 9:
            raise ZeroDivisionError

    for each in (v.LOG, v.LOG_TOO):
        other.call(lambda each=each: other.client.subscribe(each, handle))
    _stands(other)
    _open(one, v.LOG, v.LOG_TOO)

    def publish() -> None:
        for i in range(500):
            one.client.publish((v.LOG, v.LOG_TOO)[i % 2], Number(value=i))

    one.call(publish)
    until(lambda: len(received) == 502, 5.0)
    assert received[2:] == list(range(500))
    assert len(other.faults) == 10


def test_unsubscribed_and_departed_neighbours_get_no_more(make: Make) -> None:
    one, other, third = make("one"), make("other"), make("third")
    received, too = other.collect(v.LOG), third.collect(v.LOG)
    for each in (other, third):
        _stands(each)
    one.publish(v.LOG, Number(value=1))
    until(lambda: received and too, 5.0)
    other.call(lambda: other.client.unsubscribe(v.LOG))
    until(lambda: _takers(one) == 1, 5.0)
    third.close()
    until(lambda: _takers(one) == 0, 5.0)
    one.publish(v.LOG, Number(value=2))
    assert _values(received) == _values(too) == [1]
    until(lambda: not one.client._outlets._deliveries._ways, 10.0, "a way stayed open")


def test_neighbour_that_never_reads_holds_up_nobody(make: Make) -> None:
    one, stuck, other = make("one"), make("stuck"), make("other")
    stuck_got, received = stuck.collect(v.LOG), other.collect(v.LOG)
    for each in (stuck, other):
        _stands(each)
    free = threading.Event()
    stuck.client.post(lambda: free.wait(10.0))
    for number in range(5000):
        one.publish(v.LOG, Number(value=number))
        if number % 500 == 499:
            until(lambda n=number: len(received) == n + 1, 5.0)
    free.set()
    until(lambda: stuck_got, 5.0)
    assert all(how.missed == 0 for _, how in received)


def test_rubbish_in_an_inbox_is_counted_and_harms_nobody(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    rogue = context.socket(zmq.PUSH)
    rogue.connect(other.client._inlets._inboxes[Plane.STATE].address)
    randomness = random.Random(3)
    topic = frames.topic(v.LOG.name)
    for _ in range(200):
        raw = randomness.randbytes(randomness.randint(0, 200))
        for each in (raw, topic + raw, b"*" + raw, b"@" + topic + raw, b"!" + topic + raw,
                     frames.train([raw, topic + raw])):  # fmt: skip
            rogue.send(each)
    rogue.send_multipart([b"x"] * 1000)
    counts = other.client.complaints.counts
    until(lambda: counts["malformed frame"] > 1000, 5.0)
    for number in range(100):
        one.publish(v.LOG, Number(value=number))
    until(lambda: [x for x in _values(received) if x >= 0] == list(range(100)), 5.0)
    context.destroy(linger=0)


@pytest.mark.skipif(os.getuid() != 0, reason="only root can be somebody else")
def test_another_user_cannot_send_into_an_inbox(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    address = other.client._inlets._inboxes[Plane.STATE].address
    program = (
        "import os, sys, zmq; os.setgid(65534); os.setuid(65534)\n"
        "push = zmq.Context().socket(zmq.PUSH); push.connect(sys.argv[1]); push.linger = 500\n"
        "monitor = push.get_monitor_socket(zmq.EVENT_DISCONNECTED)\n"
        "push.send(b'x' * 100); print(monitor.poll(5000))"
    )
    told = subprocess.run(
        [sys.executable, "-c", program, address], capture_output=True, text=True, check=True
    )
    assert told.stdout.strip() == "1", "it was not turned away"
    one.publish(v.LOG, Number(value=5))
    until(lambda: 5 in _values(received), 5.0)
    assert not other.client.complaints.counts


@pytest.mark.parametrize(
    "inbox", ["tcp://192.0.2.1:1", "ipc:///tmp/rune-x", "ipc://@rune-" + "x" * 100, "ipc://@other"]
)
def test_publisher_connects_to_nothing_but_inboxes(make: Make, inbox: str) -> None:
    one = make("one")
    one.publish(v.LOG, Number(value=1))
    wrong = Subscriber(name="T_Log", subscriber=1, inbox=inbox)
    one.call(lambda: one.client._outlets.subscriber(wrong))
    assert _takers(one) == 0
    assert one.client.complaints.counts["malformed control frame"] == 1


@pytest.fixture
def bench() -> Bench:
    made = Bench()
    for who in "abc":
        hello = control.Hello(
            name=f"module {who}", pid=1, neighbourhood=this_neighbourhood() if who != "c" else 7
        )
        assert made.answer(who, hello).near == (who != "c")
    made.define("a", "M", "{int}")
    return made


def _number(bench: Bench, who: str) -> int:
    return bench.registry._peers[who.encode()].publisher


def test_publisher_is_told_of_neighbours_before_it_is_told_that_it_is_noted(bench: Bench) -> None:
    bench.say("b", Subscribe(name="M", token="1.1", inbox=INBOX))
    told, answer = bench.say("a", Advertise(name="M"))
    assert told.message == Subscriber(name="M", subscriber=_number(bench, "b"), inbox=INBOX)
    assert answer.message == Advertised(name="M", subscribed=False)
    assert told.identity == answer.identity == b"a"
    assert bench.answer("c", Advertise(name="M")) == Advertised(name="M", subscribed=True)


def test_subscription_stands_when_the_publisher_has_noted_the_inbox(bench: Bench) -> None:
    bench.say("a", Advertise(name="M"))
    (told,) = bench.say("b", Subscribe(name="M", token="1.1", inbox=INBOX, in_ring=True))
    assert told.identity == b"a"
    assert (told.message.token, told.message.in_ring) == ("1.1", True)
    bench.say("b", Ready(token="1.1"))
    (stands,) = bench.say("a", Ready(token="1.1"))
    assert (stands.identity, stands.message) == (b"b", Subscribed(token="1.1"))


def test_publisher_is_told_once_of_a_neighbour_that_is_gone(bench: Bench) -> None:
    bench.define("a", "N", "{int}")
    for name in "MN":
        bench.say("a", Advertise(name=name))
        bench.say("b", Subscribe(name=name, token="", inbox=INBOX))
    gone = Subscriber(name="", subscriber=_number(bench, "b"))
    told = [out.message for out in bench.say("b", control.Bye()) if out.identity == b"a"]
    assert told == [gone]
    assert bench.answer("a", Advertise(name="M")) == Advertised(name="M", subscribed=False)


def test_publisher_is_told_when_a_neighbour_unsubscribes(bench: Bench) -> None:
    bench.say("a", Advertise(name="M"))
    bench.say("b", Subscribe(name="M", token="", inbox=INBOX))
    (told,) = bench.say("b", control.Unsubscribe(name="M"))
    assert told.message == Subscriber(name="M", subscriber=_number(bench, "b"))
    assert bench.say("b", control.Unsubscribe(name="M")) == []


@pytest.mark.parametrize(("who", "inbox"), [("c", INBOX), ("b", "tcp://192.0.2.1:1"), ("b", "")])
def test_inbox_of_a_stranger_or_elsewhere_is_told_nobody(
    bench: Bench, who: str, inbox: str
) -> None:
    bench.say(who, Subscribe(name="M", token="", inbox=inbox))
    assert bench.answer("a", Advertise(name="M")) == Advertised(name="M", subscribed=True)


def test_nothing_is_lost_while_subscribers_come_and_go(make: Make) -> None:
    """The one that stays gets every message whatever the others do."""
    one, stays = make("one"), make("stays")
    received = stays.collect(v.LOG)
    _stands(stays)
    sent: list[int] = []
    stop = threading.Event()

    def publish() -> None:
        if not stop.is_set():
            one.client.publish(v.LOG, Number(value=len(sent)))
            sent.append(len(sent))
            one.client.loop.after(0.0005, publish)

    one.client.post(publish)
    for number in range(10):
        passer_by = make(f"passer-by {number}")
        came = passer_by.collect(v.LOG)
        until(lambda came=came: len(came) > 10, 5.0)
        values = _values(came)
        assert values == list(range(values[0], values[0] + len(values)))
        passer_by.close()
    stop.set()
    one.call(lambda: None)
    until(lambda: len(received) == len(sent), 5.0)
    assert _values(received) == sent


def _accepted_unseen() -> int:
    """How many connections the system lets wait for a program that does not look."""
    limit = Path("/proc/sys/net/core/somaxconn")
    return int(limit.read_text()) if limit.exists() else 0


@pytest.mark.skipif(_accepted_unseen() < MAX_PEERS, reason="the system lets fewer wait")
def test_every_publisher_gets_a_connection_to_a_subscriber_that_is_held_up(
    central: Central,
) -> None:
    """One that does not would not try again, and its messages would be lost for good."""
    program = (
        "import sys; from hub.ipc.client import Client; from tests.hub.ipc import vocabulary as v\n"
        "client = Client('held up', sys.argv[1]); client.subscribe(v.LOG, print)\n"
        "client.wait_subscribed(10.0)\n"
        "print([inbox.address for inbox in client._inlets._inboxes.values()][0], flush=True)\n"
        "sys.stdin.read()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program, central.endpoints[0]],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    address = process.stdout.readline().strip().removeprefix("ipc://@")
    process.send_signal(signal.SIGSTOP)
    connections = [socket.socket(socket.AF_UNIX) for _ in range(MAX_PEERS)]
    try:
        for each in connections:
            each.settimeout(0.0)
            each.connect("\0" + address)
    finally:
        process.kill()
        process.communicate()
        for each in connections:
            each.close()


LARGE = MessageDefinition(
    name="T_Large", format="{string,uint,<ubyte:2>}", type=v.Picture, keep=Keep.ALL
)


def _large(size: int) -> v.Picture:
    return v.Picture(name="", count=size, pixels=np.zeros(size, np.uint8))


@pytest.mark.parametrize("where", ["near", "far"])
def test_message_that_is_too_long_is_counted_and_the_next_ones_still_come(
    make: Make, where: str
) -> None:
    one, other = (make(name, near=where == "near") for name in ("one", "other"))
    received = other.collect(LARGE)
    _stands(other)
    for size in (frames.MAX_FRAME - 100, frames.MAX_FRAME, 10):
        one.publish(LARGE, _large(size))
        one.call(lambda: one.client.wait_published(5.0))
    until(lambda: len(received) == 2, 5.0)
    assert [value.count for value, _ in received] == [frames.MAX_FRAME - 100, 10]
    assert [how.missed for _, how in received] == [0, 1]
    assert one.client.complaints.counts == {"too long": 1}


def test_last_value_that_is_too_long_for_a_frame_is_none(make: Make) -> None:
    one, other = make("one"), make("other")
    number = one.client._connection.publisher
    one.publish(LARGE, _large(frames.MAX_FRAME))
    one.call(lambda: one.client.wait_published(5.0))
    with pytest.raises(QueryError):
        other.call(lambda: other.client.last_value(LARGE, timeout=5.0))
    assert one.client._connection.publisher == number


def test_publisher_that_finds_no_way_to_a_subscriber_publishes_to_the_others(make: Make) -> None:
    one, other, third = make("one"), make("other"), make("third")
    received, _ = other.collect(v.LOG), third.collect(v.LOG)
    for each in (other, third):
        _stands(each)
    _open(one, v.LOG)
    number = third.client._connection.publisher
    nowhere = Subscriber(name="T_Log", subscriber=number, inbox="ipc:///nowhere")
    one.call(lambda: one.client._outlets.subscriber(nowhere))
    assert _takers(one) == 1
    one.call(lambda: one.client._outlets.subscriber(Subscriber(name="", subscriber=number)))
    one.publish(v.LOG, Number(value=1))
    until(lambda: _values(received) == [-1, 1], 5.0)


def test_who_subscribes_again_gets_everything_in_order(make: Make) -> None:
    """What was sent before may still lie in the inbox then."""
    one, other = make("one"), make("other")
    received: list[int] = []
    steps = [threading.Event() for _ in range(3)]

    def handle(value: Number, how: Any) -> None:
        del how
        received.append(value.value)

    def subscribe_again() -> None:
        for step, work in zip(
            steps,
            (
                lambda: other.client.unsubscribe(v.LOG),
                lambda: other.client.subscribe(v.LOG, handle),
                lambda: None,
            ),
            strict=True,
        ):
            step.wait(10.0)
            work()

    def publish(start: int) -> None:
        for number in range(start, start + 200):
            one.client.publish(v.LOG, Number(value=number))

    other.call(lambda: other.client.subscribe(v.LOG, handle))
    _stands(other)
    _open(one, v.LOG)
    other.client.post(subscribe_again)
    one.call(lambda: publish(0))
    for step, takers in zip(steps, (0, 1), strict=False):
        step.set()
        until(lambda takers=takers: _takers(one) == takers, 5.0)
    one.call(lambda: publish(200))
    steps[2].set()
    until(lambda: received[-1:] == [399], 5.0)
    assert received == sorted(set(received))
    assert not other.client.complaints.counts


def test_handler_that_another_one_unsubscribes_is_not_called_any_more(make: Make) -> None:
    one, other = make("one"), make("other")
    received: list[int] = []

    def second(value: Number, how: Any) -> None:
        del how
        received.append(value.value)

    def first(value: Number, how: Any) -> None:
        del how
        if value.value == 1:
            other.client.unsubscribe(v.LOG, second)

    for handler in (first, second):
        other.call(lambda handler=handler: other.client.subscribe(v.LOG, handler))
    third = other.collect(v.LOG)
    _stands(other)
    for number in range(3):
        one.publish(v.LOG, Number(value=number))
    until(lambda: _values(third) == [0, 1, 2], 5.0)
    assert received == [0]


def test_subscriber_takes_more_neighbours_than_it_had_descriptors_for(make: Make) -> None:
    """ZeroMQ would end its process."""
    central = make("any").client.endpoint
    program = (
        "import resource, sys\n"
        "_, most = resource.getrlimit(resource.RLIMIT_NOFILE)\n"
        "resource.setrlimit(resource.RLIMIT_NOFILE, (60, most))\n"
        "from hub.ipc.client import Client; from tests.hub.ipc import vocabulary as v\n"
        "client = Client('poor', sys.argv[1])\n"
        "client.subscribe(v.LOG, lambda number, _: print(number.value, flush=True))\n"
        "client.wait_subscribed(10.0); print('stands', flush=True)\n"
        "while True: client.listen(1.0)"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program, central], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "stands\n"
        publishers = [make(f"publisher {number}") for number in range(30)]
        for number, each in enumerate(publishers):
            each.publish(v.LOG, Number(value=number))
        came = {int(process.stdout.readline() or -1) for _ in publishers}
        assert came == set(range(30))
    finally:
        process.kill()
        process.communicate()


def test_last_value_does_not_overtake_what_waits_in_the_inbox(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    _stands(other)
    _open(one, v.LOG)

    def publish() -> None:
        for number in range(10):
            one.client.publish(v.LOG, Number(value=number))

    def held_up() -> None:
        one.call(publish)
        other.client.subscribe(v.LOG, lambda *_: None, last=True)
        control_socket = other.client._connection._dialogue._socket
        until(lambda: sockets.readable(control_socket), 5.0, "no last value came")

    until(lambda: received, 5.0)
    other.call(held_up)
    until(lambda: len(received) > 10, 5.0, lambda: str(_values(received)))
    assert _values(received) == list(range(-1, 10))
    assert not other.client.complaints.counts


def test_way_to_a_neighbour_whose_connection_ended_is_made_anew(make: Make) -> None:
    one = make("one")
    one.publish(v.LOG, Number(value=0))
    one.call(lambda: one.client.wait_published(5.0))
    address = "ipc://@rune-state-0123456789abcdef"
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    told = Subscriber(name="T_Log", subscriber=7, inbox=address)
    for number in (1, 2):
        inbox = context.socket(zmq.PULL)
        until(lambda inbox=inbox: _bound(inbox, address), 5.0)
        if number == 1:
            one.call(lambda: one.client._outlets.subscriber(told))
        until(
            lambda inbox=inbox: inbox.poll(0),
            5.0,
            meanwhile=lambda: one.publish(v.LOG, Number(value=1)),
        )
        inbox.close(0)
    context.destroy(linger=0)


def _bound(socket: zmq.Socket[bytes], address: str) -> bool:
    try:
        socket.bind(address)
    except zmq.ZMQError:
        return False
    return True


def test_query_and_answer_that_are_too_long_fail_and_nothing_else_does(make: Make) -> None:
    one, other = make("one"), make("other")
    long = np.zeros(frames.MAX_FRAME, np.uint8)
    long_answer = v.Picture(name="x", count=len(long), pixels=long)
    other.call(lambda: other.client.respond(v.ASK, v.RING_PICTURE, lambda _: long_answer))
    other.call(lambda: other.client.wait_defined(5.0))
    for _ in range(3):
        with pytest.raises(HandlerFailedError, match="too long"):
            one.call(
                lambda: one.client.query_response(
                    v.ASK, Number(value=1), v.RING_PICTURE, timeout=5.0
                )
            )
    with pytest.raises(CodecError, match="too long"):
        one.call(lambda: one.client.query_response(v.RING_PICTURE, long_answer, v.ASK, timeout=5.0))
    assert one.client.connected
    assert other.client.connected


def test_neighbour_that_could_not_be_reached_is_tried_again(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = make("one"), make("other")
    make_inbox = sockets.make_inbox
    full = threading.Event()
    full.set()

    def without_descriptors(context: Any, kind: int, plane: Plane) -> Any:
        if kind == zmq.PUSH and full.is_set():
            raise zmq.ZMQError(errno.EMFILE)
        return make_inbox(context, kind, plane)

    monkeypatch.setattr(sockets, "make_inbox", without_descriptors)
    _open(one, v.LOG)
    received = other.collect(v.LOG)
    until(lambda: one.client.complaints.counts["no way to a subscriber"], 5.0)
    full.clear()
    _stands(other)
    one.publish(v.LOG, Number(value=5))
    until(lambda: _values(received) == [5], 5.0)
