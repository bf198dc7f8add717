"""The line to bridges that are old, slow, gone or wrong; time is given, sockets are real."""

import contextlib
import itertools
import json
import math
import os
import random
import signal
import socket
import struct
import subprocess
import sys

import pytest

from hub.robots.host_lookup import HostLookup
from hub.robots.ros.address import ros_address
from hub.robots.ros.foxglove.connection import MOST_MESSAGE
from hub.robots.ros.line import RosMessage
from hub.robots.ros.opening import line_to
from hub.ros.panel_door_name import panel_door_name
from tests.hub.robots.ros.foxglove.scripted_bridge import GREETING, channel
from tests.support.waiting import until


def test_the_door_of_a_hub_is_no_robot_and_gets_no_velocities(both):
    pair = both(greeting={**GREETING, "name": panel_door_name("rover")})
    pair.line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    pair.wait(lambda: "rune-hub serve foxglove" in pair.line.state.why)
    assert not pair.line.publish("/cmd_vel", b"")
    assert pair.line.state.connections == 0


def test_a_bridge_of_ros_1_gets_its_encoding_and_its_names(both):
    pair = both(
        greeting={**GREETING, "supportedEncodings": ["ros1"], "metadata": {"ROS_DISTRO": "noetic"}}
    )
    found = []
    pair.line.subscribe(
        "/odom", lambda message: found.append((bytes(message.payload), message.topic))
    )
    pair.line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    pair.wait(lambda: pair.line.state.up)
    services = [{"id": 3, "name": "/stop", "type": "std_srvs/Trigger", "requestSchema": ""}]
    pair.bridge.say({"op": "advertiseServices", "services": services})
    odom = {"encoding": "ros1", "schemaName": "nav_msgs/Odometry"}
    pair.bridge.say({"op": "advertise", "channels": [channel(7, "/odom", **odom)]})
    pair.wait(pair.bridge.subscriptions)
    pair.bridge.send(pair.bridge.data(pair.bridge.subscriptions()[7], b"ros 1"))
    pair.wait(lambda: found)
    payload, topic = found[0]
    assert (payload, topic.schema_name) == (b"ros 1", "nav_msgs/msg/Odometry")
    assert (topic.encoding, topic.schema_encoding) == ("ros1", "ros1msg")
    assert pair.line.graph.distribution == "noetic"
    assert pair.line.encoding("/cmd_vel") == "ros1"
    own = {"id": 1, "topic": "/cmd_vel", "encoding": "ros1", "schemaName": "geometry_msgs/Twist"}
    assert {"op": "advertise", "channels": [own]} in pair.bridge.texts

    answers = []
    pair.line.call("/stop", b"", lambda answer, why: answers.append((bytes(answer), why)), 5.0)
    pair.wait(lambda: pair.bridge.binaries)
    op, service, call, length = struct.unpack_from("<BIII", pair.bridge.binaries[0])
    assert (op, service, pair.bridge.binaries[0][13:]) == (2, 3, b"ros1")
    pair.bridge.send(struct.pack("<BIII", 3, service, call, length) + b"ros1" + b"\1")
    pair.wait(lambda: answers)
    assert answers == [(b"\1", "")]


@pytest.mark.parametrize("subprotocol", ["foxglove.sdk.v1", "foxglove.websocket.v1"])
def test_both_generations_of_bridges_are_met(both, subprotocol):
    pair = both(subprotocols=(subprotocol,))
    pair.wait(lambda: pair.line.state.up)


def test_another_server_is_named_and_asked_again_less_and_less_often(both):
    pair = both(subprotocols=("mqtt",))
    pair.wait(lambda: pair.line.state.why)
    assert "no bridge for Foxglove answers" in pair.line.state.why
    assert "400" in pair.line.state.why
    times = [pair.now]
    while len(times) < 11:
        seen = pair.bridge.connections
        while pair.bridge.connections == seen:
            pair.advance(0.125)
            pair.wait(lambda: pair.line.state.why)
        times.append(pair.now)
        for _ in range(5):  # until the line has read the refusal
            pair.advance()
    waits = [after - before for before, after in itertools.pairwise(times)]
    assert waits == [1.0] * 5 + [2.0, 3.0, 4.0, 5.0, 5.0]


def test_a_server_without_a_greeting_is_left_after_five_seconds(both):
    pair = both(greeting=None)
    pair.wait(lambda: pair.bridge.connections)
    pair.advance(4.9)
    assert pair.line.state.why == ""
    pair.advance(0.2)
    assert pair.line.state.why == "no bridge for Foxglove answers"


def test_a_missing_bridge_is_named():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    line = line_to(ros_address(f"ws://127.0.0.1:{port}"))
    until(lambda: line.state.why, 20.0, meanwhile=lambda: line.advance(0.0))
    assert "no program listens at its port" in line.state.why
    line.close()


def test_the_addresses_of_a_name_are_tried_in_turn(monkeypatch):
    def addresses(*_, flags=0, **__):
        if flags:
            raise socket.gaierror
        return [(family, 0, 0, "", (host, 1)) for family, host in ((10, "::1"), (2, "127.0.0.1"))]

    monkeypatch.setattr(socket, "getaddrinfo", addresses)
    lookup = HostLookup("robot", 1, socket.SOCK_STREAM)
    with pytest.raises(OSError, match="'robot' is being looked up"):
        lookup.address()

    def found():
        with contextlib.suppress(OSError):
            return [lookup.address(turn)[1][0] for turn in range(3)]

    until(found, 20.0)
    assert found() == ["::1", "127.0.0.1", "::1"]


def test_a_message_in_many_frames_is_whole(both):
    pair, found = both(), []
    pair.line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    (number,) = pair.meet("/text")
    payload = random.Random(1).randbytes(100_000)
    pair.bridge.send(pair.bridge.data(number, payload), parts=70)
    pair.wait(lambda: found)
    assert found == [payload]


def test_a_silent_bridge_gets_no_command_after_one_second_and_is_left_after_three(both):
    pair = both()
    pair.line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    for time in range(2):
        pair.bridge.answers = True
        pair.wait(lambda: pair.advance(0.1) or pair.line.encoding("/cmd_vel"))
        pinged(pair)
        assert pair.line.publish("/cmd_vel", bytes(52))
        pair.bridge.answers = False
        pair.advance(1.0)
        assert pair.line.publish("/cmd_vel", bytes(52))
        pair.advance(1.0)
        assert not pair.line.publish("/cmd_vel", bytes(52))
        pair.advance(1.9)
        assert pair.line.state.up
        pair.advance(0.2)
        assert pair.line.state.why == "the bridge has been silent for 3 s"
        assert pair.line.state.connections == time + 1


def pinged(pair):
    """A ping was answered just now."""
    before = pair.bridge.pings
    pair.advance(1.0)
    pair.wait(lambda: pair.bridge.pings > before)
    pair.advance()


def test_the_own_pause_ends_no_connection(both):
    pair = both()
    pair.wait(lambda: pair.line.state.up)
    pinged(pair)
    pair.advance(1.0)  # a ping that the bridge answers
    pair.advance(500.0)
    pinged(pair)
    assert (pair.line.state.up, pair.line.state.connections) == (True, 1)


def test_a_command_never_waits_behind_bytes_that_do_not_leave(both):
    pair, reasons = both(), []
    pair.line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    pair.wait(lambda: pair.line.encoding("/cmd_vel"))
    services = [{"id": 3, "name": "/big", "type": "std_srvs/srv/Trigger"}]
    pair.bridge.say({"op": "advertiseServices", "services": services})
    pair.wait(lambda: pair.line.graph.services)
    pair.bridge.answers = False
    while pair.line.publish("/cmd_vel", bytes(52)):
        pair.line.call("/big", bytes(100_000), lambda _, why: reasons.append(why), 5.0)
    assert pair.line.state.up
    while pair.line.state.up:
        pair.line.call("/big", bytes(100_000), lambda _, why: reasons.append(why), 5.0)
    assert pair.line.state.why == "the bridge takes nothing any more"
    assert set(reasons) == {"the line was lost: the bridge takes nothing any more"}


def test_a_flood_leaves_the_driver_time(both):
    pair = both()
    found: list[object] = []
    pair.line.subscribe("/text", found.append)
    (number,) = pair.meet("/text")
    frame = b"\x82\x11" + pair.bridge.data(number, bytes(4))
    pair.bridge.send_raw(frame * 20_000)
    sizes = []
    while len(found) < 20_000:
        before = len(found)
        pair.advance()
        sizes.append(len(found) - before)
    assert max(sizes) < 2000


def test_a_flood_of_pings_is_answered_in_parts(both):
    pair = both()
    pair.wait(lambda: pair.line.state.up)
    pair.bridge.send_raw(b"\x89\x00" * 200_000)
    heard = []
    for _ in range(5):
        pair.advance(0.01)
        heard.append(pair.line.state.heard)
    assert len(set(heard)) == 5  # the rest is still there


def test_too_long_a_message_ends_the_connection_in_words(both):
    pair = both()
    pair.wait(lambda: pair.line.state.up)
    pair.bridge.send_raw(b"\x82\x7f" + struct.pack(">Q", MOST_MESSAGE + 1))
    pair.wait(lambda: not pair.line.state.up)
    assert "the bridge sent what no WebSocket has" in pair.line.state.why
    pair.wait(lambda: pair.advance(0.1) or pair.line.state.up)
    assert pair.line.state.connections == 2


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (b"", "a binary message of 0 bytes"),
        (b"\1\0\0\0", "a binary message of 4 bytes"),
        (b"\3" + b"\xff" * 20, "a binary message of 21 bytes"),
        (struct.pack("<BIQ", 1, 99, 0), "a message is of a subscription that was never made"),
        ("[", "it is no JSON"),
        ("[" * 100_000, "it is no JSON"),
        ("[" + "1," * 200_001 + "1]", "a text has more than 200000 values"),
        ("{}", "a text has no name"),
        ({"op": 7}, "a text has no name"),
        ({"op": "advertise", "channels": 7}, "a text has no list in 'channels'"),
        ({"op": "advertise", "channels": [7]}, "something else than objects"),
        ({"op": "advertise", "channels": [channel(None, "/a")]}, "the channel of /a has no number"),
        ({"op": "advertise", "channels": [channel(-1, "/a")]}, "the channel of /a has no number"),
        ({"op": "advertise", "channels": [channel(1, "/\x1b[2J")]}, "a channel has no topic"),
        ({"op": "advertise", "channels": [channel(1, "/a" * 200)]}, "a channel has no topic"),
        ({"op": "advertise", "channels": [channel(1, "/a", schema=7)]}, "the definition of /a"),
        ({"op": "unadvertise", "channelIds": [None]}, "numbers in 'channelIds' that are none"),
        ({"op": "advertiseServices", "services": [{"id": 1}]}, "a service has no number"),
        ({"op": "parameterValues", "parameters": [{"name": 1}]}, "a parameter has no name"),
        ({"op": "serviceCallFailure"}, "the failure of a service has no number"),
    ],
)
def test_what_makes_no_sense_is_counted_and_described_once(both, message, reason):
    pair = both()
    pair.wait(lambda: pair.line.state.up)
    for _ in range(3):
        if isinstance(message, bytes):
            pair.bridge.send(message)
        else:
            pair.bridge.say(message.encode() if isinstance(message, str) else message)
    pair.wait(lambda: pair.line.state.faults == 3)
    (note,) = pair.line.state.notes
    assert note.startswith("the bridge sent what makes no sense: ")
    assert reason in note
    assert (pair.line.state.up, pair.line.state.connections) == (True, 1)


def test_what_is_unknown_is_left_out(both):
    pair = both()
    found: list[object] = []
    pair.line.subscribe("/text", found.append)
    (number,) = pair.meet("/text")
    pair.bridge.send(b"\5playback")
    pair.bridge.say({"op": "advertiseFuture", "things": 7})
    pair.bridge.send(pair.bridge.data(number, b""))
    pair.wait(lambda: found)
    assert pair.line.state.faults == 0


def test_a_topic_moves_to_another_channel(both):
    pair, found = both(), []
    pair.line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    (first,) = pair.meet("/text")
    pair.bridge.say({"op": "unadvertise", "channelIds": [0]})
    pair.bridge.say({"op": "advertise", "channels": [channel(1, "/text")]})
    pair.wait(lambda: 1 in pair.bridge.subscriptions())
    pair.bridge.send(pair.bridge.data(first, b"old"))
    pair.bridge.send(pair.bridge.data(pair.bridge.subscriptions()[1], b"new"))
    pair.wait(lambda: found)
    assert (found, pair.line.state.faults) == ([b"new"], 0)
    other = channel(1, "/text", schemaName="std_msgs/msg/Int8", schema="int8 data\n")
    pair.bridge.say({"op": "advertise", "channels": [other]})
    pair.wait(lambda: pair.line.graph.topics["/text"].schema_name == "std_msgs/msg/Int8")
    assert {"op": "unsubscribe", "subscriptionIds": [2]} in pair.bridge.texts
    assert pair.bridge.subscriptions()[1] == 3


@pytest.mark.parametrize("simulated", [False, True])
def test_messages_have_ages_unless_the_robots_time_is_that_of_a_simulation(both, simulated):
    """A simulation that runs slower than real time would make each message look older."""
    more = ["time"] if simulated else []
    pair = both(greeting=GREETING | {"capabilities": ["clientPublish", *more]})
    found: list[RosMessage] = []
    pair.line.subscribe("/text", found.append)
    (number,) = pair.meet("/text")
    for count in range(3):
        pair.advance(1.0)
        time_ns = int((50.0 + 0.5 * count) * 1e9)
        pair.bridge.send(pair.bridge.data(number, b"text", time_ns))
        pair.wait(lambda count=count: len(found) > count)
    ages = [each.age for each in found]
    assert all(map(math.isnan, ages)) if simulated else ages[-1] > 0.9
    assert [each.arrived - each.measured for each in found] == ([0.0] * 3 if simulated else ages)


@pytest.mark.parametrize("count", [20_000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_thousands_of_topics_are_not_all_kept(both, count):
    pair = both()
    found: list[object] = []
    pair.line.subscribe("/t4", found.append)
    pair.wait(lambda: pair.line.state.up)
    for start in range(0, count, 10_000):
        channels = [channel(each, f"/t{each}") for each in range(start, start + 10_000)]
        pair.bridge.say({"op": "advertise", "channels": channels})
        pair.advance()
    pair.wait(lambda: 4 in pair.bridge.subscriptions())
    pair.bridge.send(pair.bridge.data(pair.bridge.subscriptions()[4], b""))
    pair.wait(lambda: found)
    assert len(pair.line.graph.topics) == 5000
    assert pair.line.state.notes == ("the bridge has more than 5000 topics; the rest is not seen",)


def test_a_handler_may_end_the_line(both):
    pair, found = both(), []

    def take(message):
        found.append(bytes(message.payload))
        pair.line.reconnect("enough")

    pair.line.subscribe("/text", take)
    (number,) = pair.meet("/text")
    pair.bridge.send(pair.bridge.data(number, b"1"))
    pair.bridge.send(pair.bridge.data(number, b"2"))
    pair.wait(lambda: found)
    pair.wait(lambda: pair.advance(0.1) or pair.line.state.connections == 2)
    assert found == [b"1"]


def test_a_stopped_bridge_is_left_and_met_again():
    code = (
        "from tests.hub.robots.ros.foxglove.sdk_bridge import SdkBridge\n"
        "print(SdkBridge().port, flush=True)\ninput()"
    )
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", code], stdin=pipe, stdout=pipe) as process:
        line = line_to(ros_address(f"ws://127.0.0.1:{int(process.stdout.readline())}"))
        now = [0.0]

        def advance(step):
            now[0] += step
            line.advance(now[0])

        until(lambda: line.state.up, 20.0, meanwhile=lambda: advance(0.0))
        os.kill(process.pid, signal.SIGSTOP)
        until(lambda: not line.state.up, 20.0, meanwhile=lambda: advance(0.1))
        assert line.state.why == "the bridge has been silent for 3 s"
        assert now[0] < 10.0
        until(lambda: "no bridge" in line.state.why, 20.0, meanwhile=lambda: advance(0.1))
        os.kill(process.pid, signal.SIGCONT)
        until(lambda: line.state.up, 20.0, meanwhile=lambda: advance(0.02))
        line.close()
        process.stdin.close()


def _mutated(random_, messages):
    data = bytearray(random_.choice(messages))
    for _ in range(random_.randrange(4)):
        if data:
            data[random_.randrange(len(data))] = random_.randrange(256)
    return bytes(data[: random_.randrange(len(data) + 1)] if random_.random() < 0.3 else data)


@pytest.mark.parametrize("count", [3000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_mutated_messages_change_nothing(both, count):
    pair, found = both(), []
    pair.line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    (number,) = pair.meet("/text")
    values = [
        {"op": "advertise", "channels": [channel(9, "/t"), channel(8, "/u")]},
        {"op": "unadvertise", "channelIds": [9, 8]},
        {"op": "advertiseServices", "services": [{"id": 1, "name": "/s", "type": "a/srv/B"}]},
        {"op": "unadvertiseServices", "serviceIds": [1]},
        {"op": "status", "level": 2, "message": "/text is hot", "id": "a"},
        {"op": "removeStatus", "statusIds": ["a"]},
        {"op": "parameterValues", "parameters": [{"name": "a", "value": [1.0]}], "id": "rune-1"},
        {
            "op": "connectionGraphUpdate",
            "publishedTopics": [{"name": "/t", "publisherIds": ["/a"]}],
            "subscribedTopics": [{"name": "/t", "subscriberIds": ["/b"]}],
            "advertisedServices": [],
            "removedTopics": ["/u"],
            "removedServices": [],
        },
        {"op": "serviceCallFailure", "serviceId": 1, "callId": 1, "message": "off"},
    ]
    texts = [json.dumps(each).encode() for each in values]
    binaries = [
        pair.bridge.data(77, b"x"),
        struct.pack("<BIII", 3, 1, 1, 3) + b"cdr1",
        struct.pack("<BQ", 2, 1),
        struct.pack("<BIBI", 4, 1, 0, 0),
    ]
    random_ = random.Random(7)
    for each in range(count):
        if random_.random() < 0.5:
            pair.bridge.say(_mutated(random_, texts))
        else:
            pair.bridge.send(_mutated(random_, binaries))
        if each % 100 == 0:
            pair.advance()
    pair.bridge.send(pair.bridge.data(number, b"end"))
    pair.wait(lambda: b"end" in found)
    state = pair.line.state
    assert (state.up, state.connections) == (True, 1)
    assert state.faults > count / 20
    assert len(state.notes) < 12


@pytest.mark.parametrize("seed", range(20))
def test_random_bytes_end_the_connection_and_nothing_else(both, seed):
    pair = both()
    pair.wait(lambda: pair.line.state.up)
    pair.bridge.send_raw(random.Random(seed).randbytes(5000))
    pair.bridge.hang_up()
    pair.wait(lambda: not pair.line.state.up)
    assert pair.line.state.why
    pair.wait(lambda: pair.advance(0.1) or pair.line.state.up)
