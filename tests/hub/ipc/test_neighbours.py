"""Broadcasts that pass central by: nothing missed, nothing twice, and no stranger gets in."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest

from hub.errors import CodecError, HandlerFailedError, QueryError
from hub.ipc.definition import Keep, MessageDefinition
from hub.ipc.node import receive_queue
from hub.ipc.transport import sockets
from hub.ipc.transport.clock_sync import this_neighbourhood
from hub.ipc.wire import frames
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Make, values
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

pytestmark = pytest.mark.skipif(not this_neighbourhood(), reason="this system has no neighbours")


@pytest.fixture
def wanted_endpoint() -> str:
    return "tcp://127.0.0.1:0"


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
        peer.stands()
    for start, peer in zip((0, 1000), publishers, strict=True):
        for number in range(200):
            peer.publish(definition, Number(value=start + number))
            expected.append(start + number)
    for each in received:
        until(lambda each=each: len(each) >= 400, 5.0)
        assert sorted(values(each)) == expected
        assert all(how.missed == 0 for _, how in each)
        assert [x for x in values(each) if x < 1000] == expected[:200]


def test_what_goes_to_neighbours_alone_is_not_sent_to_central(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    other.stands()
    one.publish(v.LOG, Number(value=1))
    until(lambda: received, 5.0)
    publisher = one.client.session.publishers.of(v.LOG)
    assert len(publisher.direct) == 1
    assert publisher.topic not in one.client.session.publishers.queue.topics


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
    other.stands()
    one.open(*names)
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
    other.stands()
    one.open(v.LOG, v.LOG_TOO)

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
        each.stands()
    one.publish(v.LOG, Number(value=1))
    until(lambda: received and too, 5.0)
    other.call(lambda: other.client.unsubscribe(v.LOG))
    until(lambda: one.direct(v.LOG) == 1, 5.0)
    third.close()
    until(lambda: one.direct(v.LOG) == 0, 5.0)
    one.publish(v.LOG, Number(value=2))
    assert values(received) == values(too) == [1]
    until(lambda: not one.client.session.publishers.direct_sockets, 10.0, "a way stayed open")


def test_nothing_is_lost_while_subscribers_come_and_go(make: Make) -> None:
    """The one that stays gets every message whatever the others do."""
    one, stays = make("one"), make("stays")
    received = stays.collect(v.LOG)
    stays.stands()
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
        got = values(came)
        assert got == list(range(got[0], got[0] + len(got)))
        passer_by.close()
    stop.set()
    one.call(lambda: None)
    until(lambda: len(received) == len(sent), 5.0)
    assert values(received) == sent


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
    other.stands()
    for size in (frames.MAX_FRAME - 100, frames.MAX_FRAME, 10):
        one.publish(LARGE, _large(size))
        one.call(lambda: one.client.wait_published(5.0))
    until(lambda: len(received) == 2, 5.0)
    assert [value.count for value, _ in received] == [frames.MAX_FRAME - 100, 10]
    assert [how.missed for _, how in received] == [0, 1]
    assert one.client.faults.counts == {"too long": 1}


def test_last_value_that_is_too_long_for_a_frame_is_none(make: Make) -> None:
    one, other = make("one"), make("other")
    number = one.client.number
    one.publish(LARGE, _large(frames.MAX_FRAME))
    one.call(lambda: one.client.wait_published(5.0))
    with pytest.raises(QueryError):
        other.call(lambda: other.client.last_value(LARGE, timeout=5.0))
    assert one.client.number == number


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
    other.stands()
    one.open(v.LOG)
    other.client.post(subscribe_again)
    one.call(lambda: publish(0))
    for step, takers in zip(steps, (0, 1), strict=False):
        step.set()
        until(lambda takers=takers: one.direct(v.LOG) == takers, 5.0)
    one.call(lambda: publish(200))
    steps[2].set()
    until(lambda: received[-1:] == [399], 5.0)
    assert received == sorted(set(received))
    assert not other.client.faults.counts


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
    other.stands()
    for number in range(3):
        one.publish(v.LOG, Number(value=number))
    until(lambda: values(third) == [0, 1, 2], 5.0)
    assert received == [0]


def test_last_value_does_not_overtake_what_waits_in_the_inbox(make: Make) -> None:
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)
    other.stands()
    one.open(v.LOG)

    def publish() -> None:
        for number in range(10):
            one.client.publish(v.LOG, Number(value=number))

    def held_up() -> None:
        one.call(publish)
        other.client.subscribe(v.LOG, lambda *_: None, last=True)
        control_socket = other.client.session.connection.channel.socket
        until(lambda: sockets.readable(control_socket), 5.0, "no last value came")

    until(lambda: received, 5.0)
    other.call(held_up)
    until(lambda: len(received) > 10, 5.0, lambda: str(values(received)))
    assert values(received) == list(range(-1, 10))
    assert not other.client.faults.counts


@pytest.mark.parametrize("handler", ["slow", "raising"])
def test_inbox_is_read_on_after_a_last_value_came_while_it_was_full(
    make: Make, monkeypatch: pytest.MonkeyPatch, handler: str
) -> None:
    """An inbox tells of what comes only after it was found empty."""
    one, other = make("one"), make("other")
    received = other.collect(v.LOG)

    def hinder(value: Number, how: Any) -> None:
        del how
        if handler == "raising" and value.value == 0:
            raise ValueError

    other.call(lambda: other.client.subscribe(v.LOG, hinder))
    other.stands()
    one.open(v.LOG)
    until(lambda: received, 5.0)
    if handler == "slow":
        monkeypatch.setattr(receive_queue, "SLICE_S", -1.0)

    def held_up() -> None:
        for number in range(3):
            one.publish(v.LOG, Number(value=number))
        other.client.subscribe(v.LOG, lambda *_: None, last=True)
        control_socket = other.client.session.connection.channel.socket
        until(lambda: sockets.readable(control_socket), 5.0, "no last value came")

    other.call(held_up)
    until(lambda: len(received) > 3, 5.0, lambda: str(values(received)))
    one.publish(v.LOG, Number(value=3))
    until(lambda: len(received) > 4, 5.0, lambda: str(values(received)))
    assert values(received) == list(range(-1, 4))


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
