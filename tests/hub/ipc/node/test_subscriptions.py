"""Subscriptions: nothing missed, limits and priorities, last values, shared memory."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from hub.errors import NoValueError
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.transport import shared_ring
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]


def _subscribed(peer: Peer, definition: MessageDefinition[Any], **options: Any) -> list[int]:
    """Values that come after a subscription that stands."""
    values: list[int] = []
    peer.call(
        lambda: peer.client.subscribe(definition, lambda n, _: values.append(n.value), **options)
    )
    peer.call(lambda: peer.client.wait_subscribed(5.0))
    return values


def _blocked(peer: Peer) -> threading.Event:
    """The peer does nothing until the event is set."""
    free, waiting = threading.Event(), threading.Event()

    def wait() -> None:
        waiting.set()
        free.wait(10.0)

    peer.client.post(wait)
    assert waiting.wait(5.0)
    return free


@pytest.mark.parametrize("definition", [v.LOG, v.EVENT], ids=lambda d: d.name)
def test_nothing_published_after_a_subscription_stands_is_missed(
    connect: Connect, definition: MessageDefinition[Number]
) -> None:
    """The publisher publishes all the time, so that a message that is missed shows as a gap."""
    one = connect("one")
    number = 0

    def publish() -> None:
        nonlocal number
        one.client.publish(definition, Number(value=number))
        number += 1

    one.call(lambda: one.client.every(0.0005, publish))
    for round_ in range(4):
        other = connect(f"other {round_}")
        values = _subscribed(other, definition)
        first = one.call(lambda: number)
        until(lambda values=values, first=first: values and values[-1] > first + 10, 5.0)
        # Before, one may come that was under way to somebody else, and the next not.
        after = [value for value in values if value >= first]
        assert after == list(range(first, first + len(after)))
        other.close()


@pytest.mark.parametrize("definition", [v.LOG, v.EVENT, v.PICTURE_NUMBER], ids=lambda d: d.name)
def test_first_message_of_a_new_publisher_reaches_who_has_subscribed(
    connect: Connect, definition: MessageDefinition[Number]
) -> None:
    subscribers = [_subscribed(connect(f"subscriber {n}"), definition) for n in range(3)]
    for number in range(5):
        connect(f"publisher {number}").publish(definition, Number(value=number))
    for values in subscribers:
        until(lambda values=values: sorted(values) == list(range(5)), 5.0, lambda: f"{subscribers}")


def test_message_nobody_wants_is_not_sent_and_waits_for_nobody(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    for number in range(5):
        one.publish(v.LOG, Number(value=number))
    until(lambda: not one.call(lambda: one.client.session.publishers.of(v.LOG).held), 5.0)
    values = _subscribed(other, v.LOG)
    one.publish(v.LOG, Number(value=7))
    until(lambda: values == [7], 5.0)


def test_unsubscribed_handler_is_called_no_more(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    kept = _subscribed(other, v.LOG)
    gone: list[int] = []

    def handler(value: Number, _: object) -> None:
        gone.append(value.value)

    other.call(lambda: other.client.subscribe(v.LOG, handler))
    one.publish(v.LOG, Number(value=1))
    until(lambda: kept == gone == [1], 5.0)
    other.call(lambda: other.client.unsubscribe(v.LOG, handler))
    one.publish(v.LOG, Number(value=2))
    until(lambda: kept == [1, 2], 5.0)
    other.call(lambda: other.client.unsubscribe(v.LOG))
    other.call(lambda: other.client.unsubscribe(v.STREAM))
    listed = lambda: one.call(lambda: one.client.directory.listing(5.0))  # noqa: E731
    until(lambda: {p.name: p.subscribes for p in listed().peers}["other"] == "", 5.0)
    again = _subscribed(other, v.LOG)
    one.publish(v.LOG, Number(value=3))
    until(lambda: again == [3], 5.0)
    assert (kept, gone) == ([1, 2], [1])


def test_queue_length_keeps_the_newest_and_says_what_it_left_out(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    _, received = _subscribed(other, v.LOG, queue=3), other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    free = _blocked(other)
    for number in range(20):
        one.publish(v.LOG, Number(value=number))
    one.call(lambda: one.client.directory.listing(5.0))
    until(lambda: other.client.session.subscriptions.files, 1.0)
    free.set()
    until(lambda: received[-1][0].value == 19, 5.0)
    values = [value.value for value, _ in received if value.value >= 0]
    assert values == sorted(values)
    numbers = [how.sequence for _, how in received]
    assert sum(1 + how.missed for _, how in received[1:]) == numbers[-1] - numbers[0]


def test_higher_priority_is_handed_on_first(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    order: list[str] = []
    for definition, priority in ((v.LOG, 0), (v.STREAM, 5), (v.ANSWER, -1)):
        other.call(
            lambda d=definition, p=priority: other.client.subscribe(
                d, lambda n, _: order.append(f"{d.name}{n.value}"), priority=p, queue=100
            )
        )
    other.call(lambda: other.client.wait_subscribed(5.0))
    for definition in (v.ANSWER, v.LOG, v.STREAM):
        one.publish(definition, Number(value=-1))
    until(lambda: len(order) == 3, 5.0)
    order.clear()
    free = _blocked(other)
    for number in range(3):
        for definition in (v.ANSWER, v.LOG, v.STREAM):
            one.publish(definition, Number(value=number))
    arrived = other.client.session.subscriptions.sockets
    until(lambda: arrived, 1.0)
    one.call(lambda: one.client.directory.listing(5.0))
    free.set()
    until(lambda: len(order) == 9, 5.0)
    names = [d.name for d in (v.STREAM, v.LOG, v.ANSWER)]
    expected = [f"{name}{number}" for name in names for number in range(3)]
    # What was still on its way when the first was handed on may come behind.
    assert [each for each in order if each.startswith(names[0])] == expected[:3]
    assert order.index(expected[0]) < order.index(expected[-1])


def test_burst_arrives_whole_in_order_and_with_the_time_of_each(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    other.call(lambda: other.client.wait_subscribed(5.0))
    one.publish_until(v.LOG, received)
    received.clear()

    def burst() -> None:
        for number in range(400):
            one.client.publish(v.LOG, Number(value=number))

    one.call(burst)
    until(lambda: len([1 for value, _ in received if value.value >= 0]) == 400, 5.0)
    values = [(value.value, how) for value, how in received if value.value >= 0]
    assert [value for value, _ in values] == list(range(400))
    sequences = [how.sequence for _, how in values]
    assert sequences == list(range(sequences[0], sequences[0] + 400))
    measured = [how.measured for _, how in values]
    assert measured == sorted(measured)
    assert len(set(measured)) > 300
    assert all(how.missed == 0 for _, how in values)


def test_end_of_a_burst_leaves_though_its_module_does_not_listen(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    values = _subscribed(other, v.LOG)
    one.publish(v.LOG, Number(value=-1))
    until(lambda: values, 5.0)
    free = threading.Event()

    def burst() -> None:
        for number in range(5):
            one.client.publish(v.LOG, Number(value=number))
        free.wait(10.0)

    one.client.post(burst)
    until(lambda: values == [-1, 0, 1, 2, 3, 4], 5.0)
    free.set()


def test_messages_of_one_publisher_keep_their_order_across_names(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    order: list[tuple[str, int]] = []
    for definition in (v.LOG, v.ANSWER):
        other.call(
            lambda d=definition: other.client.subscribe(
                d, lambda n, _: order.append((d.name, n.value)), queue=1000
            )
        )
    other.call(lambda: other.client.wait_subscribed(5.0))
    one.publish(v.LOG, Number(value=-1))
    one.publish(v.ANSWER, Number(value=-1))
    until(lambda: len(order) == 2, 5.0)
    order.clear()

    def burst() -> None:
        for number in range(90):
            one.client.publish((v.LOG, v.LOG, v.ANSWER)[number % 3], Number(value=number))

    one.call(burst)
    until(lambda: len(order) == 90, 5.0)
    assert [number for _, number in order] == list(range(90))


def test_late_joiner_gets_the_last_value_also_if_nobody_had_subscribed(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    for number in range(3):
        one.publish(v.LOG, Number(value=number))
    one.call(lambda: one.client.wait_published(5.0))
    ask = lambda d: other.call(lambda: other.client.last_value(d, timeout=5.0))  # noqa: E731
    assert ask(v.LOG) == Number(value=2)
    values = _subscribed(other, v.LOG, last=True)
    until(lambda: values == [2], 5.0)
    one.publish(v.LOG, Number(value=3))
    until(lambda: values == [2, 3], 5.0)
    with pytest.raises(NoValueError, match="no connected module publishes"):
        ask(v.STREAM)


def test_last_value_comes_also_to_who_asked_before_it_was_connected(
    central: Central, connect: Connect
) -> None:
    one = connect("one")
    one.publish(v.LOG, Number(value=7))
    one.call(lambda: one.client.wait_published(5.0))
    values: list[int] = []
    with closing(Client("early", central.endpoints[0])) as early:
        early.subscribe(v.LOG, lambda number, _: values.append(number.value), last=True)
        until(lambda: values == [7], 5.0, meanwhile=lambda: early.listen(0.01))


def test_payload_can_be_published_as_it_is(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    values = _subscribed(other, v.LOG)
    payload = b"".join(v.LOG.encode(Number(value=77)))
    one.call(lambda: one.client.publish_payload(v.LOG, payload))
    until(lambda: values == [77], 5.0)
    one.call(lambda: one.client.publish_payload(v.LOG, b"rubbish"))
    until(lambda: other.client.faults.counts["wrong format"] == 1, 5.0)
    assert values == [77]


def _picture(number: int, size: int = 57_600) -> v.Picture:
    pixels = np.full(size, number % 256, np.uint8)
    return v.Picture(name=str(number), count=size, pixels=pixels)


@pytest.mark.skipif(not shared_ring.available, reason="this system has no anonymous files")
@pytest.mark.parametrize("wanted_endpoint", ["ipc"], indirect=True)
def test_picture_goes_through_shared_memory_and_is_a_copy_of_its_own(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.RING_PICTURE)
    other.call(lambda: other.client.wait_subscribed(5.0))
    for number in range(100):
        one.publish(v.RING_PICTURE, _picture(number))
        until(lambda n=number: received and received[-1][0].name == str(n), 5.0)
    pictures = [value for value, _ in received]
    assert [bool((p.pixels == int(p.name)).all()) for p in pictures] == [True] * len(pictures)
    assert all(not how.missed for _, how in received)
    assert one.client.session.publishers.of(v.RING_PICTURE).ring.capacity > 0
    last = other.call(lambda: other.client.last_value(v.RING_PICTURE, timeout=5.0))
    assert last.name == "99"
    one.publish(v.RING_PICTURE, _picture(7, size=900_000))
    until(lambda: received[-1][0].count == 900_000, 5.0)
    assert not other.client.faults.counts


@pytest.mark.skipif(not shared_ring.available, reason="this system has no anonymous files")
@pytest.mark.parametrize("wanted_endpoint", ["ipc"], indirect=True)
@pytest.mark.parametrize("who", ["publisher", "subscriber"])
def test_picture_comes_the_plain_way_where_there_is_no_shared_memory(
    connect: Connect, who: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other, third = connect("one"), connect("other"), connect("third")
    if who == "publisher":

        def full(length: int) -> None:
            raise OSError(length)

        monkeypatch.setattr(shared_ring, "RingWriter", full)
    else:

        def gone(place: object) -> None:
            raise FileNotFoundError(str(place))

        monkeypatch.setattr(
            other.client.session.subscriptions.receive_queue.reader.rings, "read", gone
        )
    received, received_too = other.collect(v.RING_PICTURE), third.collect(v.RING_PICTURE)
    for each in (other, third):
        each.call(lambda each=each: each.client.wait_subscribed(5.0))
    numbers = iter(range(10_000))
    until(
        lambda: len(received) >= 3 and len(received_too) >= 3,
        5.0,
        meanwhile=lambda: (
            one.publish(v.RING_PICTURE, _picture(next(numbers))),
            threading.Event().wait(0.005),
        ),
    )
    assert all((p.pixels == int(p.name) % 256).all() for p, _ in received + received_too)
    assert other.client.faults.counts["no shared memory"] == 1
    assert not other.client.session.subscriptions.subscriptions[v.RING_PICTURE.name].in_ring


@pytest.mark.skipif(not shared_ring.available, reason="this system has no anonymous files")
@pytest.mark.parametrize("wanted_endpoint", ["ipc"], indirect=True)
def test_subscriber_that_was_busy_gets_the_newest_picture_and_counts_the_others(
    connect: Connect, central: Central
) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.RING_PICTURE)
    other.call(lambda: other.client.wait_subscribed(5.0))
    one.publish(v.RING_PICTURE, _picture(0))
    until(lambda: received, 5.0)
    free = _blocked(other)
    for number in range(1, 201):
        one.publish(v.RING_PICTURE, _picture(number))
    one.call(lambda: one.client.directory.listing(5.0))
    free.set()
    until(lambda: received[-1][0].name == "200", 5.0)
    assert sum(1 + how.missed for _, how in received) == 201
    assert all((p.pixels == int(p.name)).all() for p, _ in received)
    del central
