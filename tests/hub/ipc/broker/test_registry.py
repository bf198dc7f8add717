"""Central's decisions, without sockets and with a clock that the test turns."""

from __future__ import annotations

import dataclasses
import itertools
import logging
from typing import Any

import pytest

from hub.errors import NameTakenError, NotAllowedError
from hub.ipc.broker import connections, definitions, message_users, query_routing
from hub.ipc.broker.peers import Caller, Outgoing
from hub.ipc.broker.registry import Registry
from hub.ipc.formats.codec import compiled
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.security.publish_rights import ROBOT_NAMES
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control, control_codec, frames
from hub.ipc.wire.control import Failure, Query, Refused, Response, UnknownPeer, Welcome
from tests.support.cases import for_each

PORTS, PATHS = (2, 3, 4, 5, 6, 7), tuple("abcdef")


class Bench:
    """A registry with peers that are identified by one letter."""

    def __init__(self) -> None:
        self.now = 100.0
        self.principals: dict[str, Principal] = {}
        self.faults = FaultCounter(logging.getLogger(__name__), lambda: self.now)
        self.registry = Registry(clock=lambda: self.now, faults=self.faults)

    def say(self, who: str, message: Any, attached: bytes | None = None) -> list[Outgoing]:
        principal = self.principals.get(who, LOCAL)
        caller = Caller(who.encode(), ord(who), principal, PORTS, PATHS)
        return self.registry.handle(caller, message, attached)

    def answer(self, who: str, message: Any, attached: bytes | None = None) -> Any:
        """The one message that comes back to who spoke."""
        (outgoing,) = self.say(who, message, attached)
        assert outgoing.identity == who.encode()
        return outgoing.message

    def connect(self, *peers: str) -> None:
        for who in peers:
            welcome = self.answer(who, control.Hello(name=f"module {who}", pid=ord(who)))
            assert isinstance(welcome, Welcome)

    def define(self, who: str, name: str = "Ask", text: str = "{}", **changes: Any) -> Any:
        fields = ", ".join(f"x{place}" for place in range(text.count(",") + (text != "{}")))
        entry = control.Define(
            name=name,
            format=text,
            fields=fields,
            keep="newest",
            plane="state",
            rate_hz=0.0,
            lifespan_s=1.0,
        )
        return self.answer(who, dataclasses.replace(entry, **changes))

    def handles(self, who: str, name: str = "Ask") -> None:
        self.define(who, name)
        assert self.say(who, control.Handle(name=name)) == []

    def ask(self, who: str, number: int = 7, name: str = "Ask", timeout: float = 5.0) -> Outgoing:
        query = Query(number=number, name=name, timeout_s=timeout)
        (outgoing,) = self.say(who, query, b"question")
        return outgoing

    def listing(self, who: str) -> control.Listing:
        message = self.answer(who, control.List())
        assert isinstance(message, control.Listing)
        return message


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_hello_is_answered_with_a_number_of_its_own_and_where_to_connect(bench: Bench) -> None:
    first = bench.answer("a", control.Hello(name="a", pid=1))
    second = bench.answer("b", control.Hello(name="b", pid=2))
    assert first.ports == PORTS
    assert first.paths == PATHS
    assert first.epoch == second.epoch
    assert 0 != first.publisher != second.publisher != 0
    assert bench.registry.connected() == ("a", "b")


def test_second_hello_of_a_peer_is_answered_the_same(bench: Bench) -> None:
    hello = control.Hello(name="a", pid=1)
    assert bench.answer("a", hello) == bench.answer("a", hello)


def test_publisher_numbers_of_two_runs_do_not_collide() -> None:
    numbers = {Bench().answer("a", control.Hello(name="a", pid=1)).publisher for _ in range(20)}
    assert len(numbers) == 20


def test_name_of_a_live_peer_is_refused_and_says_whose_it_is(bench: Bench) -> None:
    bench.connect("a")
    refused = bench.answer("b", control.Hello(name="module a", pid=2))
    assert refused.error == NameTakenError.__name__
    assert "pid 97" in refused.text
    assert bench.faults.counts["refused connection"] == 1
    bench.say("a", control.Bye())
    assert isinstance(bench.answer("b", control.Hello(name="module a", pid=2)), Welcome)


def test_client_takes_the_place_of_its_own_earlier_connection_and_of_no_other(
    bench: Bench,
) -> None:
    bench.answer("a", control.Hello(name="one", pid=1, client=7))
    assert isinstance(bench.answer("b", control.Hello(name="one", pid=1, client=8)), Refused)
    assert isinstance(bench.answer("b", control.Hello(name="one", pid=1, client=0)), Refused)
    assert isinstance(bench.answer("c", control.Hello(name="one", pid=1, client=7)), Welcome)
    assert bench.registry.connected() == ("one",)
    assert bench.answer("a", control.Ping(epoch=1)) == UnknownPeer()


@pytest.mark.parametrize("name", ["", "x" * 65, "a\nb", "\x1b[2J"])
def test_module_name_that_cannot_be_shown_is_refused(bench: Bench, name: str) -> None:
    assert isinstance(bench.answer("a", control.Hello(name=name, pid=1)), Refused)
    assert bench.registry.connected() == ()


@pytest.mark.parametrize(
    "message",
    [control.Ping(epoch=1), control.List(), control.Handle(name="Ask"), control.Bye()],
    ids=lambda message: type(message).__name__,
)
def test_who_never_said_hello_is_a_stranger(bench: Bench, message: Any) -> None:
    assert bench.answer("a", message) == UnknownPeer()


def test_ping_is_answered_with_the_epoch(bench: Bench) -> None:
    bench.connect("a")
    pong = bench.answer("a", control.Ping(epoch=0, sent=5.0))
    assert pong == control.Pong(epoch=bench.registry.epoch, sent=5.0, hub_time=bench.now)


def test_control_message_that_only_central_sends_is_counted(bench: Bench) -> None:
    bench.connect("a")
    assert bench.say("a", UnknownPeer()) == []
    assert bench.faults.counts["unexpected control message"] == 1


def test_definition_is_listed_with_who_defined_it_first(bench: Bench) -> None:
    bench.connect("a", "b")
    assert bench.define("a", "M", "{int}") == control.Defined(name="M")
    assert bench.define("b", "M", " { int } ") == control.Defined(name="M")
    (entry,) = bench.listing("b").definitions
    assert (entry.name, entry.format, entry.definer) == ("M", "{int}", "module a")


def test_other_format_is_refused_and_names_who_defined_it(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.define("a", "M", "{int}")
    refused = bench.define("b", "M", "{double}")
    assert refused.error == "RedefinedMessageError"
    assert refused.subject == "M"
    assert "{int} by module a" in refused.text
    assert "module b wants {double}" in refused.text
    assert bench.faults.counts["refused definition"] == 1


def test_other_plane_is_refused_because_they_would_never_meet(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.define("a", "M", "{int}")
    assert "plane command" in bench.define("b", "M", "{int}", plane="command").text


@pytest.mark.parametrize(
    "changes",
    [{"format": "{int"}, {"name": "no name"}, {"fields": "a{" * 9000}, {"keep": "what"}],
    ids=str,
)
def test_malformed_definition_is_refused(bench: Bench, changes: dict[str, str]) -> None:
    bench.connect("a")
    assert isinstance(bench.define("a", **({"name": "M", "text": "{int}"} | changes)), Refused)
    assert not bench.listing("a").definitions


def test_malformed_redefinition_is_refused(bench: Bench) -> None:
    bench.connect("a")
    bench.define("a", "M", "{int}")
    assert "position 4" in bench.define("a", "M", format="{int").text


def test_definition_stays_when_its_definer_leaves(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.define("a", "M", "{int}")
    bench.say("a", control.Bye())
    assert [entry.name for entry in bench.listing("b").definitions] == ["M"]


def test_query_goes_to_the_handler_and_its_answer_to_the_asker(bench: Bench) -> None:
    bench.connect("a", "b", "c")
    bench.handles("b")
    asked = bench.ask("a", number=7)
    assert asked.identity == b"b"
    assert asked.attached == b"question"
    (answered,) = bench.say("b", Response(number=asked.message.number), b"answer")
    assert answered == Outgoing(identity=b"a", message=Response(number=7), attached=b"answer")
    assert bench.say("b", Response(number=asked.message.number), b"again") == []
    assert bench.faults.counts["late answer"] == 1


def test_queries_of_two_askers_under_one_number_do_not_mix(bench: Bench) -> None:
    bench.connect("a", "b", "c")
    bench.handles("b")
    first, second = bench.ask("a", number=7), bench.ask("c", number=7)
    (answered,) = bench.say("b", Response(number=second.message.number), b"for c")
    assert answered.identity == b"c"
    (answered,) = bench.say("b", Response(number=first.message.number), b"for a")
    assert answered.identity == b"a"


def test_module_may_ask_itself(bench: Bench) -> None:
    bench.connect("a")
    bench.handles("a")
    assert bench.ask("a").identity == b"a"


def test_failure_of_the_handler_reaches_the_asker(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.handles("b")
    number = bench.ask("a", number=9).message.number
    (failed,) = bench.say("b", Failure(number=number, error="HandlerFailedError", text="no"))
    assert failed.message == Failure(number=9, error="HandlerFailedError", text="no")


def test_query_without_handler_fails_at_once(bench: Bench) -> None:
    bench.connect("a")
    failed = bench.ask("a", number=9)
    assert failed.identity == b"a"
    assert (failed.message.number, failed.message.error) == (9, "NoHandlerError")


def test_query_without_its_message_fails_at_once(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.handles("b")
    failed = bench.answer("a", Query(number=9, name="Ask", timeout_s=1.0))
    assert failed.error == "NoHandlerError"
    assert "without its message" in failed.text


@pytest.mark.parametrize("how", ["bye", "connection", "unreachable", "silence"])
def test_handler_that_goes_away_ends_the_query_at_once(bench: Bench, how: str) -> None:
    bench.connect("a", "b")
    bench.handles("b")
    bench.ask("a", number=9)
    if how == "bye":
        outgoing = bench.say("b", control.Bye())
    elif how == "connection":
        outgoing = bench.registry.disconnected(ord("b"))
    elif how == "unreachable":
        outgoing = bench.registry.unreachable(b"b")
    else:
        bench.now += connections.SILENCE_S - 0.1
        bench.say("a", control.Ping(epoch=1))
        assert bench.registry.expire() == []
        bench.now += 0.2
        outgoing = bench.registry.expire()
    (failed,) = outgoing
    assert failed.identity == b"a"
    assert (failed.message.number, failed.message.error) == (9, "HandlerDiedError")
    assert "module b" in failed.message.text
    assert bench.registry.connected() == ("module a",)
    assert bench.ask("a").message.error == "NoHandlerError"


def test_next_handler_answers_when_the_first_is_gone(bench: Bench) -> None:
    bench.connect("a", "b", "c")
    bench.handles("b")
    bench.handles("c")
    assert bench.ask("a").identity == b"b"
    bench.say("b", control.Bye())
    assert bench.ask("a").identity == b"c"


def test_answer_for_an_asker_that_left_is_late(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.handles("b")
    number = bench.ask("a").message.number
    assert bench.say("a", control.Bye()) == []
    assert bench.say("b", Response(number=number), b"answer") == []
    assert bench.faults.counts["late answer"] == 1


def test_answer_of_another_module_than_was_asked_is_not_passed_on(bench: Bench) -> None:
    bench.connect("a", "b", "c")
    bench.handles("b")
    number = bench.ask("a").message.number
    assert bench.say("c", Response(number=number), b"forged") == []


def test_query_is_forgotten_when_its_time_is_over(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.handles("b")
    number = bench.ask("a", timeout=1.0).message.number
    bench.now += 1.1
    assert bench.registry.expire() == []
    assert bench.say("b", Response(number=number), b"answer") == []


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf"), 1e9])
def test_query_with_a_strange_timeout_is_still_answered(bench: Bench, timeout: float) -> None:
    bench.connect("a", "b")
    bench.handles("b")
    number = bench.ask("a", timeout=timeout).message.number
    bench.now += 1.0
    bench.registry.expire()
    assert bench.say("b", Response(number=number), b"answer")


def test_unknown_descriptors_drop_nobody(bench: Bench) -> None:
    bench.registry.handle(
        Caller(b"x", -1, LOCAL, PORTS, PATHS), control.Hello(name="x", pid=1), None
    )
    bench.registry.disconnected(-1)
    bench.registry.disconnected(5)
    assert bench.registry.connected() == ("x",)


def test_peers_beyond_the_limit_are_refused(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "MAX_PEERS", 2)
    bench.connect("a", "b")
    assert isinstance(bench.answer("c", control.Hello(name="c", pid=1)), Refused)


def test_definitions_beyond_the_limit_are_refused(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(definitions, "MAX_DEFINITIONS", 2)
    bench.connect("a")
    bench.define("a", "M1")
    bench.define("a", "M2")
    assert "no more" in bench.define("a", "M3").text
    assert bench.define("a", "M1") == control.Defined(name="M1")


def test_queries_beyond_the_limit_fail(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(query_routing, "MAX_QUERIES", 1)
    bench.connect("a", "b")
    bench.handles("b")
    bench.ask("a")
    assert "one too many" in bench.ask("a").message.text


def test_names_beyond_the_limit_and_of_undefined_messages_are_counted(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(message_users, "MAX_NAMES", 3)
    bench.connect("a")
    for number in range(5):
        bench.handles("a", f"M{number}")
    assert bench.faults.counts["refused name"] == 2
    bench.say("a", control.Handle(name="Undefined"))
    bench.say("a", control.Advertise(name="Undefined"))
    assert bench.faults.counts["refused name"] == 4
    bench.say("a", control.Subscribe(name="x" * 65, token="1.1"))
    assert bench.faults.counts["refused name"] == 5
    # Who may not define subscribes to what others will define.
    assert bench.say("a", control.Subscribe(name="Undefined", token="")) == []
    assert bench.faults.counts["refused name"] == 5


def test_list_of_everything_fits_into_one_frame_at_the_limits(bench: Bench) -> None:
    """Also with names and texts as long as they may be."""
    text = "{" + "int," * 100 + "int}"
    fields = ", ".join(f"{'x' * 150}{place}" for place in range(101))
    bench.connect("a")
    refused = None
    for number in range(1000):
        refused = bench.define("a", f"M{number:063}", text, fields=fields)
        if isinstance(refused, Refused):
            break
    assert isinstance(refused, Refused)
    for number in range(len(bench.listing("a").definitions)):
        bench.say("a", control.Handle(name=f"M{number:063}"))
        bench.say("a", control.Advertise(name=f"M{number:063}"))
        bench.say("a", control.Subscribe(name=f"M{number:063}", token=""))
    listing = bench.listing("a")
    size = len(control_codec.pack(listing))
    entry = listing.peers[0]
    peer = sum(map(len, (entry.handles, entry.publishes, entry.subscribes))) + 200
    assert size + connections.MAX_PEERS * peer < frames.MAX_FRAME


@pytest.mark.parametrize(
    ("text", "fingerprint", "reason"),
    [
        ("{int}", compiled("{int}").fingerprint, None),
        ("{int}", 5, "wrong format"),
        (None, 5, "undefined message"),
    ],
)
def test_broadcasts_are_compared_with_their_definition(
    bench: Bench, text: str | None, fingerprint: int, reason: str | None
) -> None:
    bench.connect("a")
    if text:
        bench.define("a", "M", text)
    frame = frames.Frame("M", 0, 1, fingerprint, 1, 1, memoryview(b""))
    assert bench.registry.broadcast(frame) == (reason is None)
    assert dict(bench.faults.counts) == ({reason: 1} if reason else {})


def test_listing_tells_peers_and_what_was_dropped(bench: Bench) -> None:
    bench.connect("a", "b")
    bench.handles("b", "Ask")
    bench.handles("b", "Again")
    bench.faults.count("rubbish", "x")
    bench.now += 0.5
    listing = bench.listing("a")
    assert [(p.name, p.pid, p.silent_s, p.handles) for p in listing.peers] == [
        ("module a", 97, 0.0, ""),
        ("module b", 98, 0.5, "Again Ask"),
    ]
    assert listing.dropped == (control.Count(reason="rubbish", count=1),)


def test_each_kind_of_fault_is_logged_at_most_once_a_minute(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(1000):
        bench.faults.count("rubbish", "x")
        bench.faults.count("more", "y")
    assert len(caplog.records) == 2
    bench.now += 60.0
    bench.faults.count("rubbish", "z")
    assert "rubbish (1001 so far): z" in caplog.records[-1].getMessage()


@for_each("name", [*sorted(ROBOT_NAMES), "my own module"])
def test_names_of_the_robots_modules_are_for_modules(name: str) -> None:
    bench = Bench()
    bench.registry = Registry(
        clock=lambda: bench.now,
        faults=bench.faults,
        reserved=frozenset({"my own module"}),
    )
    for who, role in (("a", Role.OBSERVE), ("b", Role.OPERATE), ("c", Role.SUPERVISE)):
        bench.principals[who] = Principal(name="alice", role=role)
        refused = bench.answer(who, control.Hello(name=name, pid=1))
        assert refused.error == NotAllowedError.__name__
        assert f"alice has a key to {role.value}" in refused.text
    bench.principals["d"] = Principal(name="far", role=Role.MODULE)
    assert isinstance(bench.answer("d", control.Hello(name=name, pid=1)), Welcome)
    bench.say("d", control.Bye())
    assert isinstance(bench.answer("e", control.Hello(name=name, pid=1)), Welcome)


def test_publisher_numbers_cannot_be_guessed_from_the_one_before(bench: Bench) -> None:
    numbers = []
    for index in range(40):
        welcome = bench.answer("a", control.Hello(name=f"a{index}", pid=1))
        numbers.append(welcome.publisher)
        bench.say("a", control.Bye())
    steps = {abs(later - earlier) for earlier, later in itertools.pairwise(numbers)}
    assert len(steps) == 39
    assert min(steps) > 16
    assert bench.registry.peer_of(numbers[0]) is None


def test_listing_for_keys_never_has_who_was_gone_when_it_was_asked_for(bench: Bench) -> None:
    for who in "ab":
        bench.principals[who] = Principal.of(who, Role.OPERATE, who)
    bench.connect("a", "b")
    assert {each.name for each in bench.listing("a").peers} == {"module a", "module b"}
    bench.say("b", control.Bye())
    assert {each.name for each in bench.listing("a").peers} == {"module a"}
    bench.connect("c")
    bench.define("c", "New")
    assert {each.name for each in bench.listing("a").peers} == {"module a", "module c"}
    assert "New" in {each.name for each in bench.listing("a").definitions}
