"""A real gateway and holders of keys who write what they like into their frames."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest
import zmq

from hub.errors import HandlerFailedError, NotAllowedError
from hub.gateways.curve.curve_gateway import CurveGateway, curve_gateway
from hub.gateways.curve.removed_keys import RemovedKeys
from hub.gcm import navigation
from hub.gcm.common import COMMON_COMMAND, CommonCommand, CommonCommandKind
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import STOP, Stop
from hub.ipc.broker.central import Central
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import ClientKeys, read_client_keys
from hub.ipc.security.keyring import Keyring
from hub.ipc.wire import control, control_codec, frames
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

NEWEST = MessageDefinition(name="T_Newest", format="{int}", type=Number, plane=Plane.COMMAND)
GOAL = navigation.GOAL_COMMAND
UNREADABLE = "somebody, in a message that cannot be read"


class Hub:
    """Central with a gateway, a local module, an operator with a key, and raw sockets."""

    def __init__(self, folder: Path) -> None:
        self._keyring = Keyring(folder / "keys")
        gateway = curve_gateway("tcp://127.0.0.1:0", self._keyring)
        self.central = Central([f"ipc://{folder}/central"], gateways=[gateway])
        self.gateway = cast("CurveGateway", self.central.gateways[0])
        self._outside: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._raw: list[zmq.Socket[bytes]] = []
        self._peers: list[Peer] = []
        self.module = self.peer("navigation", self.central.endpoints[0], None)
        self.owner = self.client("owner", Role.OPERATE)

    def keys(self, name: str, role: Role) -> ClientKeys:
        return read_client_keys(self._keyring.make(name, role))

    def remove(self, name: str) -> None:
        self._keyring.remove(name)

    def client(self, name: str, role: Role) -> Peer:
        return self.connected(name, self.keys(name, role))

    def connected(self, name: str, keys: ClientKeys) -> Peer:
        return self.peer(name, self.central.endpoints[1], keys)

    def peer(self, name: str, endpoint: str, keys: ClientKeys | None) -> Peer:
        self._peers.append(Peer(name, endpoint, keys).connect())
        return self._peers[-1]

    def raw(self, keys: ClientKeys, topic: bytes) -> zmq.Socket[bytes]:
        """A socket where commands go in, once somebody there wants the topic."""
        made = self._outside.socket(zmq.XPUB)
        made.linger = 0
        keys.apply(made)
        made.connect(f"tcp://127.0.0.1:{self.gateway.ports[2]}")
        self._raw.append(made)
        seen: set[bytes] = set()
        until(
            lambda: b"\1!" + topic in seen,
            10.0,
            lambda: f"nobody subscribes to {topic!r}: {seen}",
            meanwhile=lambda: made.poll(50) and seen.add(made.recv()),
        )
        return made

    def publisher(self, keys: ClientKeys) -> zmq.Socket[bytes]:
        """A socket where states go in."""
        made = self._outside.socket(zmq.PUB)
        made.linger = 0
        made.reconnect_ivl = 20
        keys.apply(made)
        made.connect(f"tcp://127.0.0.1:{self.gateway.ports[0]}")
        self._raw.append(made)
        return made

    def dealer(self, keys: ClientKeys) -> zmq.Socket[bytes]:
        """A socket where control messages go in."""
        made = self._outside.socket(zmq.DEALER)
        made.linger = 0
        keys.apply(made)
        made.connect(self.central.endpoints[1])
        self._raw.append(made)
        return made

    def close(self) -> None:
        for raw in self._raw:
            raw.close()
        self._outside.term()
        for peer in self._peers:
            peer.close()
        self.central.close()


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Hub]:
    running = Hub(tmp_path)
    yield running
    running.close()


def frame(
    definition: MessageDefinition[Any], value: object, number: int, sequence: int, **changes: Any
) -> bytes:
    header = {
        "publisher": number,
        "fingerprint": definition.fingerprint,
        "sequence": sequence,
        "stamp_ns": time.monotonic_ns(),
        "payload": definition.encode(value),
    }
    return frames.pack(frames.prefix(definition.name, frames.FAR), **(header | changes))


def came(hub: Hub, definition: MessageDefinition[Any]) -> list[tuple[Any, Any]]:
    received = hub.module.collect(definition)
    hub.module.stands()
    return received


def dropped(hub: Hub, count: int = 1) -> None:
    counts = hub.central.faults.counts
    until(lambda: counts["command not allowed"] >= count, 10.0, lambda: str(counts))


def test_command_under_another_ones_number_comes_to_nobody_and_costs_the_owner_nothing(
    hub: Hub,
) -> None:
    received = came(hub, v.EVENT)
    evil = hub.keys("evil", Role.OPERATE)
    own = hub.connected("console of evil", evil).client.number
    raw = hub.raw(evil, b"T_Event\0")
    for index, number in enumerate((hub.owner.client.number, hub.module.client.number, 7)):
        raw.send(frame(v.EVENT, Number(value=-1), number, 1000 + index))
    dropped(hub, 3)
    raw.send(frame(v.EVENT, Number(value=5), own, 1))
    hub.owner.publish(v.EVENT, Number(value=1))
    hub.owner.publish(v.EVENT, Number(value=2))
    until(lambda: len(received) == 3, 10.0, lambda: str(received))
    senders = {(value.value, how.publisher) for value, how in received}
    assert senders == {(5, own), (1, hub.owner.client.number), (2, hub.owner.client.number)}


def test_two_holders_do_not_use_each_others_numbers(hub: Hub) -> None:
    received = came(hub, v.EVENT)
    first, second = hub.keys("first", Role.OPERATE), hub.keys("second", Role.SUPERVISE)
    number = hub.connected("console", first).client.number
    raw = hub.raw(second, b"T_Event\0")
    raw.send(frame(v.EVENT, Number(value=1), number, 1))
    dropped(hub)
    assert received == []


def test_number_of_a_client_that_has_left_is_nobodys(hub: Hub) -> None:
    came(hub, v.EVENT)
    keys = hub.keys("alice", Role.OPERATE)
    console = hub.connected("console", keys)
    number = console.client.number
    raw = hub.raw(keys, b"T_Event\0")
    console.close()
    until(lambda: hub.central.peer_of(number) is None, 10.0)
    raw.send(frame(v.EVENT, Number(value=1), number, 1))
    dropped(hub)


@pytest.mark.parametrize("role", [Role.OBSERVE, Role.OPERATE], ids=lambda role: role.value)
def test_forged_stops_stop_and_keep_no_later_stop_away(hub: Hub, role: Role) -> None:
    received = came(hub, STOP)
    raw = hub.raw(hub.keys("evil", role), b"GCM_Stop\0")
    number = hub.owner.client.number
    forged = [
        frame(STOP, Stop(reason="forged"), number, 1000),
        frame(STOP, Stop(reason="forged"), number, 1 << 23),
        frame(STOP, Stop(), number, 2000, payload=[b""]),
        frame(STOP, Stop(), number, 3000, fingerprint=1),
        frame(STOP, Stop(), number, 4000, stamp_ns=-(1 << 62)),
        b"!GCM_Stop\0" + bytes(6),
        b"!GCM_Stop\0",
    ]
    for each in forged:
        raw.send(each)
    until(lambda: len(received) == len(forged), 10.0, lambda: str(received))
    for index in range(3):
        hub.owner.publish(STOP, Stop(reason=f"mine {index}"))
    until(lambda: len(received) == len(forged) + 3, 10.0, lambda: str(received))
    reasons = [value.reason for value, _ in received]
    assert reasons[-3:] == ["mine 0", "mine 1", "mine 2"]
    assert reasons[:2] == ["forged", "forged"]
    assert reasons[2] == reasons[3] == reasons[5] == reasons[6] == UNREADABLE
    assert {how.publisher for _, how in received[: len(forged)]} == {0}
    assert hub.module.faults == []


def test_observer_stops_the_robot_and_does_nothing_else(hub: Hub) -> None:
    stops, goals = came(hub, STOP), came(hub, GOAL)
    wall = hub.client("wall", Role.OBSERVE)
    wall.publish(STOP, Stop(reason="it burns"))
    until(lambda: [value.reason for value, _ in stops] == ["it burns"], 10.0)
    raw = hub.raw(hub.keys("eye", Role.OBSERVE), b"GCM_Goal_Command\0")
    raw.send(frame(GOAL, navigation.GoalCommand(), wall.client.number, 1))
    dropped(hub)
    assert goals == []


def test_operator_neither_stops_modules_nor_drives_wheels(hub: Hub) -> None:
    ends, drives = came(hub, COMMON_COMMAND), came(hub, navigation.DRIVE_COMMAND)
    keys = hub.keys("evil", Role.OPERATE)
    own = hub.connected("console of evil", keys).client.number
    raw = hub.raw(keys, b"GCM_Common_Command\0")
    stop_all = CommonCommand(module="", command=CommonCommandKind.STOP)
    for number in (own, hub.module.client.number):
        raw.send(frame(COMMON_COMMAND, stop_all, number, 10_000_000))
        drive = frame(navigation.DRIVE_COMMAND, TwistStamped.planar(0.5, 0.0), number, 10_000_000)
        raw.send(drive)
    dropped(hub, 4)
    assert ends == drives == []
    hub.client("boss", Role.SUPERVISE).publish(COMMON_COMMAND, stop_all)
    until(lambda: ends, 10.0)


@pytest.mark.parametrize("far", [True, False], ids=["far", "local"])
def test_query_under_a_number_that_is_not_its_own_is_refused(hub: Hub, far: bool) -> None:  # noqa: FBT001
    asked: list[Number] = []
    module = hub.module
    module.call(lambda: module.client.respond(v.EVENT, v.ANSWER, asked.append))
    module.call(lambda: module.client.wait_defined(5.0))
    module.call(lambda: module.client.directory.listing(5.0))
    asker = (
        hub.client("evil", Role.OPERATE)
        if far
        else hub.peer("evil", hub.central.endpoints[0], None)
    )
    own, pending_queries = asker.client.number, asker.client.session.pending_queries
    for number in (own + 1, own - 1, hub.owner.client.number):
        forged = frame(v.EVENT, Number(value=4), number, 1)
        with pytest.raises(HandlerFailedError, match="under a number not its own"):
            asker.call(
                lambda forged=forged: pending_queries.ask_and_wait(
                    v.EVENT.name, forged, 5.0, asker.client.listen
                )
            )
    assert asked == []


def test_one_who_floods_the_door_does_not_keep_others_out(hub: Hub) -> None:
    received = came(hub, v.EVENT)
    raw = hub.raw(hub.keys("evil", Role.OBSERVE), b"T_Event\0")
    nonsense = frame(v.EVENT, Number(value=-1), 7, 1)
    for _ in range(20_000):
        raw.send(nonsense)
    for number in range(5):
        hub.owner.publish(v.EVENT, Number(value=number))
    until(lambda: len(received) == 5, 10.0, lambda: str(received))
    assert hub.central.faults.counts["command not allowed"]


@pytest.mark.parametrize("definition", [v.EVENT, NEWEST], ids=["all", "newest"])
@pytest.mark.parametrize(
    "payload",
    [b"", b"\0\1\0\0", b"\0\1\0\0" + bytes(90)],
    ids=["empty", "head", "long"],
)
def test_sequence_that_came_with_nonsense_is_not_believed(
    hub: Hub, definition: MessageDefinition[Any], payload: bytes
) -> None:
    received = came(hub, definition)
    keys = hub.keys("evil", Role.OPERATE)
    own = hub.connected("console of evil", keys).client.number
    raw = hub.raw(keys, definition.name.encode() + b"\0")
    for sequence in range(1, 6):
        raw.send(frame(definition, Number(value=-1), own, 1000 * sequence, payload=[payload]))
        raw.send(frame(definition, Number(value=sequence), own, sequence))
        until(lambda n=sequence: len(received) == n, 10.0, lambda: str(received))
    assert [value.value for value, _ in received] == [1, 2, 3, 4, 5]
    counts = hub.module.client.faults.counts
    assert counts["wrong format"] == 5
    assert not counts["out of order"]


def test_removed_key_neither_commands_nor_stops_nor_stays(hub: Hub) -> None:
    stops, events = came(hub, STOP), came(hub, v.EVENT)
    keys = hub.keys("evil", Role.OPERATE)
    console = hub.connected("console of evil", keys)
    own = console.client.number
    raw = hub.raw(keys, b"GCM_Stop\0")
    raw.send(frame(STOP, Stop(), own, 1))
    until(lambda: stops, 10.0)
    stops.clear()
    hub.remove("evil")
    until(lambda: hub.central.peer_of(own) is None, 10.0)
    until(lambda: isinstance(console.client.refusal, NotAllowedError), 10.0)
    raw.send(frame(STOP, Stop(), own, 2))
    raw.send(frame(v.EVENT, Number(value=1), own, 1))
    dropped(hub, 2)
    assert stops == events == []
    assert hub.owner.client.connected


def test_key_that_is_made_anew_with_the_same_name_ends_the_connections_of_the_old(
    hub: Hub,
) -> None:
    console = hub.connected("console", hub.keys("alice", Role.OPERATE))
    number = console.client.number
    hub.remove("alice")
    fresh = hub.keys("alice", Role.OPERATE)
    until(lambda: hub.central.peer_of(number) is None, 10.0)
    assert hub.connected("console anew", fresh).client.connected


def test_old_key_of_a_name_neither_commands_nor_stops_once_the_name_has_a_new_key(hub: Hub) -> None:
    stops, events = came(hub, STOP), came(hub, v.EVENT)
    old = hub.keys("alice", Role.OPERATE)
    raw = hub.raw(old, b"T_Event\0")
    hub.remove("alice")
    until(lambda: not hub.gateway.holds(old.principal), 10.0)
    fresh = hub.connected("console anew", hub.keys("alice", Role.OPERATE))
    own = fresh.client.number
    raw.send(frame(v.EVENT, Number(value=-1), own, 1000))
    raw.send(frame(STOP, Stop(reason="old key"), own, 1001))
    dropped(hub, 2)
    fresh.publish(v.EVENT, Number(value=1))
    until(lambda: events, 10.0)
    assert [value.value for value, _ in events] == [1]
    assert stops == []


def test_key_that_was_removed_and_made_anew_between_two_looks_is_refused(hub: Hub) -> None:
    events = came(hub, v.EVENT)
    old = hub.keys("alice", Role.OPERATE)
    raw = hub.raw(old, b"T_Event\0")
    hub.remove("alice")
    fresh = hub.connected("console anew", hub.keys("alice", Role.OPERATE))
    raw.send(frame(v.EVENT, Number(value=-1), fresh.client.number, 1000))
    dropped(hub)
    assert events == []
    until(lambda: not hub.gateway.holds(old.principal), 10.0)


def test_removed_key_of_a_module_publishes_no_states_and_the_others_go_on(hub: Hub) -> None:
    received = came(hub, v.LOG)
    keys = hub.keys("evil", Role.MODULE)
    other = hub.client("other", Role.MODULE)
    raw = hub.publisher(keys)
    sequence = itertools.count(1)

    def send() -> None:
        raw.send(frame(v.LOG, Number(value=-1), 7, next(sequence)))

    def publish() -> None:
        other.publish(v.LOG, Number(value=1))

    def came_from(value: int) -> bool:
        return value in [each.value for each, _ in received]

    until(lambda: came_from(-1), 10.0, meanwhile=send)
    until(lambda: came_from(1), 10.0, meanwhile=publish)
    hub.remove("evil")
    refused = "refused at the gateway's state in: unknown key"
    counts = hub.central.faults.counts
    until(lambda: counts[refused], 10.0, lambda: str(counts), meanwhile=send)

    def quiet() -> bool:
        """What was on its way when the connection ended has come."""
        received.clear()
        until(lambda: came_from(1), 10.0, meanwhile=publish)
        return not came_from(-1)

    until(quiet, 10.0)
    received.clear()
    for _ in range(20):
        send()
    until(lambda: came_from(1), 10.0, meanwhile=publish)
    assert not came_from(-1)
    assert other.client.connected


def test_control_messages_of_a_removed_key_are_refused(hub: Hub) -> None:
    keys = hub.keys("evil", Role.OPERATE)
    raw = hub.dealer(keys)
    until(lambda: keys.principal in hub.gateway.admitted(), 10.0)
    hub.remove("evil")
    until(lambda: not hub.gateway.holds(keys.principal), 10.0)
    raw.send(control_codec.pack(control.Hello(name="late", pid=1)))
    counts = hub.central.faults.counts
    until(lambda: counts["malformed control frame"], 10.0, lambda: str(counts))
    assert "late" not in hub.central.connected()


def test_list_that_cannot_be_read_ends_no_connection(tmp_path: Path) -> None:
    ended: list[object] = []
    keyring = Keyring(tmp_path)
    keyring.make("alice", Role.OPERATE)
    (alice,) = (holder.principal for holder in keyring.holders())
    keys = RemovedKeys(keyring, lambda: frozenset({alice}), ended.append)
    path = tmp_path / "list.toml"
    whole = path.read_text()
    path.write_text("[")
    keys.check(0.0)
    assert keys.holds(alice)
    path.write_text(whole)
    keys.check(2.0)
    assert keys.holds(alice)
    assert ended == []
    keyring.remove("alice")
    keyring.make("alice", Role.OPERATE)
    for now in (4.0, 6.0):
        keys.check(now)
        assert not keys.holds(alice)
        assert ended == [alice]
