"""What central tells neighbours of each other, without sockets."""

from __future__ import annotations

import pytest

from hub.ipc.broker import subscription_acks
from hub.ipc.roles import Principal, Role
from hub.ipc.transport.clock_sync import this_neighbourhood
from hub.ipc.wire import control
from hub.ipc.wire.control import Advertise, Advertised, Ready, Subscribe, Subscribed, Subscriber
from tests.hub.ipc.broker.test_registry import Bench

pytestmark = pytest.mark.skipif(not this_neighbourhood(), reason="this system has no neighbours")

INBOX = "ipc://@rune-state-1"


@pytest.fixture
def bench() -> Bench:
    made = Bench()
    for who in "abc":
        hello = control.Hello(
            name=f"module {who}", pid=1, neighbourhood=this_neighbourhood() if who != "c" else 7
        )
        assert made.answer(who, hello).near == (who != "c")
    made.define("a", "M", "{int}")
    return made


def _number(bench: Bench, who: str) -> int:
    return bench.registry.peers.named(f"module {who}").publisher


def test_publisher_is_told_of_neighbours_before_it_is_told_that_it_is_noted(bench: Bench) -> None:
    bench.say("b", Subscribe(name="M", token="1.1", inbox=INBOX))
    told, answer = bench.say("a", Advertise(name="M"))
    assert told.message == Subscriber(name="M", subscriber=_number(bench, "b"), inbox=INBOX)
    assert answer.message == Advertised(name="M", subscribed=False)
    assert told.identity == answer.identity == b"a"
    assert bench.answer("c", Advertise(name="M")) == Advertised(name="M", subscribed=True)


def test_subscription_stands_when_the_publisher_has_noted_the_inbox(bench: Bench) -> None:
    bench.say("a", Advertise(name="M"))
    (told,) = bench.say("b", Subscribe(name="M", token="1.1", inbox=INBOX, in_ring=True))
    assert told.identity == b"a"
    assert (told.message.token, told.message.in_ring) == ("1.1", True)
    bench.say("b", Ready(token="1.1"))
    (stands,) = bench.say("a", Ready(token="1.1"))
    assert (stands.identity, stands.message) == (b"b", Subscribed(token="1.1"))


def test_publisher_is_told_once_of_a_neighbour_that_is_gone(bench: Bench) -> None:
    bench.define("a", "N", "{int}")
    for name in "MN":
        bench.say("a", Advertise(name=name))
        bench.say("b", Subscribe(name=name, token="", inbox=INBOX))
    gone = Subscriber(name="", subscriber=_number(bench, "b"))
    told = [out.message for out in bench.say("b", control.Bye()) if out.identity == b"a"]
    assert told == [gone]
    assert bench.answer("a", Advertise(name="M")) == Advertised(name="M", subscribed=False)


def test_publisher_is_told_when_a_neighbour_unsubscribes(bench: Bench) -> None:
    bench.say("a", Advertise(name="M"))
    bench.say("b", Subscribe(name="M", token="", inbox=INBOX))
    (told,) = bench.say("b", control.Unsubscribe(name="M"))
    assert told.message == Subscriber(name="M", subscriber=_number(bench, "b"))
    assert bench.say("b", control.Unsubscribe(name="M")) == []


@pytest.mark.parametrize(("who", "inbox"), [("c", INBOX), ("b", "tcp://192.0.2.1:1"), ("b", "")])
def test_inbox_of_a_stranger_or_elsewhere_is_told_nobody(
    bench: Bench, who: str, inbox: str
) -> None:
    bench.say(who, Subscribe(name="M", token="", inbox=inbox))
    assert bench.answer("a", Advertise(name="M")) == Advertised(name="M", subscribed=True)


def test_who_has_a_key_takes_nobodys_confirmation(bench: Bench) -> None:
    bench.principals["e"] = Principal.of("eve", Role.OBSERVE, "its key")
    bench.connect("e")
    bench.say("a", Advertise(name="M"))
    bench.say("b", Subscribe(name="M", token="1.1", inbox=INBOX))
    bench.say("b", Ready(token="1.1"))
    bench.say("e", Subscribe(name="M", token="1.1"))
    (stands,) = bench.say("a", Ready(token="1.1"))
    assert (stands.identity, stands.message) == (b"b", Subscribed(token="1.1"))


def test_keys_leave_room_for_the_confirmations_of_the_robot(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(subscription_acks, "MAX_UNDER_WAY", 20)
    monkeypatch.setattr(subscription_acks, "MAX_FAR", 10)
    bench.principals["e"] = Principal.of("eve", Role.OBSERVE, "its key")
    bench.connect("e")
    own = _number(bench, "e")
    for rounds in range(2):
        for count in range(30):
            bench.say("e", Subscribe(name="M", token=f"{own}.{count}"))
        token = f"1.{rounds}"
        bench.say("b", Subscribe(name="M", token=token))
        (stands,) = bench.say("b", Ready(token=token))
        assert stands.message == Subscribed(token=token)
    for count in range(10):
        bench.say("e", Ready(token=f"{own}.{count}"))
    assert bench.registry.broadcasts.acks.far == 0


def test_nothing_is_kept_of_who_asked_directly_and_left(bench: Bench) -> None:
    bench.define("a", "Ask")
    bench.say("a", control.Handle(name="Ask", address="ipc://@rune-door"))
    for _ in range(3):
        hello = control.Hello(name="asker", pid=1, neighbourhood=this_neighbourhood())
        bench.say("q", hello)
        told = bench.say("q", control.Query(number=1, name="Ask", timeout_s=5.0), b"question")
        assert control.DirectRoute(name="Ask", address="ipc://@rune-door") in [
            t.message for t in told
        ]
        bench.say("q", control.Bye())
    assert not bench.registry.peers.named("module a").direct_askers
