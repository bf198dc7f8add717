"""Inboxes: who gets into them, and how publishers find their way to them."""

from __future__ import annotations

import errno
import os
import random
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
import zmq

from hub.ipc.broker.central import Central
from hub.ipc.broker.connections import MAX_PEERS
from hub.ipc.definition import Plane
from hub.ipc.transport import sockets
from hub.ipc.transport.clock_sync import this_neighbourhood
from hub.ipc.wire import frames
from hub.ipc.wire.control import Subscriber
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Make, values
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

pytestmark = pytest.mark.skipif(not this_neighbourhood(), reason="this system has no neighbours")


@pytest.fixture
def wanted_endpoint() -> str:
    return "tcp://127.0.0.1:0"


def test_rubbish_in_an_inbox_is_counted_and_harms_nobody(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    rogue = context.socket(zmq.PUSH)
    rogue.connect(other.client.session.subscriptions.inboxes[Plane.STATE].address)
    randomness = random.Random(3)
    topic = frames.topic(v.LOG.name)
    for _ in range(200):
        raw = randomness.randbytes(randomness.randint(0, 200))
        for each in (raw, topic + raw, b"*" + raw, b"@" + topic + raw, b"!" + topic + raw,
                     frames.bundle([raw, topic + raw])):  # fmt: skip
            rogue.send(each)
    rogue.send_multipart([b"x"] * 1000)
    counts = other.client.faults.counts
    until(lambda: counts["malformed frame"] > 1000, 5.0)
    for number in range(100):
        one.publish(v.LOG, Number(value=number))
    until(lambda: [x for x in values(received) if x >= 0] == list(range(100)), 5.0)
    context.destroy(linger=0)


@pytest.mark.skipif(os.getuid() != 0, reason="only root can be somebody else")
def test_another_user_cannot_send_into_an_inbox(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    address = other.client.session.subscriptions.inboxes[Plane.STATE].address
    program = (
        "import os, sys, zmq; os.setgid(65534); os.setuid(65534)\n"
        "push = zmq.Context().socket(zmq.PUSH); push.connect(sys.argv[1]); push.linger = 500\n"
        "monitor = push.get_monitor_socket(zmq.EVENT_DISCONNECTED)\n"
        "push.send(b'x' * 100); print(monitor.poll(5000))"
    )
    pushed = subprocess.run(
        [sys.executable, "-c", program, address], capture_output=True, text=True, check=True
    )
    assert pushed.stdout.strip() == "1", "it was not turned away"
    one.publish(v.LOG, Number(value=5))
    until(lambda: 5 in values(received), 5.0)
    assert not other.client.faults.counts


@pytest.mark.parametrize(
    "inbox", ["tcp://192.0.2.1:1", "ipc:///tmp/rune-x", "ipc://@rune-" + "x" * 100, "ipc://@other"]
)
def test_publisher_connects_to_nothing_but_inboxes(make: Make, inbox: str) -> None:
    one = make("one")
    one.publish(v.LOG, Number(value=1))
    wrong = Subscriber(name="T_Log", subscriber=1, inbox=inbox)
    one.call(lambda: one.client.session.publishers.subscriber(wrong))
    assert one.direct(v.LOG) == 0
    assert one.client.faults.counts["malformed control frame"] == 1


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
        "inboxes = client.session.subscriptions.inboxes.values()\n"
        "print([inbox.address for inbox in inboxes][0], flush=True)\n"
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


def test_publisher_that_finds_no_way_to_a_subscriber_publishes_to_the_others(make: Make) -> None:
    one, other, third = make("one"), make("other"), make("third")
    received, _ = other.collect(v.LOG), third.collect(v.LOG)
    for each in (other, third):
        each.stands()
    one.open(v.LOG)
    number = third.client.number
    nowhere = Subscriber(name="T_Log", subscriber=number, inbox="ipc:///nowhere")
    one.call(lambda: one.client.session.publishers.subscriber(nowhere))
    assert one.direct(v.LOG) == 1
    one.call(
        lambda: one.client.session.publishers.subscriber(Subscriber(name="", subscriber=number))
    )
    one.publish(v.LOG, Number(value=1))
    until(lambda: values(received) == [-1, 1], 5.0)


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


def test_way_to_a_neighbour_whose_connection_ended_is_made_anew(make: Make) -> None:
    one = make("one")
    one.publish(v.LOG, Number(value=0))
    one.call(lambda: one.client.wait_published(5.0))
    address = "ipc://@rune-state-0123456789abcdef"
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    subscriber = Subscriber(name="T_Log", subscriber=7, inbox=address)
    for number in (1, 2):
        inbox = context.socket(zmq.PULL)
        until(lambda inbox=inbox: _bound(inbox, address), 5.0)
        if number == 1:
            one.call(lambda: one.client.session.publishers.subscriber(subscriber))
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


def test_neighbour_that_could_not_be_reached_is_tried_again(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = make("one"), make("other")
    make_inbox = sockets.make_inbox
    full = threading.Event()
    full.set()

    def without_descriptors(context: Any, kind: int, plane: Plane, queue: int = 0) -> Any:
        if kind == zmq.PUSH and full.is_set():
            raise zmq.ZMQError(errno.EMFILE)
        return make_inbox(context, kind, plane, queue)

    monkeypatch.setattr(sockets, "make_inbox", without_descriptors)
    one.open(v.LOG)
    received = other.collect(v.LOG)
    until(lambda: one.client.faults.counts["no way to a subscriber"], 5.0)
    full.clear()
    other.stands()
    one.publish(v.LOG, Number(value=5))
    until(lambda: values(received) == [5], 5.0)


def test_neighbour_that_never_reads_holds_up_nobody(make: Make) -> None:
    one, stuck, other = make("one"), make("stuck"), make("other")
    stuck_got, received = stuck.collect(v.LOG), other.collect(v.LOG)
    for each in (stuck, other):
        each.stands()
    free = threading.Event()
    stuck.client.post(lambda: free.wait(10.0))
    for number in range(5000):
        one.publish(v.LOG, Number(value=number))
        if number % 500 == 499:
            until(lambda n=number: len(received) == n + 1, 5.0)
    free.set()
    # On a slow machine it was away for so long that it begins anew, without what lay there.
    until(
        lambda: stuck_got,
        10.0,
        meanwhile=lambda: one.publish(v.LOG, Number(value=5000)),
    )
    assert all(how.missed == 0 for _, how in received)
