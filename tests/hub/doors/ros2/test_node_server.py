"""The node of a hub among nodes that lie: a session without a network calls back."""

from __future__ import annotations

import logging
import random
import struct
from collections.abc import Callable

import pytest

from hub.doors.panels.wishes import MOST_PANELS
from hub.doors.ros2.node_server import MOST_TOKENS, NodeSettings, RosNodeServer
from hub.gcm.geometry import Twist
from hub.recording.topics import RecordedTopic
from hub.ros.rmw_zenoh import HASH_OF_HUMBLE, Endpoint, Entity, EntityKind, parse_token
from hub.ros.type_hashes import type_hash
from hub.zenoh.session import ZenohSample

KEY = f"0/cmd_vel/geometry_msgs::msg::dds_::Twist_/{type_hash(Twist.ros_type)}"
ODOMETRY = "nav_msgs/msg/Odometry"


class Declared:
    def undeclare(self) -> None:
        pass


class SilentSession:
    """Declares all, and has the callbacks."""

    zid = "abc"
    token_came: Callable[[str, bool], None]
    stick_came: Callable[[ZenohSample], None]

    def __init__(self) -> None:
        self.tokens: list[str] = []
        self.keys: list[str] = []

    def declare_token(self, key: str) -> Declared:
        self.tokens.append(key)
        return Declared()

    def publisher(self, key: str, *, latched: bool) -> Declared:
        del latched
        self.keys.append(key)
        return Declared()

    def watch_link(self, _changed: object) -> Declared:
        return Declared()

    def watch_tokens(self, _pattern: str, taken: Callable[[str, bool], None]) -> Declared:
        self.token_came = taken
        return Declared()

    def subscribe(self, _key: str, taken: Callable[[ZenohSample], None]) -> Declared:
        self.stick_came = taken
        return Declared()


@pytest.fixture
def session() -> SilentSession:
    return SilentSession()


@pytest.fixture
def node(session: SilentSession) -> RosNodeServer:
    return RosNodeServer(session, NodeSettings(drive=True), lambda: None)


def token(
    number: int, kind: EntityKind, name: str, type_name: str, hashed: str = type_hash(ODOMETRY)
) -> str:
    end = Endpoint(name=name, type=type_name, hash=hashed)
    entity = Entity(session="e", number=number, kind=kind, node_name="liar", endpoint=end)
    return entity.token(0)


def attached(publisher: int, stamp_ns: int = 0) -> bytes:
    return struct.pack("<qqB16s", 1, stamp_ns, 16, publisher.to_bytes(16, "little"))


def test_publishers_that_fell_silent_make_room_for_others(
    session: SilentSession, node: RosNodeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 0.0
    monkeypatch.setattr("hub.doors.ros2.node_server.time.monotonic", lambda: now)
    session.token_came(token(1, EntityKind.PUBLISHER, "/cmd_vel", Twist.ros_type), True)  # noqa: FBT003
    for liar in range(2 * MOST_PANELS):
        session.stick_came(ZenohSample(key=KEY, payload=b"", attachment=attached(liar)))
    assert len(node.take_wishes().panels) == MOST_PANELS
    now = 5.0
    session.stick_came(ZenohSample(key=KEY, payload=b"", attachment=attached(1000)))
    assert node.take_wishes().panels == {(1000, 0)}


def test_a_node_of_humble_gets_keys_of_its_own(session: SilentSession, node: RosNodeServer) -> None:
    of_humble = f"/nav_msgs::msg::dds_::Odometry_/{HASH_OF_HUMBLE}"
    odometry = node.open(RecordedTopic("/odom", schema_name=ODOMETRY))
    session.token_came(token(1, EntityKind.SUBSCRIBER, "/odom", ODOMETRY), True)  # noqa: FBT003
    assert node.take_wishes().watched == {odometry}
    assert not any(HASH_OF_HUMBLE in each for each in session.tokens + session.keys)
    later = token(2, EntityKind.SUBSCRIBER, "/odom", ODOMETRY, HASH_OF_HUMBLE)
    session.token_came(later, True)  # noqa: FBT003
    assert node.take_wishes().fresh == {odometry}
    node.open(RecordedTopic("/odom2", schema_name=ODOMETRY))
    node.take_wishes()
    assert [each for each in session.keys if HASH_OF_HUMBLE in each] == [
        f"0/odom{of_humble}",
        f"0/odom2{of_humble}",
    ]
    declared = [parse_token(each) for each in session.tokens if HASH_OF_HUMBLE in each]
    assert [(each.kind, each.endpoint.name) for each in declared if each.endpoint] == [
        (EntityKind.PUBLISHER, "/odom"),
        (EntityKind.SUBSCRIBER, "/cmd_vel"),
        (EntityKind.PUBLISHER, "/odom2"),
    ]
    assert len({each.number for each in declared}) == 3


def test_tokens_that_lie_fill_no_memory_and_hide_no_node(
    session: SilentSession, node: RosNodeServer, caplog: pytest.LogCaptureFixture
) -> None:
    odometry = node.open(RecordedTopic("/odom", schema_name=ODOMETRY))
    liars = [
        token(each, EntityKind.SUBSCRIBER, f"/t{each % 200}", "std_msgs/msg/String")
        for each in range(2 * MOST_TOKENS)
    ]
    with caplog.at_level(logging.WARNING):
        for each in liars:
            session.token_came(each, True)  # noqa: FBT003
    assert node.refused == {"too many": MOST_TOKENS}
    assert len(caplog.records) == 1
    honest = token(99_999, EntityKind.SUBSCRIBER, "/odom", ODOMETRY)
    session.token_came(honest, True)  # noqa: FBT003
    assert node.take_wishes().watched == {odometry}
    for each in (*liars, honest):
        session.token_came(each, False)  # noqa: FBT003
    assert node.take_wishes().watched == frozenset()


@pytest.mark.parametrize("count", [3_000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_damaged_tokens_and_velocities_are_counted_and_said_once(
    session: SilentSession, node: RosNodeServer, caplog: pytest.LogCaptureFixture, count: int
) -> None:
    dice = random.Random(8)
    whole = token(1, EntityKind.PUBLISHER, "/cmd_vel", Twist.ros_type).encode()
    keys = (KEY, KEY.replace("Twist", "Odd"), "0/cmd_vel/x/y")
    with caplog.at_level(logging.WARNING):
        for _ in range(count):
            damaged = bytearray(whole)
            damaged[dice.randrange(len(damaged))] = dice.randrange(256)
            session.token_came(damaged.decode("latin-1"), dice.random() < 0.7)
            attachment = dice.choice((None, dice.randbytes(33), dice.randbytes(dice.randrange(90))))
            if dice.random() < 0.3:
                attachment = attached(dice.randrange(99), dice.randrange(-(1 << 63), 1 << 63))
            payload = bytes(dice.choice((0, 52, 5000)))
            sample = ZenohSample(key=dice.choice(keys), payload=payload, attachment=attachment)
            session.stick_came(sample)
            wishes = node.take_wishes()
            assert len(wishes.panels) <= MOST_PANELS
            assert len(wishes.commands) <= 1
    assert min(node.refused["no token"], node.refused["no velocity"]) > count // 4
    assert len(caplog.records) <= 3 + count // 3_000
