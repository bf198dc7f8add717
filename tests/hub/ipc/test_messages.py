"""Publish and subscribe through a real central, over TCP and over Unix sockets."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from hub.errors import CodecError, RedefinedMessageError
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.transport.timers import Timers
from hub.ipc.wire import control
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Make, Peer, on_one_transport
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]


def sequence_of(peer: Peer, definition: MessageDefinition) -> int:
    return peer.client.session.publishers.of(definition).sequence


def set_sequence(peer: Peer, definition: MessageDefinition, sequence: int) -> None:
    peer.client.session.publishers.of(definition).sequence = sequence


def _values(received: list) -> list[int]:
    return [value.value for value, _ in received if value.value >= 0]


def test_message_arrives_typed_and_with_how_it_came(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    for number in range(3):
        one.publish(v.LOG, Number(value=number))
    until(lambda: _values(received) == [0, 1, 2], 5.0)
    value, how = received[-1]
    assert type(value) is Number
    assert how.publisher == one.client.number > 0
    assert how.sequence == sequence_of(one, v.LOG)
    assert how.missed == 0
    assert 0.0 <= how.age < 5.0
    assert not other.faults


def test_message_reaches_every_subscriber_also_the_publisher_itself(connect: Connect) -> None:
    peers = [connect(name) for name in "abc"]
    lists = [peer.collect(v.LOG) for peer in peers]
    for received in lists:
        peers[0].publish_until(v.LOG, received)
    peers[0].publish(v.LOG, Number(value=5))
    until(lambda: all(_values(received) == [5] for received in lists), 5.0)


@on_one_transport
def test_several_handlers_of_one_message_are_called_in_turn(connect: Connect) -> None:
    one = connect("one")
    first, second = one.collect(v.LOG), one.collect(v.LOG)
    one.publish_until(v.LOG, second)
    assert len(first) == len(second)


def test_subscription_does_not_take_messages_with_a_longer_name(connect: Connect) -> None:
    one = connect("one")
    short, long = one.collect(v.STREAM), one.collect(v.STREAM_LONGER_NAME)
    one.publish_until(v.STREAM_LONGER_NAME, long)
    one.publish_until(v.STREAM, short)
    assert {how.sequence for _, how in short} <= set(range(1, len(short) + 50))
    assert not one.client.faults.counts


def test_large_picture_arrives_whole(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.PICTURE)
    pixels = np.random.default_rng(0).integers(0, 256, 57_600, np.uint8)
    picture = v.Picture(name="ä", count=len(pixels), pixels=pixels)
    until(lambda: received, 5.0, meanwhile=lambda: one.publish(v.PICTURE, picture))
    assert received[0][0].name == "ä"
    assert np.array_equal(received[0][0].pixels, pixels)


def _burst(connect: Connect, definition, count: int) -> tuple[Peer, list]:
    """Publish `count` messages while the subscriber is busy, until another one has them.

    It must not be busy for long: who does not listen for 1.5 s is taken for dead.
    """
    one, other = connect("one"), connect("other")
    received = other.collect(definition)
    seen = connect("witness").collect(definition)
    one.publish_until(definition, received)
    one.publish_until(definition, seen)
    free = threading.Event()
    other.client.post(lambda: free.wait(1.0))
    for number in range(count):
        one.publish(definition, Number(value=number))
    until(lambda: count - 1 in _values(seen), 5.0)
    free.set()
    until(lambda: count - 1 in _values(received), 5.0, lambda: f"{received}")
    return other, received


def test_stream_hands_on_the_newest_after_a_burst_and_says_what_it_left_out(
    connect: Connect,
) -> None:
    other, received = _burst(connect, v.STREAM, 100)
    values = _values(received)
    assert values == sorted(values)
    assert len(values) < 100
    numbers = [how.sequence for _, how in received]
    assert sum(1 + how.missed for _, how in received[1:]) == numbers[-1] - numbers[0]
    assert other.client.lost == 0, "what newer ones overtook is not lost"


@pytest.mark.parametrize("definition", [v.LOG, v.EVENT], ids=lambda d: d.name)
def test_events_are_all_handed_on_after_a_burst(connect: Connect, definition) -> None:
    _, received = _burst(connect, definition, 24)
    assert _values(received) == list(range(24))
    assert all(how.missed == 0 for value, how in received if value.value >= 0)


@pytest.mark.parametrize("definition", [v.LOG, v.EVENT], ids=lambda d: d.name)
def test_events_that_came_before_a_module_was_taken_for_dead_are_handed_on(
    connect: Connect, central: Central, definition
) -> None:
    one, late = connect("one"), [0.0]
    deaf = Client("deaf", central.endpoints[0], clock=lambda: time.monotonic() + late[0])
    received: list[int] = []
    deaf.subscribe(definition, lambda value, _: received.append(value.value))
    streamed: list[int] = []
    deaf.subscribe(v.COMMAND, lambda value, _: streamed.append(value.value))
    deaf.wait_subscribed(5.0)
    seen = connect("witness").collect(definition)
    one.publish_until(definition, seen)
    until(lambda: received, 20.0, meanwhile=lambda: deaf.listen(0.01))
    one.publish(v.COMMAND, Number(value=1))
    for number in range(24):
        one.publish(definition, Number(value=number))
    until(lambda: 23 in _values(seen), 20.0)
    late[0] = 10.0  # all that came lies in the sockets, and nobody looks for 10 s
    until(lambda: 23 in received, 20.0, meanwhile=lambda: deaf.listen(0.01))
    assert [value for value in received if value >= 0] == list(range(24))
    assert deaf.faults.counts["too old"] == 0
    assert not streamed, "commands are not kept"
    deaf.close()


def test_gap_in_the_sequence_is_told(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    one.publish(v.LOG, Number(value=0))
    set_sequence(one, v.LOG, sequence_of(one, v.LOG) + 3)
    one.publish(v.LOG, Number(value=1))
    until(lambda: _values(received) == [0, 1], 5.0)
    assert [how.missed for value, how in received if value.value >= 0] == [0, 3]
    assert other.client.lost == 3


@on_one_transport
def test_value_that_does_not_fit_is_refused_and_makes_no_gap(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    with pytest.raises(CodecError):
        one.publish(v.LOG, Number(value=2**40))
    one.publish(v.LOG, Number(value=1))
    until(lambda: _values(received) == [1], 5.0)
    assert received[-1][1].missed == 0


def test_queries_make_no_gap_in_the_broadcasts_of_the_same_message(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.ANSWER)
    one.call(lambda: one.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    one.publish_until(v.ANSWER, received)
    for number in range(3):
        other.call(lambda: other.client.query_response(v.ASK, Number(value=1), v.ANSWER, timeout=5))
        one.publish(v.ANSWER, Number(value=number))
        # Of this message the newest alone is kept.
        until(lambda n=number: _values(received) == list(range(n + 1)), 5.0)
    assert [how.missed for value, how in received if value.value >= 0] == [0, 0, 0]


def test_old_message_is_dropped_and_counted(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.COMMAND)
    one.publish_until(v.COMMAND, received)
    one.publish(v.COMMAND, Number(value=1), age=10.0)
    until(lambda: other.client.faults.counts["too old"] == 1, 5.0)
    one.publish(v.COMMAND, Number(value=2))
    until(lambda: _values(received) == [2], 5.0)
    assert received[-1][1].missed == 1


def test_a_command_from_the_future_is_dropped_and_counted(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.COMMAND)
    states = other.collect(v.LOG)
    one.publish_until(v.COMMAND, received)
    one.publish_until(v.LOG, states)
    one.publish(v.COMMAND, Number(value=1), age=-10.0)
    until(lambda: other.client.faults.counts["stamp ahead of the clock"] == 1, 5.0)
    one.publish(v.COMMAND, Number(value=2))
    until(lambda: _values(received) == [2], 5.0)
    one.publish(v.LOG, Number(value=3), age=-10.0)  # what does not command is still shown
    until(lambda: _values(states) == [3], 5.0)
    assert states[-1][1].age == 0.0
    events = other.collect(v.EVENT)
    one.publish_until(v.EVENT, events)
    one.publish(v.EVENT, Number(value=4), age=-10.0)
    until(lambda: _values(events)[-1:] == [4], 5.0)
    assert events[-1][1].age == math.inf, "nobody knows how old such an order is"


def test_age_is_told_for_what_was_measured_earlier(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    one.publish(v.LOG, Number(value=1), age=100.0)
    until(lambda: _values(received) == [1], 5.0)
    assert 99.0 < received[-1][1].age < 110.0


def test_repeated_sequence_number_is_dropped(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    set_sequence(one, v.LOG, 0)
    one.publish(v.LOG, Number(value=1))
    until(lambda: other.client.faults.counts["out of order"] == 1, 5.0)
    assert _values(received) == []


@on_one_transport
def test_handler_that_fails_costs_no_other_message(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)

    def fail(value: Number, how: object) -> None:
        del how
        if value.value == 3:
            raise ZeroDivisionError

    other.call(lambda: other.client.subscribe(v.LOG, fail))
    one.publish_until(v.LOG, received)
    for number in range(20):
        one.publish(v.LOG, Number(value=number))
    until(lambda: len(_values(received)) == 20, 5.0)
    until(lambda: [type(error) for error in other.faults] == [ZeroDivisionError], 10.0)


def test_message_in_another_format_is_refused_by_central_and_dropped_by_subscribers(
    connect: Connect, central: Central
) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.STREAM)
    one.publish_until(v.STREAM, received)
    wrong = connect("wrong")

    def define() -> None:
        wrong.client.define(v.OTHER_STREAM)
        wrong.client.wait_defined(5.0)

    with pytest.raises(RedefinedMessageError, match=r"defined as \{int\} by .*wrong wants"):
        wrong.call(define)
    until(
        lambda: other.client.faults.counts["wrong format"],
        5.0,
        meanwhile=lambda: wrong.publish(v.OTHER_STREAM, Number(value=1)),
    )
    if central.endpoints[0].startswith("tcp"):  # else it never sees them
        until(lambda: central.faults.counts["wrong format"], 5.0)
    assert _values(received) == []
    assert not other.faults


@on_one_transport
def test_one_client_cannot_use_a_message_in_two_formats(connect: Connect) -> None:
    one = connect("one")
    one.call(lambda: one.client.define(v.STREAM))
    with pytest.raises(RedefinedMessageError, match="keep to one"):
        one.publish(v.OTHER_STREAM, Number(value=1))


@on_one_transport
def test_definitions_peers_and_counts_are_listed(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)
    one.call(lambda: one.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    one.call(lambda: one.client.wait_defined(5.0))

    def listed() -> control.Listing:
        return one.call(lambda: one.client.directory.listing(5.0))

    until(lambda: any(entry.messages for entry in listed().definitions), 5.0)
    listing = listed()
    assert {peer.name: peer.handles for peer in listing.peers} == {"one": "T_Ask", "other": ""}
    assert all(peer.pid == os.getpid() for peer in listing.peers)
    log = next(entry for entry in listing.definitions if entry.name == "T_Log")
    assert (log.format, log.keep, log.plane, log.fields) == ("{int}", "all", "state", "value")
    assert log.messages >= len(received)
    assert log.bytes == 8 * log.messages
    assert log.messages_per_s > 0
    assert log.bytes_per_s == pytest.approx(8 * log.messages_per_s)


@on_one_transport
def test_post_works_from_many_threads_at_once(connect: Connect) -> None:
    one = connect("one")
    done: list[int] = []
    threads = [
        threading.Thread(
            target=lambda: [one.client.post(lambda: done.append(1)) for _ in range(500)]
        )
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    until(lambda: len(done) == 2000, 5.0)


@on_one_transport
def test_posted_work_after_one_that_fails_is_still_done(connect: Connect) -> None:
    one = connect("one")
    free = threading.Event()
    one.client.post(lambda: free.wait(5.0))
    one.client.post(lambda: 1 // 0)
    done = threading.Event()
    one.client.post(done.set)
    free.set()
    assert done.wait(5.0)
    until(lambda: [type(error) for error in one.faults] == [ZeroDivisionError], 10.0)


@on_one_transport
def test_timer_is_called_again_and_again(connect: Connect) -> None:
    one = connect("one")
    calls: list[float] = []
    one.call(lambda: one.client.every(0.01, lambda: calls.append(0.0)))
    until(lambda: len(calls) >= 5, 5.0)


def test_late_timer_calls_are_skipped_not_made_up_for() -> None:
    timers, calls = Timers(), []
    timers.add(0.0, 1.0, lambda: calls.append(1))
    assert timers.due(9.0) == 1.0
    timers.run(0.9)
    assert calls == []
    timers.run(1.0)
    assert len(calls) == 1
    timers.run(50.0)
    timers.run(50.9)
    assert len(calls) == 2
    timers.run(51.0)
    assert len(calls) == 3
    assert Timers().due(9.0) == 9.0


@on_one_transport
def test_watched_file_is_served_until_it_is_unwatched(connect: Connect) -> None:
    one = connect("one")
    reading, writing = os.pipe()
    try:
        read: list[bytes] = []
        one.call(lambda: one.client.loop.watch(reading, lambda: read.append(os.read(reading, 10))))
        os.write(writing, b"a")
        until(lambda: read == [b"a"], 5.0)
        one.call(lambda: one.client.loop.unwatch(reading))
        os.write(writing, b"b")
        one.call(lambda: one.client.listen(0.0))
        assert read == [b"a"]
    finally:
        os.close(reading)
        os.close(writing)


@on_one_transport
def test_listen_returns_after_its_time(central: Central) -> None:
    client = Client("one", central.endpoints[0])
    try:
        for _ in range(20):
            client.listen(0.0)
        client.wait_connected(5.0)
        client.listen(0.01)
        assert client.connected
    finally:
        client.close()


@on_one_transport
def test_reception_is_a_frozen_value(connect: Connect) -> None:
    one = connect("one")
    received = one.collect(v.LOG)
    one.publish_until(v.LOG, received)
    with pytest.raises(AttributeError):
        received[0][1].age = 0.0


@pytest.mark.parametrize("near", [True, False])
@pytest.mark.parametrize("other_near", [True, False])
def test_publisher_knows_whether_anybody_subscribes(
    make: Make, *, near: bool, other_near: bool
) -> None:
    one, other = make("one", near=near), make("other", near=other_near)
    other.collect(v.LOG)
    other.stands()
    one.open(v.LOG, v.EVENT)
    assert one.call(lambda: one.client.has_subscribers(v.LOG))
    assert not one.call(lambda: one.client.has_subscribers(v.EVENT))
    other.close()
    until(lambda: not one.call(lambda: one.client.has_subscribers(v.LOG)), 5.0)


def test_two_messages_close_to_each_other_wake_no_thread(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.STREAM), other.collect(v.LOG)
    one.publish_until(v.STREAM, received[0])
    one.publish_until(v.LOG, received[1])

    def pair() -> None:
        for definition in (v.STREAM, v.LOG):
            one.client.publish(definition, Number(value=99))

    calm = time.monotonic() + 0.01
    until(lambda: time.monotonic() > calm, 5.0)
    one.call(pair)
    until(lambda: all(99 in _values(each) for each in received), 5.0)
    assert "rune-flush" not in {thread.name for thread in threading.enumerate()}
