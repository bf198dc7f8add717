"""`rune-hub sim-ros` is a robot with ROS behind a bridge, for a client that is not Rune's."""

from __future__ import annotations

import json
import struct
import time
from contextlib import ExitStack, closing

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tests.support.command_line import rune_hub
from tests.support.ros_robot import SimulatedRos, client_of
from tests.support.waiting import until

AHEAD = struct.pack("<6d", 0.3, 0.0, 0.0, 0.0, 0.0, 0.0)
NEUTRAL = bytes(48)
CDR = b"\0\1\0\0"
STAMP_0 = struct.pack("<iII", 0, 0, 1) + bytes(4)
_CHANNEL, _CALL = 1, 7


class Client:
    """A client of a bridge, by websockets alone."""

    def __init__(self, robot):
        self._stack = ExitStack()
        self.link = self._stack.enter_context(client_of(robot.address))
        self.channels, self.services, self.graph, self.payloads, self.answers = {}, {}, {}, {}, {}
        self.close = self._stack.close
        self.send(op="subscribeConnectionGraph")

    def send(self, **order):
        self.link.send(json.dumps(order))

    def take(self, condition, timeout=10.0):
        """Read until something is so."""
        end = time.monotonic() + timeout
        while not condition():
            self._take(self.link.recv(timeout=max(0.01, end - time.monotonic())))

    def subscribe(self, *topics):
        self.take(lambda: set(topics) <= set(self.channels))
        wanted = [
            {"id": self.channels[each]["id"], "channelId": self.channels[each]["id"]}
            for each in topics
        ]
        self.send(op="subscribe", subscriptions=wanted)

    def publish_commands(self, encoding, kind):
        channel = {"id": _CHANNEL, "topic": "/cmd_vel", "encoding": encoding, "schemaName": kind}
        self.send(op="advertise", channels=[channel])
        self.take(lambda: "/foxglove_bridge" in self.graph.get("/cmd_vel", ()))

    def command(self, payload):
        self.link.send(struct.pack("<BI", 1, _CHANNEL) + payload)

    def call(self, service, payload=b""):
        self.take(lambda: service in self.services)
        found = self.services[service]
        encoding = found["request"]["encoding"].encode()
        head = struct.pack("<BIII", 2, found["id"], _CALL, len(encoding))
        self.link.send(head + encoding + payload)
        self.take(lambda: _CALL in self.answers)
        return self.answers.pop(_CALL)

    def decoded(self, topic):
        """The newest message of a topic, by rosbags and the bridge's own definition."""
        channel, payload = self.channels[topic], self.payloads[topic][-1]
        package, _, name = channel["schemaName"].replace("/msg/", "/").partition("/")
        kind, store = f"{package}/msg/{name}", get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(channel["schema"], kind))
        read = store.deserialize_ros1 if channel["encoding"] == "ros1" else store.deserialize_cdr
        return read(payload, kind)

    def _take(self, message):
        if isinstance(message, bytes):
            if message[0] == 1:
                number = struct.unpack_from("<I", message, 1)[0]
                topic = next(
                    each["topic"] for each in self.channels.values() if each["id"] == number
                )
                self.payloads.setdefault(topic, []).append(message[13:])
            elif message[0] == 3:
                _, call, length = struct.unpack_from("<III", message, 1)
                self.answers[call] = message[13 + length :]
            return
        read = json.loads(message)
        if read["op"] == "advertise":
            self.channels |= {each["topic"]: each for each in read["channels"]}
        elif read["op"] == "advertiseServices":
            self.services |= {each["name"]: each for each in read["services"]}
        elif read["op"] == "connectionGraphUpdate":
            self.graph |= {each["name"]: each["publisherIds"] for each in read["publishedTopics"]}


@pytest.fixture(scope="module", params=["cdr", "ros1"])
def robot(request, tmp_path_factory):
    options = ("--ros1",) if request.param == "ros1" else ()
    folder = tmp_path_factory.mktemp(request.param)
    with closing(SimulatedRos(folder, *options, "--other-publisher", "/joy")) as made:
        yield made


@pytest.fixture
def client(robot):
    with closing(Client(robot)) as made:
        yield made


def commanded(robot, velocity):
    """A velocity as the robot takes it: TwistStamped, with ROS 1 Twist."""
    return (CDR + STAMP_0 if robot.encoding == "cdr" else b"") + velocity


def begin(robot, client):
    newer = robot.encoding == "cdr"
    kind = "geometry_msgs/msg/TwistStamped" if newer else "geometry_msgs/Twist"
    client.publish_commands(robot.encoding, kind)
    robot.trace.write_text("")
    client.command(commanded(robot, NEUTRAL))
    client.command(commanded(robot, AHEAD))


def test_each_topic_is_read_by_its_own_definition(robot, client):
    wanted = ("/odom", "/scan", "/tf", "/camera/image_raw", "/map")
    client.subscribe(*wanted)
    client.take(lambda: set(wanted) <= set(client.payloads))
    assert client.decoded("/odom").child_frame_id == "base_link"
    assert len(client.decoded("/scan").ranges) == 360
    assert client.decoded("/camera/image_raw").data.size == 57_600
    with closing(Client(robot)) as later:
        later.subscribe("/map")  # it is latched
        later.take(lambda: "/map" in later.payloads)
        assert later.decoded("/map").data.max() == 100


def test_it_stops_half_a_second_after_the_last_command(robot, client):
    begin(robot, client)

    def moved():
        return [each["at"] for each in robot.lines() if each.get("motion", (0,))[0] > 0.0]

    until(moved, 5.0)
    until(lambda: time.monotonic() - moved()[-1] > 0.3, 5.0, "it goes on")
    ahead = [each for each in robot.commands() if each["twist"][0] == 0.3]
    assert 0.45 < moved()[-1] - ahead[-1]["at"] < 1.5  # then it brakes
    assert "/joy" in client.graph["/cmd_vel"]


def test_e_stop_holds_until_a_neutral_command_comes(robot, client):
    begin(robot, client)
    answer = client.call("/e_stop", CDR + b"\0" if robot.encoding == "cdr" else b"")
    assert b"neutral command" in answer
    for velocity in (AHEAD, NEUTRAL, AHEAD):
        client.command(commanded(robot, velocity))
    until(lambda: len(robot.commands()) >= 5, 5.0)
    assert [each["counts"] for each in robot.commands()] == [True, True, False, True, True]


def test_a_publisher_of_another_type_is_not_heard(robot, client):
    other_kind = "Twist" if robot.encoding == "cdr" else "TwistStamped"
    client.publish_commands(robot.encoding, f"geometry_msgs/msg/{other_kind}")
    robot.trace.write_text("")
    client.command(AHEAD)
    with closing(Client(robot)) as other:
        begin(robot, other)
        until(lambda: len(robot.commands()) >= 2, 5.0)
        assert len(robot.commands()) == 2


def test_what_cannot_start_says_why(robot):
    ended = rune_hub("sim-ros", "--port", str(robot.port))
    assert ended.returncode == 2
    assert "another program listens there; name another with --port" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
    assert rune_hub("sim-ros", "--port", "0", "--arena", "nowhere").returncode == 2
