"""What central tells of everybody, and what it does when asked."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from hub.errors import UnknownModuleError
from hub.ipc.broker.central import Central
from hub.ipc.wire.control import Change, Presence
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]


def test_who_watches_is_told_of_everybody_that_comes_and_goes(connect: Connect) -> None:
    one = connect("one")
    told: list[Presence] = []
    one.call(lambda: one.client.directory.watch(told.append))
    one.call(lambda: one.client.directory.listing(5.0))
    other = connect("other")
    other.call(lambda: other.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    other.call(lambda: other.client.wait_defined(5.0))
    other.call(lambda: other.client.directory.listing(5.0))
    listing = one.call(lambda: one.client.directory.listing(5.0))
    assert [peer.name for peer in listing.peers if v.ASK.name in peer.handles.split()] == ["other"]
    assert v.ASK.name in {entry.name for entry in listing.definitions}
    other.close()
    until(lambda: told and told[-1].change is Change.DISCONNECTED, 5.0)
    changes = [(each.change, each.message, each.count) for each in told if each.module == "other"]
    assert changes == [
        (Change.CONNECTED, "", 0),
        (Change.DEFINED, v.ASK.name, 0),
        (Change.DEFINED, v.ANSWER.name, 0),
        (Change.HANDLERS, v.ASK.name, 1),
        (Change.HANDLERS, v.ASK.name, 0),
        (Change.DISCONNECTED, "", 0),
    ]


def test_closed_module_stays_away_and_knows_who_closed_it(
    connect: Connect, central: Central
) -> None:
    one, other = connect("one"), connect("other")
    one.call(lambda: one.client.directory.close_module("other", timeout=5.0))
    until(lambda: other.client.closed_by == "one" and not other.client.connected, 5.0)
    other.publish(v.LOG, Number(value=1))
    until(lambda: central.connected() == ("one",), 5.0)
    with pytest.raises(UnknownModuleError, match="'other' is connected"):
        one.call(lambda: one.client.directory.close_module("other", timeout=5.0))
    assert connect("other").client.connected


def test_losses_and_ages_that_subscribers_see_are_listed(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = other.collect(v.LOG)
    one.publish_until(v.LOG, received)

    def skip() -> None:
        one.client.session.publishers.of(v.LOG).sequence += 5

    one.call(skip)
    one.publish(v.LOG, Number(value=1), age=3.0)

    def listed() -> tuple[int, bool]:
        listing = one.call(lambda: one.client.directory.listing(5.0))
        entry = next(entry for entry in listing.definitions if entry.name == v.LOG.name)
        return entry.lost, entry.oldest_s >= 3.0

    until(lambda: listed() == (5, True), 10.0)


def test_several_handlers_share_the_queries_and_take_over(connect: Connect) -> None:
    one, first, second = connect("one"), connect("first"), connect("second")
    replies: list[object] = []
    first.call(
        lambda: first.client.respond_later(v.ASK, v.ANSWER, lambda _, reply: replies.append(reply))
    )
    first.call(lambda: first.client.directory.listing(5.0))
    second.call(lambda: second.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    second.call(lambda: second.client.wait_defined(5.0))
    second.call(lambda: second.client.directory.listing(5.0))
    answers: list[int] = []
    failures: list[Exception] = []
    for number in range(4):
        one.call(
            lambda n=number: one.client.query_notify(
                v.ASK,
                Number(value=n),
                v.ANSWER,
                timeout=20.0,
                answered=lambda value, _: answers.append(value.value),
                failed=failures.append,
            )
        )
    until(lambda: replies and answers, 5.0)
    first.close()
    until(lambda: sorted(answers) == [0, 1, 2, 3], 5.0)
    assert not failures


def test_answer_may_be_given_later_and_from_a_timer(connect: Connect) -> None:
    one, other = connect("one"), connect("other")

    def later(ask: Number, reply: Any) -> None:
        other.client.loop.after(0.02, lambda: reply.answer(Number(value=ask.value + 1)))

    other.call(lambda: other.client.respond_later(v.ASK, v.ANSWER, later))
    other.call(lambda: other.client.wait_defined(5.0))
    other.call(lambda: other.client.directory.listing(5.0))
    ask = lambda: one.client.query_response(v.ASK, Number(value=1), v.ANSWER, timeout=5.0)  # noqa: E731
    assert one.call(ask) == Number(value=2)


def test_question_is_asked_again_when_central_has_forgotten_who_asks(
    connect: Connect, central: Central
) -> None:
    one = connect("one")
    (peer,) = central.registry.peers
    forgotten = threading.Event()
    central.loop.post(lambda: (central.registry.unreachable(peer.identity), forgotten.set()))
    assert forgotten.wait(5.0)
    listing = one.call(lambda: one.client.directory.listing(5.0))
    assert [each.name for each in listing.peers] == ["one"]
