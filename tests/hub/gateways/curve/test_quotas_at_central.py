"""A whole central with a gateway: hostile holders of keys do not take it from the others."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zmq

from hub.gateways.curve import gateway_sockets
from hub.ipc.broker.subscription_floods import Bounds
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.wire import control, control_codec
from tests.hub.gateways.curve.test_roles_at_central import Hub
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

_Socket = zmq.Socket[bytes]

HELLO = control_codec.pack(control.Hello(name="eve", pid=1))
LIST = control_codec.pack(control.List())


class Attack:
    """Raw sockets with an observer's key, and the central they are to bring down."""

    def __init__(self, hub: Hub) -> None:
        self.hub = hub
        self.keys: ClientKeys = hub.keys("eve", Role.OBSERVE)
        self.context: zmq.Context[_Socket] = zmq.Context()
        self._made: list[_Socket] = []

    def connect(self, kind: int = zmq.DEALER, place: int = 0) -> _Socket:
        """A socket that is connected to a place: 0 control, 2 state out, ..."""
        made = self.context.socket(kind)
        self._made.append(made)
        made.linger = 0
        made.sndhwm = 0
        self.keys.apply(made)
        entered = self.hub.gateway
        port = entered.ports[place - 1] if place else entered.endpoint.rpartition(":")[2]
        made.connect(f"tcp://127.0.0.1:{port}")
        return made

    def counts(self, reason: str) -> int:
        return self.hub.central.faults.counts[reason]

    def close(self) -> None:
        for made in self._made:
            made.close()
        self.context.term()


@contextmanager
def attacked(folder: Path) -> Iterator[Attack]:
    hub = Hub(folder)
    running = Attack(hub)
    try:
        yield running
    finally:
        running.close()
        hub.close()


@pytest.fixture
def attack(tmp_path: Path) -> Iterator[Attack]:
    with attacked(tmp_path) as running:
        yield running


def _flood(socket: _Socket, message: bytes) -> None:
    for _ in range(500):
        socket.send(message, zmq.NOBLOCK)
    while socket.poll(0):
        socket.recv_multipart()


def test_flood_of_lists_is_disconnected_and_nobody_else_loses_central(attack: Attack) -> None:
    operator = attack.hub.client("op", Role.OPERATE)
    numbers = [each.call(lambda c=each.client: c.number) for each in (operator, attack.hub.local)]
    eve = attack.connect()
    eve.send(HELLO)
    until(
        lambda: attack.counts("disconnected for asking too much"),
        20.0,
        meanwhile=lambda: _flood(eve, LIST),
    )
    until(lambda: "eve" not in attack.hub.central.connected(), 10.0)
    assert set(attack.hub.central.connected()) == {"op", "local"}
    assert [each.client.number for each in (operator, attack.hub.local)] == numbers
    # It connects again and again by itself, and is turned away for a while.
    until(lambda: attack.counts("refused at the gateway's control: over quota"), 10.0)
    listing = operator.call(lambda: operator.client.directory.listing(5.0))
    assert {peer.name for peer in listing.peers} == {"op", "local"}


def test_who_asks_too_much_is_told_the_limit(attack: Attack) -> None:
    eve = attack.connect()
    eve.send(HELLO)
    refused: list[control.Refused] = []

    def ask() -> None:
        for _ in range(50):
            eve.send(control_codec.pack(control.Subscribe(name="T_Log", token="")))
        while eve.poll(0):
            message = control_codec.unpack(eve.recv_multipart()[-1])
            if isinstance(message, control.Refused):
                refused.append(message)

    until(lambda: refused, 20.0, meanwhile=ask)
    assert "200 times a second" in refused[0].text
    assert refused[0].subject == "T_Log"


@pytest.mark.parametrize(
    "bounds", [Bounds(topics=500, harmless=10_000), Bounds(bytes_at_once=100_000)], ids=str
)
@pytest.mark.parametrize("place", [2, 6])
def test_subscriber_that_floods_is_hung_up_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: int, bounds: Bounds
) -> None:
    monkeypatch.setattr(gateway_sockets, "Bounds", lambda: bounds)
    with attacked(tmp_path) as attack:
        eve = attack.connect(zmq.SUB, place)
        names = iter(range(10_000_000))

        def subscribe() -> None:
            for _ in range(150):
                eve.subscribe(b"state%d" % next(names))
            threading.Event().wait(0.05)

        until(lambda: attack.counts("flood of subscriptions"), 30.0, meanwhile=subscribe)
        eve.close()
        values: list[int] = []
        far = attack.hub.client("op", Role.OPERATE)
        far.call(lambda: far.client.subscribe(v.LOG, lambda n, _: values.append(n.value)))
        far.call(lambda: far.client.wait_subscribed(10.0))
        attack.hub.local.publish(v.LOG, Number(value=5))
        until(lambda: values == [5], 10.0)


def test_frames_that_are_no_subscriptions_do_not_come_in_where_broadcasts_go_out(
    attack: Attack,
) -> None:
    """ZeroMQ would hand them on to every publisher."""
    publisher = attack.hub.local
    publisher.open(v.LOG)
    eve = attack.connect(zmq.XSUB, 2)
    monitor = eve.get_monitor_socket(zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED)
    assert monitor.poll(10_000)
    monitor.recv_multipart()
    eve.send(b"\5" + b"x" * 4096)
    assert monitor.poll(10_000), "the connection goes on"
    eve.disable_monitor()
    monitor.close(0)


def test_key_that_is_turned_away_gets_in_later_and_another_key_at_once(
    attack: Attack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hub.gateways.accounts.BARRED_S", 0.5)
    eve = attack.connect()
    eve.send(HELLO)
    until(
        lambda: attack.counts("disconnected for asking too much"),
        20.0,
        meanwhile=lambda: _flood(eve, LIST),
    )
    attack.hub.client("wall", Role.OBSERVE)
    eve.close()
    again = attack.connect()
    until(lambda: again.poll(10), 15.0, meanwhile=_saying(again, HELLO))


def _saying(socket: _Socket, message: bytes) -> Callable[[], None]:
    def say() -> None:
        if socket.poll(0, zmq.POLLOUT):
            socket.send(message)
        threading.Event().wait(0.02)

    return say


@pytest.mark.parametrize(("kind", "place"), [(zmq.DEALER, 0), (zmq.PUB, 3)])
def test_a_message_of_endless_parts_ends_its_connection(
    attack: Attack, kind: int, place: int
) -> None:
    """ZeroMQ keeps all parts until the last one came."""
    socket = attack.connect(kind, place)
    events = zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED
    monitor = socket.get_monitor_socket(events)
    assert monitor.poll(10_000)
    monitor.recv_multipart()
    if kind == zmq.PUB:
        socket.invert_matching = True  # it sends what nobody subscribed to
    socket.sndtimeo = 5000
    with contextlib.suppress(zmq.Again):  # the connection ends meanwhile
        for _ in range(400_000):  # 14 MB on the line
            socket.send(v.COMMAND.name.encode() + b"\0", zmq.SNDMORE)
        socket.send(b"")
    until(lambda: attack.counts("too many bytes") == 1, 30.0)
    # libzmq 4.3.5 aborts the sender that is closed while its connection ends within a message.
    assert monitor.poll(10_000)
    socket.disable_monitor()
    monitor.close()
