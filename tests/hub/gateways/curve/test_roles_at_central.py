"""A whole central with a gateway: what holders of keys of each role can do, and cannot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest
import zmq

from hub.errors import EndpointError, HandlerFailedError, NotAllowedError
from hub.gateways.curve.curve_gateway import CurveGateway, curve_gateway
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import ClientKeys, read_client_keys
from hub.ipc.security.keyring import Keyring
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until


class Hub:
    """Central with a gateway, a local module, and clients from elsewhere."""

    def __init__(self, folder: Path) -> None:
        self._keyring = Keyring(folder / "keys")
        gateway = curve_gateway("tcp://127.0.0.1:0", self._keyring)
        self.central = Central([f"ipc://{folder}/central"], gateways=[gateway])
        self.gateway = cast("CurveGateway", self.central.gateways[0])
        self._peers: list[Peer] = []
        self.local = Peer("local", self.central.endpoints[0]).connect()
        self._peers.append(self.local)

    def keys(self, name: str, role: Role) -> ClientKeys:
        return read_client_keys(self._keyring.make(name, role))

    def client(self, name: str, role: Role) -> Peer:
        peer = Peer(name, self.central.endpoints[1], self.keys(name, role)).connect()
        self._peers.append(peer)
        return peer

    def close(self) -> None:
        for peer in self._peers:
            peer.close()
        self.central.close()


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Hub]:
    running = Hub(tmp_path)
    yield running
    running.close()


Values = list[int]


def _subscribed(peer: Peer, definition: object) -> Values:
    values: Values = []
    peer.call(lambda: peer.client.subscribe(definition, lambda n, _: values.append(n.value)))
    peer.call(lambda: peer.client.wait_subscribed(5.0))
    return values


@pytest.mark.parametrize("role", list(Role), ids=lambda role: role.value)
def test_every_role_sees_all_that_the_robot_says(hub: Hub, role: Role) -> None:
    one = hub.client("one", role)
    for definition in (v.LOG, v.EVENT, v.PICTURE_NUMBER):
        values = _subscribed(one, definition)
        for number in range(3):
            hub.local.publish(definition, Number(value=number))
            until(lambda values=values, n=number: values == list(range(n + 1)), 5.0)
    listing = one.call(lambda: one.client.directory.listing(5.0))
    roles = {peer.name: peer.role for peer in listing.peers}
    assert roles == {"local": "module", "one": role.value}
    hub.local.call(lambda: hub.local.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    hub.local.call(lambda: hub.local.client.directory.listing(5.0))
    ask = lambda: one.client.query_response(v.ASK, Number(value=4), v.ANSWER, timeout=5.0)  # noqa: E731
    assert one.call(ask) == Number(value=4)


@pytest.mark.parametrize("role", [Role.OPERATE, Role.MODULE], ids=lambda role: role.value)
def test_operators_and_modules_command(hub: Hub, role: Role) -> None:
    values = _subscribed(hub.local, v.EVENT)
    one = hub.client("one", role)
    for number in range(3):
        one.publish(v.EVENT, Number(value=number))
    until(lambda: values == [0, 1, 2], 5.0)


def test_observers_do_not_command_however_they_try(hub: Hub) -> None:
    values = _subscribed(hub.local, v.EVENT)
    one = hub.client("one", Role.OBSERVE)
    with pytest.raises(NotAllowedError, match=r"--role operate$"):
        one.publish(v.EVENT, Number(value=1))
    with pytest.raises(NotAllowedError, match="only a module of the robot sends it"):
        one.publish(v.LOG, Number(value=1))
    # One who has changed its own code is refused at the robot's side.
    connection = one.client.session.connection
    one.call(lambda: setattr(connection, "demand_right", lambda _: None))
    one.call(lambda: setattr(connection, "may_connect", lambda _: True))
    one.call(lambda: connection.start_over("to connect everywhere"))
    one.connect()
    one.publish(v.EVENT, Number(value=1))
    refused = "refused at the gateway's state in: role observe"
    until(lambda: hub.central.faults.counts[refused], 5.0)
    until(lambda: hub.central.faults.counts["not allowed"], 5.0)
    hub.local.publish(v.EVENT, Number(value=100))
    until(lambda: 100 in values, 5.0)
    assert values == [100]


def test_operators_are_no_part_of_the_robot(hub: Hub) -> None:
    hub.local.call(lambda: hub.local.client.define(v.ASK, v.ANSWER, v.LOG))
    hub.local.call(lambda: hub.local.client.wait_defined(5.0))
    one = hub.client("one", Role.OPERATE)
    with pytest.raises(NotAllowedError):
        one.publish(v.LOG, Number(value=1))
    one.call(lambda: one.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    until(lambda: hub.central.faults.counts["not allowed"] >= 1, 5.0)
    listing = hub.local.call(lambda: hub.local.client.directory.listing(2.0))
    assert not any("T_Ask" in peer.handles.split() for peer in listing.peers)
    one.call(lambda: one.client.define(v.STREAM))
    with pytest.raises(NotAllowedError, match="define a new message"):
        one.call(lambda: one.client.wait_defined(5.0))


def test_queries_on_the_command_plane_need_an_operator(hub: Hub) -> None:
    hub.local.call(lambda: hub.local.client.respond(v.EVENT, v.ANSWER, lambda ask: ask))
    hub.local.call(lambda: hub.local.client.wait_defined(5.0))
    hub.local.call(lambda: hub.local.client.directory.listing(5.0))

    def ask(peer: Peer) -> Number:
        return peer.call(
            lambda: peer.client.query_response(v.EVENT, Number(value=4), v.ANSWER, timeout=5.0)
        )

    assert ask(hub.client("one", Role.OPERATE)) == Number(value=4)
    with pytest.raises(
        HandlerFailedError,
        match=r"other has a key to observe and may not send T_Event; .*--role operate$",
    ):
        ask(hub.client("other", Role.OBSERVE))


def test_removed_key_does_not_come_back(hub: Hub, tmp_path: Path) -> None:
    one = hub.client("one", Role.OPERATE)
    Keyring(tmp_path / "keys").remove("one")
    one.call(lambda: one.client.session.connection.start_over("to connect again"))
    refused = "refused at the gateway's control: unknown key"
    until(lambda: hub.central.faults.counts[refused], 5.0)
    until(lambda: hub.central.connected() == ("local",), 5.0)
    until(lambda: isinstance(one.client.refusal, NotAllowedError), 5.0)
    assert "refuses the key 'one'" in str(one.client.refusal)
    hub.local.call(lambda: hub.local.client.directory.listing(5.0))


def test_client_without_keys_stays_on_its_machine(hub: Hub) -> None:
    with pytest.raises(EndpointError, match="rune-hub keys make"):
        Client("one", "tcp://robot.example:1481")
    # Without keys nobody gets through the gateway of this machine either.
    with zmq.Context() as context, context.socket(zmq.DEALER) as lonely:
        lonely.linger = 0
        lonely.connect(hub.central.endpoints[1])
        until(lambda: any("bad handshake at" in r for r in hub.central.faults.counts), 10.0)


def test_gateway_needs_keys(tmp_path: Path) -> None:
    with pytest.raises(EndpointError, match="folder of keys"):
        Central([f"ipc://{tmp_path}/central"], gateways=[curve_gateway("tcp://127.0.0.1:0", None)])
