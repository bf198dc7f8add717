"""The short way of queries between two modules of one machine: as safe as the long one."""

from __future__ import annotations

import contextlib
import random
import threading
from collections.abc import Callable
from typing import Any

import pytest
import zmq

from hub.errors import HandlerDiedError, NoHandlerError, QueryError
from hub.ipc.broker.central import Central
from hub.ipc.node.responders import Reply
from hub.ipc.transport.clock_sync import this_neighbourhood
from hub.ipc.wire import control, control_codec
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]

pytestmark = [
    pytest.mark.skipif(not this_neighbourhood(), reason="this system has no such sockets"),
    pytest.mark.parametrize("wanted_endpoint", ["ipc"], indirect=True),
]


def _ask(peer: Peer, number: int = 1) -> int:
    return peer.call(
        lambda: peer.client.query_response(v.ASK, Number(value=number), v.ANSWER, timeout=5.0)
    ).value


def _responding(peer: Peer, plus: int = 0) -> Peer:
    peer.call(
        lambda: peer.client.respond(v.ASK, v.ANSWER, lambda ask: Number(value=ask.value + plus))
    )
    peer.call(lambda: peer.client.wait_defined(5.0))
    peer.call(lambda: peer.client.directory.listing(5.0))
    return peer


def _on_the_short_way(asker: Peer, central: Central) -> None:
    """Ask until central hears nothing of it any more."""

    def short() -> bool:
        before = central.registry.queries.routing.last
        for number in range(10):
            _ask(asker, number + 1)
        return central.registry.queries.routing.last == before

    until(short, 5.0)
    assert asker.client.session.pending_queries.requesters()


def test_queries_go_directly_once_central_has_said_where(
    connect: Connect, central: Central
) -> None:
    asker, _ = connect("asker"), _responding(connect("handler"))
    _on_the_short_way(asker, central)
    answers: list[int] = []
    for number in range(100):
        asker.call(
            lambda n=number: asker.client.query_notify(
                v.ASK,
                Number(value=n),
                v.ANSWER,
                timeout=5.0,
                answered=lambda value, _: answers.append(value.value),
                failed=lambda _: answers.append(-1),
            )
        )
    until(lambda: len(answers) == 100, 5.0)
    assert answers == list(range(100))


def test_second_handler_brings_central_back_which_shares_the_queries(
    connect: Connect, central: Central
) -> None:
    asker, first = connect("asker"), _responding(connect("first"))
    _on_the_short_way(asker, central)
    second = _responding(connect("second"), plus=100)
    until(lambda: not asker.client.session.pending_queries.requesters(), 5.0)
    assert _ask(asker, 1) in (1, 101)
    first.close()

    def asks_the_second() -> bool:
        with contextlib.suppress(QueryError):  # one that was under way to the first
            return _ask(asker, 1) == 101
        return False

    until(asks_the_second, 5.0)
    _on_the_short_way(asker, central)
    second.close()
    with pytest.raises((NoHandlerError, HandlerDiedError)):
        _ask(asker)


def test_handler_that_leaves_ends_what_was_asked_directly_or_another_takes_over(
    connect: Connect, central: Central
) -> None:
    asker, handler = connect("asker"), connect("handler")
    owed: list[object] = []

    def later(ask: Number, reply: Any) -> None:
        if ask.value == 99:
            owed.append(reply)
        else:
            reply.answer(ask)

    handler.call(lambda: handler.client.respond_later(v.ASK, v.ANSWER, later))
    handler.call(lambda: handler.client.wait_defined(5.0))
    handler.call(lambda: handler.client.directory.listing(5.0))
    _on_the_short_way(asker, central)
    failures: list[QueryError] = []
    asker.call(
        lambda: asker.client.query_notify(
            v.ASK,
            Number(value=99),
            v.ANSWER,
            timeout=30.0,
            answered=lambda *_: failures.append(QueryError("an answer")),
            failed=failures.append,
        )
    )
    until(lambda: owed, 5.0)
    handler.close()
    until(lambda: failures, 5.0)
    assert type(failures[0]) is HandlerDiedError
    _responding(connect("successor"), plus=1)
    assert _ask(asker, 1) == 2
    assert not asker.faults


def test_delayed_answers_of_two_askers_go_to_the_right_one(
    connect: Connect, central: Central
) -> None:
    askers = [connect(f"asker {number}") for number in range(2)]
    handler = connect("handler")
    replies: list[tuple[int, object]] = []
    handler.call(
        lambda: handler.client.respond_later(
            v.ASK, v.ANSWER, lambda ask, reply: replies.append((ask.value, reply))
        )
    )
    handler.call(lambda: handler.client.wait_defined(5.0))
    handler.call(lambda: handler.client.directory.listing(5.0))
    answers: list[list[int]] = [[], []]

    def ask_all(base: int) -> None:
        for place, asker in enumerate(askers):
            asker.call(
                lambda place=place, asker=asker: asker.client.query_notify(
                    v.ASK,
                    Number(value=base + place),
                    v.ANSWER,
                    timeout=10.0,
                    answered=lambda value, _: answers[place].append(value.value),
                    failed=lambda error: answers[place].append(repr(error)),
                )
            )

    for round_ in range(5):
        ask_all(10 * round_)
        until(lambda: len(replies) == 2, 5.0)
        for value, reply in reversed(replies):
            handler.call(lambda v_=value, r=reply: r.answer(Number(value=v_)))
        until(lambda r=round_: all(len(each) == r + 1 for each in answers), 5.0)
        replies.clear()
    assert answers == [[0, 10, 20, 30, 40], [1, 11, 21, 31, 41]]
    del central


def test_central_that_is_started_again_ends_the_short_way_too(
    connect: Connect, central: Central
) -> None:
    asker, _ = connect("asker"), _responding(connect("handler"))
    _on_the_short_way(asker, central)
    central.close()
    until(lambda: not asker.client.connected, 5.0)
    with pytest.raises(QueryError, match="not sent"):
        _ask(asker)


def test_rubbish_at_the_door_is_counted_and_harms_nobody(
    connect: Connect, central: Central
) -> None:
    asker, handler = connect("asker"), _responding(connect("handler"))
    _on_the_short_way(asker, central)
    chance = random.Random(1)
    good = control_codec.pack(control.Query(number=1, name="T_Ask", timeout_s=1.0))
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    with context, context.socket(zmq.DEALER) as rogue:
        rogue.linger = 0
        rogue.connect(handler.client.session.direct_responder.address)
        for number in range(300):
            cut = good[: chance.randrange(len(good))]
            rogue.send_multipart([cut] if number % 2 else [chance.randbytes(30), b"x"])
        rogue.send_multipart([good, b"no frame"])
        rogue.send_multipart([good] * 9)
        rogue.send_multipart([control_codec.pack(control.Bye()), b""])
        faults = handler.client.faults.counts
        until(lambda: faults["malformed control frame"] >= 302, 5.0)
        assert rogue.poll(5000)
        assert isinstance(control_codec.unpack(rogue.recv_multipart()[0]), control.Failure)
    assert _ask(asker, 5) == 5
    assert not handler.faults
    assert threading.active_count() < 50


def test_an_answer_may_say_that_its_content_is_older_than_the_question(connect: Connect) -> None:
    asker, handler = connect("asker"), connect("handler")

    def answer(ask: Number, reply: Reply[Number]) -> None:
        reply.answer(ask, measured=handler.client.loop.clock() - 7.0)

    handler.call(lambda: handler.client.respond_later(v.ASK, v.ANSWER, answer))
    handler.call(lambda: handler.client.wait_defined(5.0))
    handler.call(lambda: handler.client.directory.listing(5.0))
    ages: list[float] = []
    asker.call(
        lambda: asker.client.query_notify(
            v.ASK,
            Number(value=1),
            v.ANSWER,
            timeout=5.0,
            answered=lambda _, reception: ages.append(reception.age),
            failed=lambda _: ages.append(-1.0),
        )
    )
    until(lambda: ages, 5.0)
    assert ages[0] >= 7.0
