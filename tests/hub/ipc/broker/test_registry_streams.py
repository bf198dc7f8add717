"""Central's decisions about publishers, subscribers, presence and last values, without sockets."""

from __future__ import annotations

import logging
from typing import Any

import pytest

from hub.ipc.broker import presence
from hub.ipc.broker.peers import Outgoing
from hub.ipc.wire import control, control_codec
from hub.ipc.wire.control import Advertise, Change, Presence, Ready, Subscribe, Subscribed
from tests.hub.ipc.broker.test_registry import Bench

FORMAT = "{int}"


@pytest.fixture
def bench() -> Bench:
    made = Bench()
    made.connect("a", "b", "c", "d")
    made.define("a", "M", FORMAT)
    return made


def _confirmed(who: str, outgoing: list) -> bool:
    return [(o.identity, o.message) for o in outgoing] == [(who.encode(), Subscribed(token="1.1"))]


def test_subscription_stands_when_subscriber_and_all_publishers_have_seen_it(bench: Bench) -> None:
    for publisher in "bc":
        assert not bench.answer(publisher, Advertise(name="M")).subscribed
    assert bench.say("a", Subscribe(name="M", token="1.1")) == []
    assert bench.say("b", Ready(token="1.1")) == []
    assert bench.say("a", Ready(token="1.1")) == []
    assert bench.say("d", Ready(token="1.1")) == []
    assert bench.say("c", Ready(token="another")) == []
    assert _confirmed("a", bench.say("c", Ready(token="1.1")))
    assert bench.say("c", Ready(token="1.1")) == []


def test_publisher_may_have_seen_it_before_central(bench: Bench) -> None:
    bench.say("b", Advertise(name="M"))
    assert bench.say("b", Ready(token="1.1")) == []
    assert bench.say("a", Subscribe(name="M", token="1.1")) == []
    assert _confirmed("a", bench.say("a", Ready(token="1.1")))


def test_nobody_waits_for_a_publisher_that_has_gone(bench: Bench) -> None:
    bench.say("b", Advertise(name="M"))
    bench.say("a", Subscribe(name="M", token="1.1"))
    bench.say("a", Ready(token="1.1"))
    assert _confirmed("a", bench.say("b", control.Bye()))


def test_subscriber_that_has_gone_is_told_nothing(bench: Bench) -> None:
    bench.say("b", Advertise(name="M"))
    bench.say("a", Subscribe(name="M", token="1.1"))
    bench.say("a", control.Bye())
    assert bench.say("b", Ready(token="1.1")) == []


def test_publisher_that_comes_later_is_told_whether_somebody_subscribes(bench: Bench) -> None:
    assert not bench.answer("b", Advertise(name="M")).subscribed
    bench.say("a", Subscribe(name="M", token=""))
    assert bench.answer("c", Advertise(name="M")).subscribed
    bench.say("a", control.Unsubscribe(name="M"))
    assert not bench.answer("d", Advertise(name="M")).subscribed


def test_tokens_of_many_forged_readies_do_not_pile_up(bench: Bench) -> None:
    for number in range(10_000):
        bench.say("b", Ready(token=f"x{number}"))
    bench.say("b", Ready(token="x" * 100_000))
    early = bench.registry.broadcasts.acks.early
    assert len(early) <= 4096
    assert max(map(len, early)) < 1000


def test_those_who_watch_are_told_what_changes(bench: Bench) -> None:
    assert bench.say("d", control.Watch()) == []

    def told(who: str, message: object) -> list[Presence]:
        return [o.message for o in bench.say(who, message) if o.identity == b"d"]

    number = next(peer.publisher for peer in bench.listing("d").peers if peer.name == "module b")
    b = {"module": "module b", "pid": ord("b"), "publisher": number}
    assert told("b", Advertise(name="M")) == [
        Presence(change=Change.PUBLISHERS, message="M", count=1, **b)
    ]
    assert told("b", Advertise(name="M")) == []
    assert told("b", Subscribe(name="M", token="")) == [
        Presence(change=Change.SUBSCRIBERS, message="M", count=1, **b)
    ]
    assert told("b", control.Handle(name="M")) == [
        Presence(change=Change.HANDLERS, message="M", count=1, **b)
    ]
    assert told("b", control.Handle(name="M", on=False)) == [
        Presence(change=Change.HANDLERS, message="M", count=0, **b)
    ]
    assert told("b", control.Bye()) == [
        Presence(change=Change.PUBLISHERS, message="M", count=0, **b),
        Presence(change=Change.SUBSCRIBERS, message="M", count=0, **b),
        Presence(change=Change.DISCONNECTED, **b),
    ]
    (presence,) = told("e", control.Hello(name="new", pid=5))
    assert bench.registry.peer_of(presence.publisher).name == "new"
    new = Presence(change=Change.CONNECTED, module="new", pid=5, publisher=presence.publisher)
    assert presence == new


def test_who_follows_a_module_is_told_its_number_and_nothing_of_others(bench: Bench) -> None:
    def told(outgoing: list[Outgoing]) -> list[Presence]:
        return [o.message for o in outgoing if o.identity == b"d"]

    assert bench.say("d", control.Watch(module="module z")) == []
    (here,) = told(bench.say("d", control.Watch(module="module b")))
    assert bench.registry.peer_of(here.publisher).name == here.module == "module b"
    assert told(bench.say("b", Advertise(name="M"))) == []
    assert told(bench.say("e", control.Hello(name="other", pid=1))) == []
    (gone,) = told(bench.say("b", control.Bye()))
    assert (gone.change, gone.publisher) == (Change.DISCONNECTED, here.publisher)
    (back,) = told(bench.say("f", control.Hello(name="module b", pid=2)))
    assert back.change is Change.CONNECTED
    assert back.publisher not in (0, here.publisher)


def test_one_follows_so_many_modules_and_no_more(bench: Bench) -> None:
    for number in range(100):
        bench.say("d", control.Watch(module=f"module {number}"))
    bench.say("d", control.Watch(module="module b"))
    peer = next(p for p in bench.registry.peers if p.name == "module d")
    assert len(peer.follows) == presence.MAX_FOLLOWED


def test_query_goes_to_the_handler_with_the_fewest_under_way(bench: Bench) -> None:
    for handler in "bc":
        bench.handles(handler)
    asked = [bench.ask("a", number=number) for number in range(4)]
    assert [each.identity for each in asked] == [b"b", b"c", b"b", b"c"]
    bench.say("c", control.Response(number=asked[1].message.number), b"answer")
    assert bench.ask("a", number=9).identity == b"c"


def test_another_handler_takes_over_with_the_time_that_is_left(bench: Bench) -> None:
    bench.handles("b")
    bench.handles("c")
    first = bench.ask("a", number=7, timeout=5.0)
    bench.now += 1.0
    (again,) = bench.say(first.identity.decode(), control.Bye())
    assert again.identity == b"c"
    assert again.attached == b"question"
    assert again.message.timeout_s == pytest.approx(4.0)
    (answered,) = bench.say("c", control.Response(number=again.message.number), b"answer")
    assert (answered.identity, answered.message) == (b"a", control.Response(number=7))


def test_query_that_is_too_long_to_keep_ends_when_its_handler_dies(bench: Bench) -> None:
    bench.handles("b")
    bench.handles("c")
    query = control.Query(number=7, name="Ask", timeout_s=5.0)
    bench.say("a", query, bytes(1 << 20))
    (failed,) = bench.say("b", control.Bye())
    assert failed.message.error == "HandlerDiedError"


def test_last_value_is_asked_of_a_publisher(bench: Bench) -> None:
    last = control.Last(number=7, name="M", timeout_s=1.0)
    assert bench.answer("a", last).error == "NoValueError"
    bench.say("b", Advertise(name="M"))
    (asked,) = bench.say("a", last)
    assert asked.identity == b"b"
    assert isinstance(asked.message, control.Last)
    (answered,) = bench.say("b", control.Response(number=asked.message.number), b"value")
    assert (answered.identity, answered.attached) == (b"a", b"value")


def test_closed_module_is_told_by_whom_and_forgotten(bench: Bench) -> None:
    outgoing = bench.say("a", control.Close(name="module b"))
    told = control.Close(name="module b", by="module a")
    assert [(o.identity, o.message) for o in outgoing] == [(b"b", told), (b"a", told)]
    assert "module b" not in bench.registry.connected()
    refused = bench.answer("a", control.Close(name="module b"))
    assert refused.error == "UnknownModuleError"


def _report(*entries: control.Received | control.Published) -> control.Report:
    received = tuple(entry for entry in entries if isinstance(entry, control.Received))
    published = tuple(entry for entry in entries if isinstance(entry, control.Published))
    return control.Report(
        received=received,
        published=published,
    )


def _published(messages: int = 20, size: int = 400, **more: Any) -> control.Published:
    known = {"name": "M", "over_s": 2.0, "silent_s": 0.1}
    return control.Published(messages=messages, bytes=size, **(known | more))


def test_what_publishers_tell_is_listed_with_its_rate_while_it_is_new(bench: Bench) -> None:
    for module in ("a", "b"):
        bench.say(module, Advertise(name="M"))
        bench.say(module, _report(_published()))
    (entry,) = bench.listing("a").definitions
    assert (entry.messages, entry.bytes) == (40, 800)
    assert (entry.messages_per_s, entry.bytes_per_s) == (20.0, 400.0)
    assert entry.silent_s == pytest.approx(0.1)
    bench.now += 1.0
    bench.say("a", _report(_published(5, 50, over_s=1.0)))
    (entry,) = bench.listing("a").definitions
    assert (entry.messages, entry.messages_per_s, entry.bytes_per_s) == (45, 15.0, 250.0)
    for _ in range(4):  # said in steps: who is silent for long is gone
        bench.now += 1.0
        bench.say("a", control.Ping(epoch=0))
    (entry,) = bench.listing("a").definitions
    assert (entry.messages, entry.messages_per_s) == (45, 0.0)


def test_only_who_publishes_a_message_counts_it(bench: Bench) -> None:
    bench.say("a", _report(_published()))
    assert bench.listing("a").definitions[0].messages == 0


def test_what_subscribers_tell_is_listed(bench: Bench) -> None:
    received = control.Received(name="M", received=10, lost=2, expired=1, oldest_s=0.5)
    for _ in range(2):
        bench.say("a", _report(received))
    unknown = control.Received(name="X", received=1, lost=1, expired=1, oldest_s=1.0)
    bench.say("a", _report(unknown))
    (entry,) = bench.listing("a").definitions
    assert (entry.lost, entry.expired, entry.oldest_s) == (4, 2, 0.5)
    assert entry.silent_s == float("inf")


def test_counts_survive_nonsense(bench: Bench) -> None:
    huge, nan, inf = 2**64 - 1, float("nan"), float("inf")
    bench.say("a", Advertise(name="M"))
    bench.say("a", _report(_published(huge), _published(1, huge)))
    for wrong in (nan, inf, -1.0):
        bench.say("a", _report(_published(over_s=wrong), _published(silent_s=wrong)))
    bench.say("a", _report(_published(over_s=0.0)))
    for lost, oldest in ((huge, 1.0), (1, nan), (1, inf), (1, -1.0)):
        received = control.Received(name="M", received=1, lost=lost, expired=0, oldest_s=oldest)
        bench.say("a", _report(received))
    listing = bench.listing("a")
    assert control_codec.unpack(control_codec.pack(listing)) == listing
    (entry,) = listing.definitions
    assert (entry.messages, entry.bytes, entry.lost) == (0, 0, 0)


def test_log_level_is_set_and_an_unknown_one_is_not(bench: Bench) -> None:
    logger = logging.getLogger("hub")
    before = logger.level
    try:
        bench.say("a", control.LogLevel(level="error"))
        assert logger.level == logging.ERROR
        bench.say("a", control.LogLevel(level="loud"))
        assert logger.level == logging.ERROR
        assert bench.listing("a").level == "error"
    finally:
        logger.setLevel(before)
