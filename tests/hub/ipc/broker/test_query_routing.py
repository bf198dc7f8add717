"""Which handler is asked when one of them is connected and does not answer."""

from __future__ import annotations

from collections import Counter

import pytest

from hub.ipc.wire import control
from hub.ipc.wire.control import Response
from tests.hub.ipc.broker.test_registry import Bench


@pytest.fixture
def bench() -> Bench:
    """Handlers b and c, both free; c is asked while b is busy."""
    made = Bench()
    made.connect("a", "b", "c")
    made.handles("b")
    made.handles("c")
    return made


def _let_run_out(bench: Bench) -> int:
    """Have c let a query run out that b answered none of; our number of it."""
    held = bench.ask("a", number=1, timeout=1.0)
    missed = bench.ask("a", number=2, timeout=1.0)
    assert (held.identity, missed.identity) == (b"b", b"c")
    bench.say("b", Response(number=held.message.number), b"answer")
    bench.now += 1.1
    assert bench.registry.expire() == []
    return int(missed.message.number)


def test_handler_that_let_a_query_run_out_is_not_asked_while_another_has_no_more_to_do(
    bench: Bench,
) -> None:
    _let_run_out(bench)
    asked = [bench.ask("a", number=number).identity for number in range(3)]
    assert asked == [b"b", b"b", b"c"]
    assert bench.faults.counts["unanswered query"] == 1


def test_handler_that_never_answers_gets_few_of_many_queries(bench: Bench) -> None:
    """Two are under way at any time, so that b alone is never free for the second."""
    asked: Counter[bytes] = Counter()
    for _ in range(500):
        pair = [bench.ask("a", number=number, timeout=0.5) for number in range(2)]
        asked.update(each.identity for each in pair)
        for each in pair:
            if each.identity == b"b":
                bench.say("b", Response(number=each.message.number), b"answer")
        bench.now += 0.6
        bench.say("c", control.Ping(epoch=1))
        bench.registry.expire()
    assert asked[b"c"] == 1


@pytest.mark.parametrize("late", [True, False])
def test_handler_that_answers_again_is_asked_like_the_others(bench: Bench, *, late: bool) -> None:
    number = _let_run_out(bench)
    if not late:
        asked = [bench.ask("a", number=number) for number in range(3)]
        for each in asked:
            bench.say(each.identity.decode(), Response(number=each.message.number), b"answer")
    else:
        bench.say("c", Response(number=number), b"late")
    assert [bench.ask("a", number=number).identity for number in range(2)] == [b"b", b"c"]


def test_answer_to_what_was_never_asked_makes_nothing_good(bench: Bench) -> None:
    number = _let_run_out(bench)
    bench.say("c", Response(number=number + 5), b"forged")
    bench.say("b", Response(number=number), b"forged")
    assert [bench.ask("a", number=number).identity for number in range(2)] == [b"b", b"b"]


def test_handler_that_was_gone_starts_anew(bench: Bench) -> None:
    _let_run_out(bench)
    bench.say("c", control.Bye())
    bench.connect("c")
    bench.handles("c")
    assert [bench.ask("a", number=number).identity for number in range(2)] == [b"b", b"c"]
