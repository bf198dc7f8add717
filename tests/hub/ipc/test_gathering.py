"""Messages that wait in the system until their receiver looks: none is lost, moved or changed."""

from __future__ import annotations

import random
import signal
import socket
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hub.errors import RedefinedMessageError
from hub.ipc.broker.central import Central
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.message_info import Gathered
from hub.values import dataclass
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer, on_one_transport
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]
ROOT = Path(__file__).parents[3]


@dataclass(frozen=True, slots=True, kw_only=True)
class Words:
    """A message of variable length."""

    text: str = ""


STREAM = MessageDefinition(name="test_words", type=Words, keep=Keep.NEWEST)
OLD = MessageDefinition(name="test_old", type=Words, lifespan_s=0.001)
ORDER = MessageDefinition(name="test_order", type=Words, plane=Plane.COMMAND, keep=Keep.ALL)
KILLED = textwrap.dedent("""
    import os, signal, sys
    from hub.ipc.client import Client
    from tests.hub.ipc.test_gathering import STREAM, Words
    client = Client("killed", sys.argv[1])
    client.wait_connected(10.0)
    client.publish(STREAM, Words(text="0"))
    client.wait_published(10.0)
    for number in range(1, 40):
        client.publish(STREAM, Words(text=str(number)))
        client.listen(0.001)
    print("said", flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
""")


class Gatherer:
    """A client that gathers, and what came to it."""

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        self.batches: list[list[Gathered]] = []
        peer.call(lambda: peer.client.gather(self.batches.append))

    def subscribe(self, *definitions: MessageDefinition[object]) -> Gatherer:
        def work() -> None:
            for each in definitions:
                self.peer.client.subscribe_gathered(each, each.name, last=True)

        self.peer.call(work)
        self.peer.call(lambda: self.peer.client.wait_subscribed(10.0))
        return self

    @property
    def came(self) -> list[Gathered]:
        return [each for batch in list(self.batches) for each in batch]

    def texts(self, definition: MessageDefinition[Words]) -> list[str]:
        return [definition.decode(each[1]).text for each in self.came if each[0] == definition.name]

    @property
    def lost(self) -> dict[str, int]:
        return self.peer.call(lambda: self.peer.client.lost_by_message)


@pytest.fixture
def gatherer(connect: Connect) -> Gatherer:
    return Gatherer(connect("gatherer"))


def test_all_come_in_order_with_numbers_and_times(gatherer: Gatherer, connect: Connect) -> None:
    one = connect("one")
    gatherer.subscribe(v.LOG, STREAM)
    begun = time.monotonic()
    for number in range(300):
        one.publish(STREAM, Words(text=f"word {number}"))
        one.publish(v.LOG, Number(value=number))
    until(lambda: len(gatherer.came) >= 600, 20.0)
    ended = time.monotonic()
    assert gatherer.texts(STREAM) == [f"word {number}" for number in range(300)]
    logs = [each for each in gatherer.came if each[0] == v.LOG.name]
    assert [v.LOG.decode(each[1]).value for each in logs] == list(range(300))
    assert [each[4] for each in logs] == list(range(1, 301))
    for batch in gatherer.batches:
        assert [each[2] for each in batch] == sorted(each[2] for each in batch)
    assert all(begun - 1.0 <= each[2] <= ended for each in gatherer.came)
    assert all(measured <= moment for _, _, moment, measured, *_ in gatherer.came)
    assert gatherer.lost == {}


@on_one_transport
def test_a_burst_beyond_all_queues_in_one_go(gatherer: Gatherer, connect: Connect) -> None:
    one = connect("one")
    gatherer.subscribe(STREAM, ORDER)
    one.publish(STREAM, Words(text="0"))
    one.publish(ORDER, Words(text="0"))
    one.call(lambda: one.client.wait_published(5.0))

    def publish() -> None:
        for number in range(1, 6000):
            one.client.publish(STREAM, Words(text=f"{number} " + "x" * 200))
            if number % 20 == 0:
                one.client.publish(ORDER, Words(text=str(number)))

    one.call(publish)
    until(lambda: len(gatherer.came) >= 6300, 20.0)
    assert [int(text.split()[0]) for text in gatherer.texts(STREAM)] == list(range(6000))
    assert gatherer.texts(ORDER) == [str(number) for number in range(0, 6000, 20)]
    assert gatherer.lost == {}


@on_one_transport
def test_a_receiver_that_stands_still_for_a_second_misses_nothing(
    gatherer: Gatherer, connect: Connect
) -> None:
    one = connect("one")
    gatherer.subscribe(ORDER)
    one.publish(ORDER, Words(text="0"))
    one.call(lambda: one.client.wait_published(5.0))

    def publish() -> None:
        for number in range(1, 5000):  # commands travel alone
            one.client.publish(ORDER, Words(text=str(number)))

    gatherer.peer.call(lambda: one.call(publish), 20.0)
    until(lambda: len(gatherer.came) >= 5000, 20.0)
    assert gatherer.texts(ORDER) == [str(number) for number in range(5000)]
    assert gatherer.lost == {}


@on_one_transport
def test_messages_wait_for_a_receiver_that_is_busy(gatherer: Gatherer, connect: Connect) -> None:
    one = connect("one")
    gatherer.subscribe(STREAM)

    def publish_meanwhile() -> None:
        for number in range(200):
            one.publish(STREAM, Words(text=str(number)))

    gatherer.peer.call(publish_meanwhile, 20.0)  # in the gatherer's own thread
    until(lambda: len(gatherer.came) >= 200, 20.0)
    assert gatherer.texts(STREAM) == [str(number) for number in range(200)]


def test_the_last_message_before_the_subscription_comes(
    gatherer: Gatherer, connect: Connect
) -> None:
    one = connect("one")
    one.publish(STREAM, Words(text="before"))
    until(lambda: one.client.connected, 10.0)
    gatherer.subscribe(STREAM)
    until(lambda: gatherer.texts(STREAM), 10.0)
    assert gatherer.texts(STREAM) == ["before"]


def test_messages_beyond_their_lifespan_come_too(gatherer: Gatherer, connect: Connect) -> None:
    one = connect("one")
    gatherer.subscribe(OLD)
    one.publish(OLD, Words(text="late"), age=5.0)
    until(lambda: gatherer.texts(OLD), 10.0)


def test_one_client_gets_values_or_payloads_of_a_message(gatherer: Gatherer) -> None:
    gatherer.peer.collect(v.LOG)
    with pytest.raises(RedefinedMessageError, match="as values and as payloads"):
        gatherer.subscribe(v.LOG)


@on_one_transport
def test_an_old_measurement_does_not_move_the_moment(gatherer: Gatherer, connect: Connect) -> None:
    one = connect("one")
    gatherer.subscribe(STREAM)
    begun = time.monotonic()
    one.publish(STREAM, Words(text="old"), age=5.0)
    until(lambda: gatherer.came, 10.0)
    _, _, came, measured, *_ = gatherer.came[0]
    assert begun - 0.5 <= came <= time.monotonic()
    assert measured == pytest.approx(begun - 5.0, abs=1.0)


@on_one_transport
def test_the_last_words_of_a_killed_module_come(gatherer: Gatherer, central: Central) -> None:
    gatherer.subscribe(STREAM)
    child = subprocess.run(
        [sys.executable, "-c", KILLED, central.endpoints[0]],
        capture_output=True, cwd=ROOT, check=False,
    )  # fmt: skip
    assert child.returncode == -signal.SIGKILL, child.stderr
    # A thread of the killed process sends; on a busy machine it may lack the last few.
    until(lambda: len(gatherer.came) > 30, 10.0)
    came = gatherer.texts(STREAM)
    assert came == [str(number) for number in range(len(came))]


@on_one_transport
def test_two_batches_of_equal_messages_are_counted_apart(
    gatherer: Gatherer, connect: Connect
) -> None:
    one, other = connect("one"), connect("other")
    gatherer.subscribe(STREAM)
    for number in range(50):
        one.publish(STREAM, Words(text=f"a{number}"))
        other.publish(STREAM, Words(text=f"b{number}"))
    until(lambda: len(gatherer.came) >= 100, 20.0)
    for letter in "ab":
        texts = [text for text in gatherer.texts(STREAM) if text.startswith(letter)]
        assert texts == [f"{letter}{number}" for number in range(50)]
    assert gatherer.lost == {}


@on_one_transport
def test_nothing_comes_after_the_end_of_a_subscription(
    gatherer: Gatherer, connect: Connect
) -> None:
    one = connect("one")
    gatherer.subscribe(STREAM, ORDER)
    one.publish(STREAM, Words(text="first"))
    until(lambda: gatherer.texts(STREAM), 10.0)
    gatherer.peer.call(lambda: gatherer.peer.client.unsubscribe(STREAM))
    one.publish(STREAM, Words(text="second"))
    one.publish(ORDER, Words(text="last"))
    until(lambda: gatherer.texts(ORDER), 10.0)
    assert gatherer.texts(STREAM) == ["first"]


@on_one_transport
def test_a_stranger_at_the_inbox_disturbs_nobody(gatherer: Gatherer, connect: Connect) -> None:
    one = connect("one")
    gatherer.subscribe(STREAM)
    address = gatherer.peer.call(
        lambda: gatherer.peer.client.session.subscriptions.inboxes[Plane.STATE].address
    )
    for rubbish in (b"GET / HTTP/1.1\r\n\r\n" * 9, random.Random(1).randbytes(4096), b""):
        with socket.socket(socket.AF_UNIX) as stranger:
            stranger.connect("\0" + address.removeprefix("ipc://@"))
            stranger.sendall(rubbish)
    one.publish(STREAM, Words(text="still here"))
    until(lambda: gatherer.texts(STREAM), 10.0)
    assert gatherer.peer.faults == []


@on_one_transport
def test_a_client_gathers_before_it_subscribes(connect: Connect) -> None:
    one = connect("one")
    with pytest.raises(RedefinedMessageError, match="before its client gathers"):
        one.call(lambda: one.client.subscribe_gathered(STREAM, "x"))
