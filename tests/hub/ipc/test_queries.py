"""Queries through a real central: every one ends, with an answer or with an error."""

from __future__ import annotations

import logging
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable

import pytest

from hub.errors import (
    HandlerDiedError,
    HandlerFailedError,
    HubError,
    NoHandlerError,
    QueryError,
    QueryTimeoutError,
)
from hub.ipc.broker.central import Central
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer, on_one_transport
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]


def _ask(peer: Peer, value: int = 20, timeout: float = 5.0) -> Number:
    return peer.call(
        lambda: peer.client.query_response(v.ASK, Number(value=value), v.ANSWER, timeout=timeout)
    )


def _respond(peer: Peer, handler: Callable[[Number], Number]) -> None:
    peer.call(lambda: peer.client.respond(v.ASK, v.ANSWER, handler))
    listing = peer.call(lambda: peer.client.directory.listing(5.0))
    assert any("T_Ask" in other.handles for other in listing.peers)


def test_query_is_answered(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    _respond(one, lambda ask: Number(value=ask.value + 1))
    assert _ask(other) == Number(value=21)


@on_one_transport
def test_module_may_ask_itself(connect: Connect) -> None:
    one = connect("one")
    _respond(one, lambda ask: Number(value=ask.value + 1))
    assert _ask(one) == Number(value=21)


def test_answer_may_be_told_later(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    _respond(one, lambda ask: Number(value=ask.value + 1))
    answers: list[Number] = []
    failures: list[QueryError] = []
    for number in range(10):
        other.call(
            lambda number=number: other.client.query_notify(
                v.ASK,
                Number(value=number),
                v.ANSWER,
                timeout=5.0,
                answered=lambda answer, _: answers.append(answer.value),
                failed=failures.append,
            )
        )
    until(lambda: len(answers) == 10, 5.0)
    assert sorted(answers) == list(range(1, 11))
    assert failures == []


def test_query_frame_tells_which_message_the_answer_is(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    _respond(one, lambda ask: ask)
    frame = other.call(lambda: other.client.query_frame(v.ASK, Number(value=1), timeout=5.0))
    assert frame.name == "T_Answer"


@on_one_transport
def test_query_without_handler_ends_at_once(connect: Connect) -> None:
    one = connect("one")
    start = time.monotonic()
    with pytest.raises(NoHandlerError, match="T_Ask"):
        _ask(one, timeout=30.0)
    assert time.monotonic() - start < 10.0


@on_one_transport
def test_error_of_the_handler_is_told_to_who_asked(connect: Connect) -> None:
    one, other = connect("one"), connect("other")

    def refuse(ask: Number) -> Number:
        text = f"not today\0 {ask.value} \ud800"
        raise HubError(text)

    _respond(one, refuse)
    with pytest.raises(HandlerFailedError, match=r"not today\? 20"):
        _ask(other)
    assert one.faults == []


@on_one_transport
def test_fault_of_the_handler_is_told_at_once_and_not_hidden_from_its_owner(
    connect: Connect,
) -> None:
    one, other = connect("one"), connect("other")
    _respond(one, lambda ask: Number(value=ask.value // 0))
    with pytest.raises(HandlerFailedError, match="ZeroDivisionError"):
        _ask(other, timeout=30.0)
    # The answer leaves before the fault is raised in the owner's loop.
    until(lambda: [type(error) for error in one.faults] == [ZeroDivisionError], 10.0)


@on_one_transport
def test_answer_that_does_not_fit_its_format_is_told(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    _respond(one, lambda ask: Number(value=ask.value + 2**40))
    with pytest.raises(HandlerFailedError, match=r"\{int\}"):
        _ask(other)


@on_one_transport
def test_answer_of_another_message_than_expected_is_an_error(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    one.call(lambda: one.client.respond(v.ASK, v.LOG, lambda ask: ask))
    until(lambda: _outcome(other) is HandlerFailedError, 5.0)


def _outcome(peer: Peer) -> type[QueryError] | None:
    try:
        _ask(peer)
    except QueryError as error:
        return type(error)
    return None


def test_query_ends_when_its_time_is_over_and_the_late_answer_is_counted(
    connect: Connect, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    one, other = connect("one"), connect("other")
    free = threading.Event()

    def answer(ask: Number) -> Number:
        free.wait(5.0)
        return ask

    _respond(one, answer)
    with pytest.raises(QueryTimeoutError, match=r"T_Ask in 0.05 s"):
        _ask(other, timeout=0.05)
    free.set()
    assert _ask(other) == Number(value=20)

    def late() -> list[logging.LogRecord]:
        return [each for each in caplog.records if "late answer" in each.getMessage()]

    until(late, 5.0)  # by central, or by the client if central had sent it already
    levels = {each.levelno for each in late() if each.name.startswith("hub.ipc.node")}
    assert levels <= {logging.INFO}, "the query's own error has said it to who asked"


@on_one_transport
def test_callback_that_fails_does_not_lose_the_next_answer(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    _respond(one, lambda ask: ask)
    answers: list[Number] = []

    def ask(answered: Callable[[Number, object], object]) -> None:
        other.client.query_notify(
            v.ASK, Number(value=1), v.ANSWER, timeout=5.0, answered=answered, failed=print
        )

    def fail(answer: Number, how: object) -> None:
        del answer, how
        text = "mine"
        raise HubError(text)

    other.call(lambda: (ask(fail), ask(lambda answer, _: answers.append(answer))))
    until(lambda: answers, 5.0)
    until(lambda: [str(error) for error in other.faults] == ["mine"], 10.0)


_HANDLER = """
import signal, sys
from hub.ipc.client import Client
from tests.hub.ipc.vocabulary import ANSWER, ASK

def stuck(ask):
    print("asked", flush=True)
    signal.pause()

client = Client("handler", sys.argv[1])
client.respond(ASK, ANSWER, stuck)
client.wait_connected(10.0)
client.wait_defined(10.0)
client.directory.listing(10.0)
print("ready", flush=True)
while True:
    client.listen(1.0)
"""


def test_killed_handler_ends_the_query_quickly(connect: Connect, central: Central) -> None:
    one = connect("one")
    command = [sys.executable, "-c", _HANDLER, central.endpoints[0]]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            failures: list[QueryError] = []
            one.call(
                lambda: one.client.query_notify(
                    v.ASK,
                    Number(value=1),
                    v.ANSWER,
                    timeout=30.0,
                    answered=print,
                    failed=failures.append,
                )
            )
            assert process.stdout.readline() == "asked\n"
            process.send_signal(signal.SIGKILL)
            killed = time.monotonic()
            until(lambda: failures, 10.0)
            # Seen by the end of the connection, not by silence (2 s) or time-out (30 s).
            assert time.monotonic() - killed < 1.5
        finally:
            process.kill()
    assert type(failures[0]) is HandlerDiedError
    assert "handler went away before it answered T_Ask" in str(failures[0])
    assert central.connected() == ("one",)


def test_query_to_nobody_ends_at_once_before_the_connection_stands(
    peers: Callable[[str, str], Peer],
) -> None:
    lonely = peers("lonely", "tcp://127.0.0.1:9")
    start = time.monotonic()
    with pytest.raises(QueryError, match="was not sent: no hub answers at tcp"):
        _ask(lonely, timeout=30.0)
    assert time.monotonic() - start < 10.0


@on_one_transport
def test_handler_that_takes_its_time_keeps_its_timers_however_many_ask(
    connect: Connect,
) -> None:
    """Else a module that is asked much announces itself no longer, and counts as hanging."""
    handler, asker = connect("handler"), connect("asker")
    turns, before, answers = [0], [0], [0]
    pause = threading.Event()

    def slow(ask: Number) -> Number:
        pause.wait(0.01)
        if ask.value == 0:
            before[0] = turns[0]
        return ask

    def count() -> None:
        turns[0] += 1

    _respond(handler, slow)
    handler.call(lambda: handler.client.every(0.01, count))

    def ask() -> None:
        for value in range(60):
            asker.client.query_notify(
                v.ASK,
                Number(value=value),
                v.ANSWER,
                timeout=10.0,
                answered=lambda *_: answers.__setitem__(0, answers[0] + 1),
                failed=lambda _: None,
            )

    asker.call(ask)
    until(lambda: answers[0] == 60, 10.0)
    assert turns[0] - before[0] >= 5
