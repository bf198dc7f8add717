"""What the holders of keys may use of central, with a clock that the test turns."""

from __future__ import annotations

import dataclasses
import itertools
import logging
from typing import Any

import pytest

from hub.bucket import Bucket
from hub.gateways.accounts import Account, QuotaVerdict
from hub.gateways.curve import connection_rates
from hub.gateways.curve.connection_rates import ConnectionRates
from hub.ipc.broker import quotas
from hub.ipc.broker.connections import MAX_PEERS
from hub.ipc.broker.query_routing import MAX_QUERIES
from hub.ipc.broker.quotas import QUOTAS
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control
from hub.ipc.wire.control import Failure, Query, Refused, Response, Welcome
from tests.hub.ipc.broker.test_registry import Bench

OBSERVE = QUOTAS[Role.OBSERVE]
ONE = b"\1one"


@pytest.fixture
def bench() -> Bench:
    return Bench()


def observer(name: str = "eve") -> Principal:
    return Principal(name=name, role=Role.OBSERVE)


def connect(bench: Bench, letters: str, principal: Principal) -> list[Any]:
    """What each HELLO is answered with."""
    bench.principals.update(dict.fromkeys(letters, principal))
    answers = [bench.say(each, control.Hello(name=f"m {each}", pid=1)) for each in letters]
    return [answer[0].message for answer in answers]


def letters(count: int, first: int = 0x4E00) -> str:
    return "".join(chr(first + number) for number in range(count))


def test_bucket_gives_a_burst_and_then_its_rate() -> None:
    bucket = Bucket(10.0, 20.0)
    assert sum(bucket.take(1.0, 5.0) for _ in range(100)) == 20
    assert sum(bucket.take(1.0, 5.0 + second / 50) for second in range(1, 51)) == 10
    assert sum(bucket.take(1.0, 1000.0) for _ in range(100)) == 20


def test_bucket_is_not_emptied_by_what_it_refuses() -> None:
    bucket = Bucket(1.0, 5.0)
    assert not bucket.take(6.0, 0.0)
    assert bucket.take(5.0, 0.0)


def test_each_role_may_use_as_much_as_those_below_it() -> None:
    below = [dataclasses.asdict(QUOTAS[role]) for role in Role]
    for lower, higher in itertools.pairwise(below):
        assert all(lower[name] <= higher[name] for name in lower)


def test_places_are_kept_for_clients_of_this_machine_and_for_operators() -> None:
    assert QUOTAS[Role.MODULE].connections_together <= MAX_PEERS * 3 // 4
    assert QUOTAS[Role.MODULE].queries_together <= MAX_QUERIES * 3 // 4
    for lower, higher in ((Role.OBSERVE, Role.OPERATE), (Role.SUPERVISE, Role.MODULE)):
        assert QUOTAS[lower].connections_together < QUOTAS[higher].connections_together
        assert QUOTAS[lower].queries_together < QUOTAS[higher].queries_together


def test_flood_of_lists_is_refused_and_then_disconnected() -> None:
    account = Account(observer(), OBSERVE)
    verdicts = [account.ask(ONE, control.List, 12, 1.0) for _ in range(400)]
    assert verdicts[:200] == [QuotaVerdict.SERVED] * 200
    assert verdicts[200:300] == [QuotaVerdict.REFUSED] * 100
    assert verdicts[300] is QuotaVerdict.ENDED
    assert not account.may_connect("control", 2.0)
    assert account.may_connect("control", 11.1)


def test_clients_of_one_key_share_its_quota_and_only_who_exceeds_it_is_disconnected() -> None:
    account = Account(observer(), OBSERVE)
    for number in range(4000):
        assert account.ask(b"\1%d" % (number % 10), control.Ping, 12, 1.0) is QuotaVerdict.SERVED
    assert account.ask(b"\1patient", control.Ping, 12, 1.0) is QuotaVerdict.REFUSED
    verdicts = {account.ask(ONE, control.Ping, 12, 1.0) for _ in range(2001)}
    assert QuotaVerdict.ENDED in verdicts
    assert account.ask(b"\1patient", control.Ping, 12, 1.0) is QuotaVerdict.REFUSED


@pytest.mark.parametrize("role", Role)
def test_who_keeps_to_the_rate_is_never_refused(role: Role) -> None:
    """Even with the dearest mix of a console: pictures, signs of life and a list now and then."""
    account, now = Account(Principal(name="a", role=role), QUOTAS[role]), 0.0
    for tick in range(60 * 30):
        now = tick / 30.0
        asked = [control.Query] * 3 + [control.List] * (tick % 30 == 0) + [control.Ping]
        assert {account.ask(ONE, kind, 200, now) for kind in asked} == {QuotaVerdict.SERVED}


def test_big_frames_are_refused_by_their_bytes() -> None:
    account = Account(observer(), OBSERVE)
    verdicts = [account.ask(ONE, control.Query, 4 << 20, 0.0) for _ in range(3)]
    assert verdicts == [QuotaVerdict.REFUSED, QuotaVerdict.ENDED, QuotaVerdict.REFUSED]


def test_refusals_are_answered_once_a_second() -> None:
    account = Account(observer(), OBSERVE)
    assert [account.may_answer(time) for time in (0.0, 0.1, 0.9, 1.2)] == [True, False, False, True]
    assert "'eve'" in account.text
    assert "200 times a second" in account.text


def test_key_that_connects_again_and_again_is_turned_away_place_by_place() -> None:
    account = Account(observer(), OBSERVE)
    assert sum(account.may_connect("state out", 0.0) for _ in range(500)) == 40
    assert account.may_connect("control", 0.0)
    assert account.may_connect("state out", 1.1)


def test_one_key_has_few_places(bench: Bench) -> None:
    answers = connect(bench, letters(OBSERVE.connections + 1), observer())
    assert [type(each) for each in answers] == [Welcome] * OBSERVE.connections + [Refused]
    assert "eve" in answers[-1].text
    assert str(OBSERVE.connections) in answers[-1].text


def test_observers_leave_places_to_operators_and_all_leave_places_to_local_clients(
    bench: Bench,
) -> None:
    first = 0x4E00
    for role in (Role.OBSERVE, Role.OPERATE, Role.MODULE):
        quota, refused = QUOTAS[role], 0
        for key in range(200):
            principal = Principal(name=f"{role.value}{key}", role=role)
            answers = connect(bench, letters(quota.connections, first), principal)
            first += quota.connections
            refused += sum(isinstance(each, Refused) for each in answers)
            if refused:
                break
        assert refused
        assert len(bench.registry.connected()) == quota.connections_together
    answers = connect(bench, letters(64, first), LOCAL)
    assert {type(each) for each in answers} == {Welcome}


def test_key_may_define_so_many_messages(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    few = dataclasses.replace(QUOTAS[Role.MODULE], definitions=2)
    monkeypatch.setattr(quotas, "QUOTAS", {**QUOTAS, Role.MODULE: few})
    connect(bench, "a", Principal(name="far", role=Role.MODULE))
    assert [type(bench.define("a", f"M{number}")) for number in range(3)] == [
        control.Defined,
        control.Defined,
        Refused,
    ]
    bench.connect("b")
    assert bench.define("b", "M2") == control.Defined(name="M2")


def test_observer_subscribes_to_so_many_messages_and_is_told_of_the_limit(bench: Bench) -> None:
    connect(bench, "a", observer())
    for number in range(OBSERVE.names):
        assert bench.say("a", control.Subscribe(name=f"M{number}", token="")) == []
    refused = bench.answer("a", control.Subscribe(name="Last", token=""))
    assert isinstance(refused, Refused)
    assert str(OBSERVE.names) in refused.text
    assert bench.faults.counts["refused name"] == 1


class Asking:
    """A handler h on this machine, and observers and an operator that ask it."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        bench.connect("h")
        bench.handles("h")

    def join(self, who: str, principal: Principal) -> None:
        (welcome,) = connect(self.bench, who, principal)
        assert isinstance(welcome, Welcome)

    def ask(self, who: str) -> Any:
        """The query as the handler gets it, or the failure."""
        query = Query(number=7, name="Ask", timeout_s=60.0)
        (outgoing,) = self.bench.say(who, query, b"question")
        return outgoing.message


@pytest.fixture
def asking(bench: Bench) -> Asking:
    return Asking(bench)


def test_queries_of_one_key_leave_room_for_another(asking: Asking) -> None:
    asking.join("a", observer("one"))
    asking.join("b", observer("one"))
    answers = [asking.ask("ab"[number % 2]) for number in range(100)]
    failed = [each for each in answers if isinstance(each, Failure)]
    assert len(failed) == 100 - OBSERVE.at_one_handler
    assert str(OBSERVE.at_one_handler) in failed[0].text
    assert asking.bench.faults.counts["query over quota"] == len(failed)


def test_queries_of_one_key_at_several_handlers_leave_room_for_another(bench: Bench) -> None:
    names = [f"Ask{number}" for number in range(8)]
    bench.connect("h")
    for name in names:
        bench.handles("h", name)
    handlers = letters(8)
    bench.connect(*handlers)
    for who, name in zip(handlers, names, strict=True):
        bench.handles(who, name)
    connect(bench, "ab", observer("one"))
    asked = [bench.ask("ab"[place % 2], name=names[place % 8]) for place in range(64)]
    assert sum(isinstance(each.message, Query) for each in asked) == OBSERVE.queries
    connect(bench, "c", observer("two"))
    assert isinstance(bench.ask("c", name=names[0]).message, Query)


def test_observers_leave_a_handler_to_operators_and_to_this_machine(asking: Asking) -> None:
    for number, who in enumerate(letters(10)):
        asking.join(who, observer(f"eve{number}"))
    for _ in range(10):
        for who in letters(10):
            asking.ask(who)
    asking.join("o", Principal(name="op", role=Role.OPERATE))
    asking.join("l", LOCAL)
    assert isinstance(asking.ask("o"), Query)
    assert isinstance(asking.ask("l"), Query)
    assert isinstance(asking.ask(letters(1)), Failure)


def test_observers_ask_a_handler_so_often_however_fast_it_answers(asking: Asking) -> None:
    for number, who in enumerate(letters(10)):
        asking.join(who, observer(f"eve{number}"))
    answered = 0
    for _ in range(50):
        for who in letters(10):
            asked = asking.ask(who)
            if isinstance(asked, Query):
                answered += 1
                asking.bench.say("h", Response(number=asked.number), b"answer")
    assert answered == OBSERVE.to_one_handler_per_s
    asking.bench.now += 1.0
    assert isinstance(asking.ask(letters(1)), Query)


@pytest.mark.parametrize("how", ["answered", "asker left", "handler left", "run out"])
def test_share_comes_back_when_a_query_ends(asking: Asking, how: str) -> None:
    asking.join("a", observer())
    asked = [asking.ask("a") for _ in range(OBSERVE.at_one_handler)]
    assert isinstance(asking.ask("a"), Failure)
    if how == "answered":
        asking.bench.say("h", Response(number=asked[0].number), b"answer")
    elif how == "asker left":
        asking.bench.say("a", control.Bye())
        asking.join("a", observer())
    elif how == "handler left":
        asking.bench.say("h", control.Bye())
        asking.bench.connect("h")
        asking.bench.handles("h")
    else:
        asking.bench.now += 61.0
        for who in "ha":
            asking.bench.say(who, control.Ping(epoch=1))
        asking.bench.registry.expire()
    assert isinstance(asking.ask("a"), Query)


def test_listing_for_keys_is_made_a_few_times_a_second_and_for_this_machine_each_time(
    bench: Bench,
) -> None:
    connect(bench, "ab", observer())
    first = bench.listing("a")
    bench.now += 0.1
    assert bench.listing("b") is first
    bench.connect("l")
    assert bench.listing("l") is not first
    bench.now += 0.3
    assert len(bench.listing("a").peers) == 3


class Door:
    """Connections from addresses, and which of them were ended."""

    def __init__(self) -> None:
        self.now = 0.0
        self.ended: list[int] = []
        faults = FaultCounter(logging.getLogger(__name__), lambda: self.now)
        self.sources = ConnectionRates(faults, self.ended.append)
        self._last = 0

    def come(self, place: str, address: str = "10.0.0.1") -> int:
        self._last += 1
        if not self.sources.admit(self._last, address, place, self.now):
            self.ended.append(self._last)
        return self._last

    def stays(self, place: str, address: str = "10.0.0.1") -> bool:
        return self.come(place, address) not in self.ended


def test_address_that_floods_with_connections_is_turned_away_and_no_other() -> None:
    door = Door()
    for _ in range(1000):
        descriptor = door.come("control")
        door.sources.ended(descriptor)
    assert len(door.ended) == 1000 - connection_rates.AT_ONCE
    assert door.stays("control", "10.0.0.2")
    door.now += 1.0
    assert sum(door.stays("control") for _ in range(100)) == connection_rates.PER_S


def test_address_connects_to_planes_as_often_as_to_control_and_some_more() -> None:
    door = Door()
    assert sum(door.stays("state out") for _ in range(50)) == connection_rates.EXTRA_CONNECTIONS
    for _ in range(3):
        assert door.stays("control")
    assert sum(door.stays("state out") for _ in range(50)) == 3
    assert door.stays("picture out")


def test_place_is_free_again_when_a_connection_ends() -> None:
    door = Door()
    taken = [door.come("state out") for _ in range(connection_rates.EXTRA_CONNECTIONS)]
    assert not door.stays("state out")
    door.sources.ended(taken[0])
    assert door.stays("state out")


def test_control_connection_that_says_no_hello_is_ended() -> None:
    door = Door()
    silent, client, plane = door.come("control"), door.come("control"), door.come("state out")
    door.sources.end_silent(lambda descriptor: descriptor == client, 4.0)
    assert door.ended == []
    door.sources.end_silent(lambda descriptor: descriptor == client, 6.0)
    assert door.ended == [silent]
    assert plane not in door.ended
