"""Queries under way beside each other: none delays, ends or hides another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import pytest

from hub.errors import QueryError
from hub.ipc.client import Client
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Make, Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

NOWHERE = "tcp://127.0.0.1:9"


class Clock:
    """Monotonic time that a test sets [s]."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def lonely(clock: Clock) -> Iterator[Client]:
    """A client without a central."""
    with closing(Client("lonely", NOWHERE, clock=clock)) as client:
        yield client


def ask(
    client: Client,
    timeout: float,
    failed: Callable[[QueryError], Any],
    answered: Callable[[Any, Any], Any] = print,
) -> None:
    client.query_notify(
        v.ASK, Number(value=1), v.ANSWER, timeout=timeout, answered=answered, failed=failed
    )


def never_answers(peer: Peer) -> list[Any]:
    """Has the peer asked; the replies that it owes."""
    kept: list[Any] = []
    peer.call(
        lambda: peer.client.respond_later(v.ASK, v.ANSWER, lambda _, reply: kept.append(reply))
    )
    peer.call(lambda: peer.client.directory.listing(5.0))
    return kept


def test_a_long_query_does_not_keep_a_client_from_saying_that_it_lives(
    connect: Callable[[str], Peer],
) -> None:
    one, kept = connect("one"), never_answers(connect("other"))
    one.call(lambda: ask(one.client, 60.0, print))
    until(lambda: kept, 5.0)

    def sleeps() -> float:
        now = one.client.loop.clock()
        return one.client.session.due(now + 60.0) - now

    assert one.call(sleeps) < 1.0


def test_every_query_ends_at_its_own_time_in_whatever_order_they_were_asked(
    connect: Callable[[str], Peer],
) -> None:
    one, other = connect("one"), connect("other")
    kept = never_answers(other)
    ended: list[float] = []
    for timeout in (0.3, 0.1, 60.0, 0.2):
        one.call(lambda t=timeout: ask(one.client, t, lambda _, t=t: ended.append(t)))
    until(lambda: len(ended) == 3, 10.0)
    assert ended == [0.1, 0.2, 0.3]
    answers: list[Any] = []
    one.call(lambda: ask(one.client, 60.0, ended.append, lambda n, _: answers.append(n.value)))
    until(lambda: len(kept) == 5, 5.0)
    other.call(lambda: kept[-1].answer(Number(value=7)))
    until(lambda: answers == [7], 5.0)
    assert ended == [0.1, 0.2, 0.3]


def test_who_asks_again_and_waits_when_a_query_has_failed_leaves_the_others_alone(
    lonely: Client,
) -> None:
    failures: list[QueryError] = []

    def ask_again(error: QueryError) -> None:
        failures.append(error)
        with pytest.raises(QueryError):
            lonely.query_response(v.ASK, Number(value=2), v.ANSWER, timeout=1.0)

    for _ in range(3):
        ask(lonely, 5.0, ask_again)
    lonely.listen(0.0)
    assert len(failures) == 3


def test_a_failure_whose_callback_raises_lets_the_others_fail_too(lonely: Client) -> None:
    failures: list[QueryError] = []

    def refuse(error: QueryError) -> None:
        raise error

    ask(lonely, 5.0, refuse)
    ask(lonely, 5.0, failures.append)
    with pytest.raises(QueryError):
        lonely.listen(0.0)
    lonely.listen(0.0)
    assert len(failures) == 1


@pytest.mark.parametrize("near", [True, False])
def test_what_is_answered_or_sent_after_the_end_is_lost_and_raises_nothing(
    make: Make, *, near: bool
) -> None:
    one, other = make("one"), make("other", near=near)
    kept = never_answers(other)
    for number in range(1, 4):  # the first through central, the last past it if that can be
        one.call(lambda: ask(one.client, 60.0, print))
        until(lambda number=number: len(kept) == number, 5.0)
    other.close()
    for reply in kept:
        reply.answer(Number(value=1))
        reply.fail("too late")
    other.client.publish(v.LOG, Number(value=1))
    other.client.subscribe(v.STREAM, print)
    other.client.close()
