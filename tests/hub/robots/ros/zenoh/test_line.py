"""The line over Zenoh, against a router and nodes that know nothing of Rune."""

from __future__ import annotations

import math
import random
import selectors
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from hub.robots.ros.address import ros_address
from hub.robots.ros.line import RosLine, RosMessage
from hub.robots.ros.zenoh.line import ZenohLine
from hub.ros.decoding import RosDecoder
from tests.support.ros_node import DAY_NS, STORE, RosNode, dds, encoded
from tests.support.waiting import until
from tests.support.zenoh_router import ZenohRouter, zenoh_router

ODOMETRY = "nav_msgs/msg/Odometry"
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
MAP, TRANSFORMS = "nav_msgs/msg/OccupancyGrid", "tf2_msgs/msg/TFMessage"
TYPES = STORE.types


def twist(forward: float = 0.0) -> bytes:
    vector = TYPES["geometry_msgs/msg/Vector3"]
    none = vector(x=0.0, y=0.0, z=0.0)
    return encoded(TWIST, TYPES[TWIST](linear=vector(x=forward, y=0.0, z=0.0), angular=none))


class Driven:
    """A line, advanced by a loop as the driver does it."""

    def __init__(self, endpoint: str) -> None:
        where = endpoint.removeprefix("tcp/")
        self.line = ZenohLine(ros_address(f"zenoh+tcp://{where}"), node="rune")
        self.came: list[RosMessage] = []
        self._selector = selectors.DefaultSelector()
        self.line.watch(self, self._work)

    def watch(self, file: int, work: Callable[[], None]) -> None:
        self._selector.register(file, selectors.EVENT_READ, work)

    def unwatch(self, file: int) -> None:
        self._selector.unregister(file)

    def _work(self) -> None:
        self.line.advance(time.monotonic())

    def take(self, message: RosMessage) -> None:
        self.came.append(message)

    def turn(self) -> None:
        """One turn of the loop, 10 ms at most."""
        for key, _ in self._selector.select(0.01):
            key.data()
        self._work()

    def drive(self, payload: bytes) -> None:
        """Publish a command, and turn."""
        self.line.publish("/cmd_vel", payload)
        self.turn()

    def until(self, condition: Callable[[], object], timeout: float = 10.0) -> None:
        until(
            condition, timeout, lambda: f"{self.line.state} {self.line.graph}", meanwhile=self.turn
        )

    def close(self) -> None:
        self.line.close()
        self._selector.close()


@pytest.fixture(scope="module")
def shared() -> Iterator[ZenohRouter]:
    with zenoh_router() as running:
        yield running


@pytest.fixture
def router() -> Iterator[ZenohRouter]:
    with zenoh_router() as running:
        yield running


@pytest.fixture
def robot(shared: ZenohRouter) -> Iterator[RosNode]:
    node = RosNode(shared.endpoint)
    yield node
    node.leave()


@pytest.fixture
def driven(shared: ZenohRouter) -> Iterator[Driven]:
    made = Driven(shared.endpoint)
    made.until(lambda: made.line.state.up)
    yield made
    made.close()


def test_it_offers_what_every_line_does(driven: Driven) -> None:
    line: RosLine = driven.line
    assert line.state.connections == 1
    assert line.state.why == ""


def test_a_flood_of_tokens_leaves_time_between_two_parts_of_it(
    driven: Driven, robot: RosNode
) -> None:
    for number in range(2500):
        robot.publisher(f"/flood/topic_{number}", TWIST)

    def gained() -> int:
        before = len(driven.line.graph.topics)
        driven.turn()
        return len(driven.line.graph.topics) - before

    steps = [gained()]
    until(lambda: sum(steps) >= 2500, 20.0, meanwhile=lambda: steps.append(gained()))
    assert max(steps) <= 2000  # a turn advances twice
    assert driven.line.state.faults == 0


def test_the_graph_has_topics_services_and_nodes(driven: Driven, robot: RosNode) -> None:
    robot.publisher("/odom", ODOMETRY)
    robot.publisher("/sonar", "sensor_msgs/msg/Range")
    robot.subscribe("/cmd_vel", STAMPED, lambda *_: None)
    robot.serve("/e_stop", "std_srvs/srv/Trigger", lambda _: None)
    driven.line.advertise("/cmd_vel", STAMPED)
    driven.until(lambda: "/e_stop" in driven.line.graph.services)
    driven.until(lambda: "/cmd_vel" in driven.line.graph.topics)
    graph = driven.line.graph
    assert graph.whole
    assert graph.services["/e_stop"].type == "std_srvs/srv/Trigger"
    assert graph.topics["/odom"].schema_name == ODOMETRY
    assert graph.topics["/odom"].publishers == ("/robot",)
    stick = graph.topics["/cmd_vel"]
    assert (stick.schema_name, stick.subscribers, stick.publishers) == (STAMPED, ("/robot",), ())
    names = [each.name for each in RosDecoder.of(graph.topics["/sonar"]).type.fields]
    assert names[-1] == "variance"  # this robot is newer than the table of types
    robot.leave()
    driven.until(lambda: not driven.line.graph.topics)


def test_messages_come_in_both_forms_and_say_how_old_they_are(
    driven: Driven, robot: RosNode
) -> None:
    robot.clock_ahead_ns = -DAY_NS
    robot.serve("/e_stop", "std_srvs/srv/Trigger", lambda _: None)
    publish = robot.publisher("/odom", TWIST)
    publish_old = robot.publisher("/old", TWIST, old=True)
    driven.line.subscribe("/odom", driven.take)
    driven.line.subscribe("/old", driven.take)
    driven.until(lambda: len(driven.line.graph.topics) == 2)

    def heard(topic: str) -> bool:
        return any(each.topic.name == topic for each in driven.came)

    until(lambda: heard("/odom") and heard("/old"), 10.0,
          meanwhile=lambda: (publish(twist(0.5)), publish_old(twist()), driven.turn()))  # fmt: skip
    first = next(each for each in driven.came if each.topic.name == "/odom")
    assert bytes(first.payload) == twist(0.5)
    assert RosDecoder.of(first.topic).decode(first.payload).get("linear.x") == 0.5
    assert 0.0 <= first.age < 1.0
    robot.clock_ahead_ns -= 8 * 10**8  # the same as a message that was 0.8 s on its way
    publish(twist(1.0))
    driven.until(lambda: any(bytes(each.payload) == twist(1.0) for each in driven.came))
    late = next(each for each in driven.came if bytes(each.payload) == twist(1.0))
    assert late.age == pytest.approx(0.8, abs=0.4)


def test_latched_messages_of_before_come(driven: Driven, robot: RosNode) -> None:
    publish = robot.publisher("/tf_static", TRANSFORMS, latched=True)
    empty = encoded(TRANSFORMS, TYPES[TRANSFORMS](transforms=[]))
    publish(empty)
    driven.line.subscribe("/tf_static", driven.take)
    driven.until(lambda: driven.came)
    assert bytes(driven.came[0].payload) == empty
    assert math.isnan(driven.came[0].age)
    driven.line.unsubscribe("/tf_static")
    driven.line.subscribe("/tf_static", driven.take)
    driven.until(lambda: len(driven.came) == 2)


def test_commands_reach_a_node_with_another_hash_and_one_that_comes_later(
    driven: Driven, robot: RosNode
) -> None:
    taken: list[tuple[bytes, bytes]] = []
    driven.line.advertise("/cmd_vel", STAMPED)
    assert driven.line.encoding("/cmd_vel") == "cdr"
    robot.subscribe("/cmd_vel", STAMPED, lambda *both: taken.append(both))
    driven.until(lambda: "/cmd_vel" in driven.line.graph.topics)
    until(lambda: taken, 10.0, meanwhile=lambda: driven.drive(b"drive"))
    payload, attached = taken[0]
    assert payload == b"drive"
    sequence, stamp, length = struct.unpack_from("<qqB", attached)
    assert (sequence > 0, length, len(attached)) == (True, 16, 33)
    assert abs(stamp - time.time_ns()) < 60e9
    driven.line.unadvertise("/cmd_vel")
    assert driven.line.encoding("/cmd_vel") == ""
    assert not driven.line.publish("/cmd_vel", b"late")
    assert driven.line.state.dropped == 1


def test_a_slow_thread_gets_the_newest_picture_only(driven: Driven, robot: RosNode) -> None:
    seen: list[int] = []
    robot.subscribe("/camera", "sensor_msgs/msg/Image", lambda payload, _: seen.append(payload[0]))
    publish = robot.publisher("/camera", "sensor_msgs/msg/Image")
    driven.line.subscribe("/camera", driven.take)
    publish_state = robot.publisher("/odom", TWIST)
    driven.line.subscribe("/odom", driven.take)
    driven.until(lambda: len(driven.line.graph.topics) == 2)
    until(lambda: len(driven.came) > 2, 10.0,
          meanwhile=lambda: (publish(bytes(57_600)), driven.turn()))  # fmt: skip
    driven.turn()
    driven.came.clear()
    for number in range(20):
        publish(bytes([number]) * 57_600)
        publish_state(twist(number))
    until(lambda: seen[-1] == 19, 10.0)  # the thread of the line is busy meanwhile

    def of(topic: str) -> list[RosMessage]:
        return [each for each in driven.came if each.topic.name == topic]

    driven.until(lambda: len(of("/odom")) == 20 and of("/camera")[-1].payload[0] == 19)
    assert len(of("/camera")) < 10


def test_services_answer_or_say_why_not(driven: Driven, robot: RosNode) -> None:
    robot.serve("/e_stop", "std_srvs/srv/Trigger", lambda request: b"done " + request)
    robot.serve("/silent", "std_srvs/srv/Trigger", lambda _: None)
    driven.until(lambda: len(driven.line.graph.services) == 2)
    answers: dict[str, tuple[Any, str]] = {}
    for name in ("/e_stop", "/silent", "/missing"):
        driven.line.call(name, b"now", lambda *both, n=name: answers.__setitem__(n, both), 0.5)
    driven.until(lambda: len(answers) == 3)
    assert answers["/e_stop"] == (b"done now", "")
    assert answers["/silent"] == (None, "/silent did not answer within 0.5 s")
    assert answers["/missing"] == (None, "no node has the service /missing")


def test_parameters_are_read_by_name_and_all(driven: Driven, robot: RosNode) -> None:
    # As rcl_interfaces writes them: list_parameters and get_parameters of one node.
    listed = struct.pack("<4sII4sI", b"\0\1\0\0", 1, 4, b"age\0", 0)
    fixed = struct.pack("<BB2xqdI", 3, 0, 0, 0.25, 1)  # a double; then all that is empty
    one = fixed + struct.pack("<4x5I", 0, 0, 0, 0, 0)
    read = b"\0\1\0\0" + struct.pack("<I", 1) + one
    asked: list[bytes] = []
    robot.serve("/wheels/list_parameters", "rcl_interfaces/srv/ListParameters", lambda _: listed)
    robot.serve("/wheels/get_parameters", "rcl_interfaces/srv/GetParameters",
                lambda request: (asked.append(request), read)[1])  # fmt: skip
    driven.until(lambda: len(driven.line.graph.services) == 2)
    found: list[Any] = []
    driven.line.ask_parameters(("/wheels.age", "/missing.age"), found.append, 2.0)
    driven.line.ask_parameters((), found.append, 2.0)
    driven.until(lambda: len(found) == 2)
    assert asked == [struct.pack("<4sII4s", b"\0\1\0\0", 1, 4, b"age\0")] * 2
    assert found == [{"/wheels.age": 0.25}] * 2


def test_a_router_that_is_killed_and_comes_back_is_found_again(router: ZenohRouter) -> None:
    driven, robot = Driven(router.endpoint), RosNode(router.endpoint)
    try:
        taken: list[bytes] = []
        robot.subscribe("/cmd_vel", TWIST, lambda payload, _: taken.append(payload))
        publish = robot.publisher("/odom", TWIST)
        driven.line.subscribe("/odom", driven.take)
        driven.line.advertise("/cmd_vel", TWIST)
        driven.until(lambda: len(driven.line.graph.topics) == 2)
        router.kill()
        driven.until(lambda: not driven.line.state.up and not driven.line.graph.topics)
        assert driven.line.state.why == "the Zenoh router has left"
        assert not driven.line.publish("/cmd_vel", b"lost")
        router.start()
        driven.until(lambda: driven.line.state.up and len(driven.line.graph.topics) == 2)
        driven.came.clear()
        until(
            lambda: driven.came and taken,
            10.0,
            meanwhile=lambda: (publish(twist()), driven.drive(b"drive")),
        )
        assert b"lost" not in taken
        assert driven.line.state.connections == 2
    finally:
        driven.close()
        robot.leave()


def test_a_frozen_router_gets_no_velocities_that_would_arrive_late(router: ZenohRouter) -> None:
    driven, robot = Driven(router.endpoint), RosNode(router.endpoint)
    try:
        taken: list[int] = []
        robot.subscribe("/cmd_vel", TWIST, lambda payload, _: taken.append(payload[0]))
        driven.line.advertise("/cmd_vel", TWIST)
        driven.until(lambda: driven.line.state.up and "/cmd_vel" in driven.line.graph.topics)
        until(lambda: taken, 10.0, meanwhile=lambda: driven.drive(b"\0"))
        router.freeze()
        frozen = time.monotonic()
        driven.until(lambda: not driven.line.state.up)
        assert time.monotonic() - frozen < 2.0
        assert not driven.line.publish("/cmd_vel", b"\7")
        driven.until(lambda: driven.line.state.why == "the Zenoh router does not answer")
        router.thaw()
        driven.until(lambda: driven.line.state.up and "/cmd_vel" in driven.line.graph.topics)
        until(lambda: 8 in taken, 10.0, meanwhile=lambda: driven.drive(b"\x08"))
        assert 7 not in taken
    finally:
        driven.close()
        robot.leave()


def test_without_a_router_it_says_so_and_goes_on_trying(router: ZenohRouter) -> None:
    router.kill()
    driven = Driven(router.endpoint)
    try:
        driven.until(lambda: driven.line.state.why)
        assert driven.line.state.why == (
            f"no Zenoh router answers at {router.endpoint}; start one there, such as rmw_zenohd"
        )
        router.start()
        driven.until(lambda: driven.line.state.up)
        driven.line.reconnect("a picture is old")
        driven.until(lambda: driven.line.state.connections == 2)
        assert driven.line.state.why == "a picture is old"
    finally:
        driven.close()


@pytest.mark.parametrize("count", [10_000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_bytes_of_anyone_are_counted_said_once_and_harm_nothing(
    driven: Driven, robot: RosNode, count: int
) -> None:
    publish = robot.publisher("/odom", TWIST)
    driven.line.subscribe("/odom", driven.take)
    driven.until(lambda: "/odom" in driven.line.graph.topics)
    chance = random.Random(3)
    key = f"0/odom/{dds(TWIST)}/"
    for number in range(100):
        robot.announce(
            f"@ros2_lv/0/{'/'.join(chance.choices(['MP', '%', 'ä', '0', '..'], k=11))}/{number}"
        )
    for number in range(count):
        size = chance.choice((0, 1, 32, 33, 34, 77, 400))
        attached = None if size == 400 else chance.randbytes(size)
        robot.put(
            key + chance.choice(("x", STORE.hash_rihs01(TWIST))), chance.randbytes(8), attached
        )
        if number % 64 == 0:
            driven.turn()
    driven.came.clear()
    until(lambda: any(bytes(each.payload) == twist(2.0) for each in driven.came), 30.0,
          meanwhile=lambda: (publish(twist(2.0)), driven.turn()))  # fmt: skip
    state = driven.line.state
    assert state.up
    assert state.faults > 1000
    assert len(state.notes) == 2
