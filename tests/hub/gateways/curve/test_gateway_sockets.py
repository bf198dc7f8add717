"""The way in for other machines: real sockets with real keys, and those that are refused."""

from __future__ import annotations

import dataclasses
import random
import socket
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
import zmq

from hub.errors import EndpointError, KeyFileError
from hub.ipc.broker.zap import ZapHandler
from hub.ipc.roles import Principal, Role
from hub.ipc.security.client_keys import ClientKeys, KeyPair
from hub.ipc.security.keyring import Keyring
from tests.hub.gateways.curve.gateway_stand_in import PLANES, StandIn, standing_in
from tests.support.ports import free_port
from tests.support.repetitions import repetitions
from tests.support.waiting import until

_Socket = zmq.Socket[bytes]

INS = [f"{plane} in" for plane in PLANES]
OUTS = [f"{plane} out" for plane in PLANES]
KINDS = {"control": zmq.DEALER} | dict.fromkeys(INS, zmq.PUB) | dict.fromkeys(OUTS, zmq.SUB)


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[StandIn]:
    with standing_in(tmp_path / "keys") as running:
        yield running


def arrives(publisher: _Socket, subscriber: _Socket, message: bytes) -> None:
    """Publish until it is received: from then on the way is open."""
    until(
        lambda: subscriber.poll(10) and subscriber.recv() == message,
        10.0,
        f"{message!r} did not come",
        meanwhile=lambda: publisher.send(message),
    )


def drained(subscriber: _Socket) -> list[bytes]:
    """What has come, until nothing comes any more."""
    found = []
    while subscriber.poll(100):
        found.append(subscriber.recv())
    return found


def stranger(keys: ClientKeys) -> ClientKeys:
    """Keys that look like these, but nobody knows the public one."""
    return dataclasses.replace(keys, pair=KeyPair.new())


@pytest.mark.parametrize("plane", PLANES)
def test_messages_pass_both_ways_on_every_plane(hub: StandIn, plane: str) -> None:
    keys = hub.keys(Role.MODULE)
    near = hub.local(zmq.PUB, f"{plane} in"), hub.local(zmq.SUB, f"{plane} out")
    far = hub.remote(zmq.PUB, f"{plane} in", keys), hub.remote(zmq.SUB, f"{plane} out", keys)
    for subscriber in (near[1], far[1]):
        subscriber.subscribe(b"")
    for number, (publisher, subscriber) in enumerate(
        [(near[0], near[1]), (near[0], far[1]), (far[0], near[1]), (far[0], far[1])]
    ):
        arrives(publisher, subscriber, b"message %d" % number)


def test_nothing_is_lost_or_out_of_order_once_the_way_is_open(hub: StandIn) -> None:
    keys = hub.keys(Role.MODULE)
    far_publisher = hub.remote(zmq.PUB, "state in", keys)
    far_subscriber = hub.remote(zmq.SUB, "state out", keys)
    far_subscriber.subscribe(b"")
    arrives(far_publisher, far_subscriber, b"open")
    drained(far_subscriber)
    sent = [b"%d" % number for number in range(300)]
    for message in sent:
        far_publisher.send(message)
    assert drained(far_subscriber) == sent


def test_subscriptions_reach_a_local_publisher_in_order_and_go_with_their_owner(
    hub: StandIn,
) -> None:
    names = [b"name%02d\0" % number for number in range(60)]
    publisher = hub.local(zmq.XPUB, "state in")
    subscriber = hub.remote(zmq.SUB, "state out", hub.keys(Role.OBSERVE))
    for name in names:
        subscriber.subscribe(name)
    assert [publisher.recv() for _ in names] == [b"\1" + name for name in names]
    # What was subscribed before the last one is open now, without a message sent for luck.
    for name in names:
        publisher.send(name)
    assert [subscriber.recv() for _ in names] == names
    subscriber.close()
    assert {publisher.recv() for _ in names} == {b"\0" + name for name in names}


def test_subscriptions_reach_a_remote_publisher_in_order(hub: StandIn) -> None:
    names = [b"name%02d\0" % number for number in range(60)]
    publisher = hub.remote(zmq.XPUB, "command in", hub.keys(Role.OPERATE))
    subscriber = hub.local(zmq.SUB, "command out")
    for name in names:
        subscriber.subscribe(name)
    assert [publisher.recv() for _ in names] == [b"\1" + name for name in names]


def test_late_remote_publisher_hears_of_earlier_subscriptions(hub: StandIn) -> None:
    subscriber = hub.local(zmq.SUB, "state out")
    subscriber.subscribe(b"early\0")
    publisher = hub.remote(zmq.XPUB, "state in", hub.keys(Role.MODULE))
    assert publisher.recv() == b"\1early\0"


def test_central_sees_who_sent_a_control_message_and_who_left(hub: StandIn) -> None:
    for role in Role:
        client = hub.remote(zmq.DEALER, "control", hub.keys(role))
        client.send(b"hello")
        assert client.recv().startswith(f"{role.value}:a-{role.value}:".encode())
        hub.ended.clear()
        client.close()
        until(lambda: hub.ended, 10.0)


@pytest.mark.parametrize("role", Role)
def test_each_role_enters_its_places_and_no_others(hub: StandIn, role: Role) -> None:
    keys = hub.keys(role)
    inward = INS if role is Role.MODULE else ["command in"]
    expected = {
        place: "in" if place in ("control", *OUTS, *inward) else "refused" for place in KINDS
    }
    assert {place: hub.outcome(kind, place, keys) for place, kind in KINDS.items()} == expected
    refused = {f"refused at the gateway's {p}: role {role.value}" for p in INS if p not in inward}
    assert set(hub.faults.counts) == refused


@pytest.mark.parametrize("place", KINDS)
@pytest.mark.parametrize("who", ["nobody's key", "another hub's key", "no key", "removed key"])
def test_stranger_is_refused_counted_and_logged_once_a_minute(
    hub: StandIn, place: str, who: str
) -> None:
    keys: ClientKeys | None = hub.keys(Role.MODULE)
    assert keys is not None
    good = hub.keys(Role.MODULE, "good")
    if who == "nobody's key":
        keys = stranger(keys)
    elif who == "another hub's key":
        keys = dataclasses.replace(keys, hub=KeyPair.new().public)
    elif who == "no key":
        keys = None
    else:
        assert hub.outcome(KINDS[place], place, keys) == "in"
        hub.keyring.remove(keys.principal.name)
    for _ in range(3):
        assert hub.outcome(KINDS[place], place, keys) == "refused"
    reason = f"bad handshake at the gateway's {place}"
    if who in ("nobody's key", "removed key"):
        reason = f"refused at the gateway's {place}: unknown key"
    until(lambda: hub.faults.counts[reason] >= 3, 10.0, lambda: str(hub.faults.counts))
    assert len([line for line in hub.logged if reason in line]) == 1
    hub.now += 61.0
    hub.outcome(KINDS[place], place, keys)
    until(lambda: len([line for line in hub.logged if reason in line]) == 2, 10.0)
    assert hub.outcome(KINDS[place], place, good) == "in"


def test_key_made_while_the_hub_runs_is_let_in(hub: StandIn) -> None:
    hub.keys(Role.OBSERVE)
    keys = stranger(hub.keys(Role.OPERATE))
    assert hub.outcome(zmq.DEALER, "control", keys) == "refused"
    path = hub.keyring.folder / "list.toml"
    path.write_text(f'{path.read_text()}\n[carol]\nrole = "operate"\npublic = "{keys.pair.public}"')
    assert hub.outcome(zmq.DEALER, "control", keys) == "in"


def test_damaged_list_lets_nobody_in_and_says_so_until_it_is_mended(hub: StandIn) -> None:
    keys = hub.keys(Role.MODULE)
    path = hub.keyring.folder / "list.toml"
    whole = path.read_text()
    path.write_text("[")
    assert hub.outcome(zmq.DEALER, "control", keys) == "refused"
    assert any("list.toml" in line and "make a new key" in line for line in hub.logged)
    path.write_text(whole)
    assert hub.outcome(zmq.DEALER, "control", keys) == "in"


def test_messages_that_an_observer_sends_where_messages_come_out_reach_nobody(
    hub: StandIn,
) -> None:
    publisher = hub.local(zmq.PUB, "command in")
    near, far = hub.local(zmq.SUB, "command out"), hub.keys(Role.OBSERVE)
    watching = hub.remote(zmq.SUB, "command out", far)
    intruder = hub.remote(zmq.XSUB, "command out", far)
    for subscriber in (near, watching):
        subscriber.subscribe(b"")
        arrives(publisher, subscriber, b"open")
    intruder.send(b"\1answer")
    for _ in range(100):
        intruder.send(b"drive")
    arrives(publisher, intruder, b"answer")  # whatever it sent before has passed
    for subscriber in (near, watching):
        assert b"drive" not in drained(subscriber)


def test_stuck_remote_subscriber_holds_up_nobody(hub: StandIn) -> None:
    observer = hub.keys(Role.OBSERVE)
    publisher = hub.local(zmq.XPUB, "picture in")
    stuck = hub.remote(zmq.SUB, "picture out", observer)
    stuck.subscribe(b"")
    assert publisher.recv() == b"\1"
    healthy = hub.remote(zmq.SUB, "picture out", observer)
    healthy.subscribe(b"end")
    assert publisher.recv() == b"\1end"
    for _ in range(3000):
        publisher.send(bytes(20_000))
    arrives(publisher, healthy, b"end")


@pytest.mark.parametrize("place", KINDS)
def test_what_is_no_handshake_leaves_the_place_open_to_others(hub: StandIn, place: str) -> None:
    keys = hub.keys(Role.MODULE)
    greeting = b"\xff" + bytes(8) + b"\x7f\3\1CURVE" + bytes(16 + 32)
    hello = b"\4" + bytes([200 + 1 + 5]) + b"\5HELLO" + bytes(200)
    for nonsense in (
        b"GET / HTTP/1.1\r\n\r\n",
        random.Random(1).randbytes(5000),
        greeting,
        greeting + hello,
    ):
        with socket.create_connection(("127.0.0.1", hub.port(place))) as raw:
            raw.sendall(nonsense)
    assert hub.outcome(KINDS[place], place, keys) == "in"


def test_who_leaves_in_the_middle_of_the_handshake_is_not_said_to_have_a_wrong_key(
    hub: StandIn,
) -> None:
    with socket.create_connection(("127.0.0.1", hub.port("control"))) as raw:
        raw.sendall(b"\xff" + bytes(8) + b"\x7f")
    reason = "bad handshake at the gateway's control"
    until(lambda: hub.faults.counts[reason] == 1, 10.0)
    (line,) = (line for line in hub.logged if reason in line)
    assert "left before it was over, or has no key" in line


def test_nobody_gets_in_while_nobody_decides(tmp_path: Path) -> None:
    with standing_in(tmp_path / "keys", serving=False) as hub:
        client = hub.remote(zmq.DEALER, "control", hub.keys(Role.MODULE))
        client.send(b"hello")
        assert not hub.gateway.control.poll(500)


def test_nobody_gets_in_when_the_gatekeeper_is_gone(tmp_path: Path) -> None:
    with standing_in(tmp_path / "keys", serving=False) as hub:
        keys = hub.keys(Role.MODULE)
        hub.zap.close()
        for place, kind in KINDS.items():
            hub.remote(kind, place, keys)
        until(
            lambda: (
                set(hub.faults.counts) == {f"bad handshake at the gateway's {p}" for p in KINDS}
            ),
            10.0,
            lambda: str(hub.faults.counts),
            meanwhile=lambda: hub.gateway.serve(dict.fromkeys(hub.gateway.polled, 1)),
        )


def test_two_cannot_decide_about_the_same_handshakes(hub: StandIn) -> None:
    with pytest.raises(EndpointError, match="who may connect"):
        ZapHandler(hub.context, hub.faults)
    assert hub.outcome(zmq.DEALER, "control", hub.keys(Role.OBSERVE)) == "in"


@pytest.mark.parametrize("name", ["hub.toml", "list.toml"])
def test_gateway_does_not_start_with_keys_it_cannot_read(tmp_path: Path, name: str) -> None:
    Keyring(tmp_path).make("alice", Role.OBSERVE)
    (tmp_path / name).write_text("[")
    with pytest.raises(KeyFileError, match=name):
        StandIn(tmp_path)


def test_ports_follow_each_other_and_are_free_again_after_close(tmp_path: Path) -> None:
    port = free_port()
    descriptors = []
    for _ in range(4):
        with standing_in(tmp_path, port) as hub:
            assert str(hub.gateway.endpoint) == f"tcp://127.0.0.1:{port}"
            assert hub.gateway.ports == tuple(range(port + 1, port + 7))
            keys = hub.keys(Role.MODULE)
            for place, kind in KINDS.items():
                assert hub.outcome(kind, place, keys) == "in"
            hub.keyring.remove(keys.principal.name)
        descriptors.append(psutil.Process().num_fds())
    assert len(set(descriptors[1:])) == 1


def test_close_does_not_wait_for_strangers_who_keep_knocking(tmp_path: Path) -> None:
    port = free_port()
    principal = Principal(name="stranger", role=Role.MODULE)
    keys = ClientKeys(principal=principal, pair=KeyPair.new(), hub=KeyPair.new().public)
    outside: zmq.Context[_Socket] = zmq.Context()
    knocking = [outside.socket(zmq.DEALER) for _ in range(12)]
    try:
        for client in knocking:
            client.reconnect_ivl = 1
            keys.apply(client)
            client.connect(f"tcp://127.0.0.1:{port}")
        for _ in range(repetitions(5, 50)):
            with standing_in(tmp_path, port) as hub:
                until(lambda: hub.faults.counts.total() > 20, 10.0)
    finally:
        outside.destroy(linger=0)


def test_busy_port_is_named_and_the_others_are_given_back(tmp_path: Path) -> None:
    port = free_port()
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", port + 3))
        busy.listen()
        with pytest.raises(EndpointError, match=f"{port + 3}: another program"):
            StandIn(tmp_path, port)
    with standing_in(tmp_path, port):
        pass


def test_row_of_ports_that_is_too_high_is_refused(tmp_path: Path) -> None:
    with pytest.raises(EndpointError, match="choose a lower one"):
        StandIn(tmp_path, 65534)


@pytest.mark.parametrize(
    "handshakes", [100, pytest.param(10_000, marks=[pytest.mark.soak, pytest.mark.timeout(900)])]
)
def test_wrong_handshakes_take_no_memory_and_no_descriptors(hub: StandIn, handshakes: int) -> None:
    good = hub.keys(Role.MODULE)
    wrong = [
        stranger(good),
        dataclasses.replace(good, hub=KeyPair.new().public),
        None,
        hub.keys(Role.OBSERVE),
    ]
    places = ["state in", "picture in"]

    def knock(times: int) -> None:
        for number in range(times):
            hub.now += 0.05  # not so often that their address is turned away
            place = places[number % len(places)]
            assert hub.outcome(zmq.PUB, place, wrong[number % len(wrong)]) == "refused"

    knock(60)  # what is made once is there now
    process = psutil.Process()
    memory, descriptors = process.memory_info().rss, process.num_fds()
    knock(handshakes)
    until(lambda: process.num_fds() <= descriptors, 10.0)
    assert process.memory_info().rss - memory < 4 << 20
    assert hub.outcome(zmq.PUB, "state in", good) == "in"
