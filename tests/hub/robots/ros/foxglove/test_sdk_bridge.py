"""The line to a bridge that Foxglove's own server is."""

import contextlib
import math
import time
from pathlib import Path

import pytest
from foxglove import ConnectionGraph
from foxglove.websocket import Capability, StatusLevel

from hub.ipc.transport.loop import Loop
from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.proposal import RosProposal
from hub.robots.ros.asking.survey import look_at
from hub.robots.ros.line_loop import LineLoop
from hub.robots.ros.opening import line_to
from tests.hub.robots.ros.foxglove.sdk_bridge import ALL, STRING, TWIST, SdkBridge
from tests.support.waiting import until

PLOUGHER = """<robot name="p">
<link name="base_link"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="plough"><collision><geometry><mesh filename="package://r/plough.stl"/></geometry>
</collision></link><joint name="j" type="fixed"><parent link="base_link"/><child link="plough"/>
<origin xyz="0.5 0 0"/></joint></robot>"""
TEXT = b"\0\1\0\0\x03\0\0\0hi\0"


@pytest.fixture
def bridge():
    bridge = SdkBridge()
    yield bridge
    bridge.server.stop()


@pytest.fixture
def line(bridge):
    line = line_to(ros_address(f"ws://127.0.0.1:{bridge.port}"))
    yield line
    line.close()


def wait(line, condition, why="it did not happen"):
    until(
        condition,
        20.0,
        lambda: f"{why}: {line.state}",
        meanwhile=lambda: line.advance(time.monotonic()),
    )


def test_a_subscribed_topic_comes_as_soon_as_the_robot_has_it(bridge, line):
    found = []
    line.subscribe("/text", lambda message: found.append((bytes(message.payload), message)))
    wait(line, lambda: line.state.up)
    channel = bridge.channel("/text")
    wait(line, lambda: bridge.subscribed)
    channel.log(TEXT)
    wait(line, lambda: found)
    payload, message = found[0]
    assert payload == TEXT
    assert message.topic.schema_name == "std_msgs/msg/String"
    assert (message.topic.encoding, message.topic.schema_encoding) == ("cdr", "ros2msg")
    assert message.topic.schema == STRING.data
    assert 0.0 <= message.age < 5.0
    assert 0.0 <= time.monotonic() - message.arrived < 20.0

    line.unsubscribe("/text")
    wait(line, lambda: not bridge.subscribed)
    channel.close()
    wait(line, lambda: "/text" not in line.graph.topics)


def test_names_of_types_are_those_of_ros_2(bridge, line):
    channel = bridge.channel("/cmd_vel", TWIST)
    wait(line, lambda: "/cmd_vel" in line.graph.topics)
    assert line.graph.topics["/cmd_vel"].schema_name == "geometry_msgs/msg/Twist"
    assert line.graph is line.graph
    channel.close()


def test_a_velocity_leaves_at_once_or_not_at_all(bridge, line):
    line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    assert line.encoding("/cmd_vel") == ""
    assert not line.publish("/cmd_vel", bytes(52))
    wait(line, lambda: line.encoding("/cmd_vel") == "cdr")
    wait(line, lambda: bridge.advertised)
    assert bridge.advertised == [("/cmd_vel", "cdr", "geometry_msgs/msg/Twist")]
    assert line.publish("/cmd_vel", memoryview(bytes(range(52))))
    wait(line, lambda: bridge.received)
    assert bridge.received == [bytes(range(52))]
    assert line.state.dropped == 1
    line.unadvertise("/cmd_vel")
    assert not line.publish("/cmd_vel", bytes(52))
    wait(line, lambda: not bridge.advertised)


def test_services_answer_or_say_why_not(bridge, line):
    def refuse(_):
        raise ValueError(reason)

    answers, reason = [], "the motor is off"

    def note(answer, why):
        answers.append((None if answer is None else bytes(answer), why))

    bridge.add_service("/e_stop", lambda request: request.payload[::-1])
    bridge.add_service("/refuse", refuse)
    line.call("/e_stop", b"", note, 5.0)
    assert answers.pop() == (None, "the line is not connected")
    wait(line, lambda: len(line.graph.services) == 2)
    service = line.graph.services["/e_stop"]
    assert (service.type, service.encoding) == ("std_srvs/srv/Trigger", "cdr")
    line.call("/e_stop", b"\0\1\0\0\5", note, 5.0)
    wait(line, lambda: answers)
    assert answers.pop() == (b"\5\0\0\1\0", "")
    line.call("/refuse", b"", note, 5.0)
    wait(line, lambda: answers)
    answer, why = answers.pop()
    assert answer is None
    assert reason in why
    line.call("/none", b"", note, 5.0)
    assert answers.pop() == (None, "the robot has no service /none")


def test_a_service_without_an_answer_ends_in_time(bridge, line):
    answers: list[object] = []
    bridge.add_service("/slow", lambda _: until(lambda: answers, 20.0) or b"")
    wait(line, lambda: line.graph.services)
    line.call("/slow", b"", lambda *answer: answers.append(answer), 0.05)
    wait(line, lambda: answers)
    assert answers == [(None, "the robot does not answer")]


def test_parameters_are_read_by_name_or_all(line):
    found: list[dict[str, object]] = []
    line.ask_parameters((), found.append, 5.0)
    assert found.pop() == {}
    wait(line, lambda: line.state.up)
    line.ask_parameters(("/base.cmd_vel_timeout", "/base.none"), found.append, 5.0)
    wait(line, lambda: found)
    assert found.pop() == {"/base.cmd_vel_timeout": 0.5}
    line.ask_parameters((), found.append, 5.0)
    wait(line, lambda: found)
    values = found.pop()
    assert values == {"/base.cmd_vel_timeout": 0.5, "/base.whole": 2.0, "/base.name": "diff"}
    assert isinstance(values["/base.whole"], float)


def plough(name):
    """A mesh from 0 to 0.3 m ahead of its link, 0.8 m wide."""
    corners = [(x, y, z) for x in (0.0, 0.3) for y in (-0.4, 0.4) for z in (0.0, 0.2)]
    lines = "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
    return f"solid\n{lines}".encode() if name == "package://r/plough.stl" else None


@pytest.fixture
def filed():
    """A bridge that gives a file of the robot."""
    bridge = SdkBridge(asset_handler=plough)
    bridge.parameters["/state.robot_description"] = PLOUGHER
    yield bridge
    bridge.server.stop()


def test_files_of_the_robot_are_fetched_and_refusals_have_reasons(filed, line):
    answers = []

    def note(content, why):
        answers.append((None if content is None else bytes(content), why))

    line.fetch("package://r/plough.stl", note, 5.0)
    wait(line, lambda: line.state.up)
    line.fetch("package://r/plough.stl", note, 5.0)
    none = "its bridge gives no files (capability assets)"
    assert answers == [(None, none), (None, none)]
    other = line_to(ros_address(f"ws://127.0.0.1:{filed.port}"))
    with contextlib.closing(other):
        wait(other, lambda: other.state.up)
        other.fetch("package://r/plough.stl", note, 5.0)
        other.fetch("package://r/none.stl", note, 5.0)
        wait(other, lambda: len(answers) == 4)
    assert answers[2] == (plough("package://r/plough.stl"), "")
    assert answers[3][0] is None
    assert "not found" in answers[3][1]


def test_meshes_of_the_robots_description_widen_its_outline(filed):
    channel = filed.channel("/cmd_vel", TWIST)
    address = ros_address(f"ws://127.0.0.1:{filed.port}")
    with contextlib.closing(LineLoop(line_to(address))) as loop:
        found = look_at(loop, address, 20.0)
    channel.close()
    model, fault = RosProposal(found).outline
    assert fault == ""
    assert max(x for x, _ in model.footprint) == pytest.approx(0.8, abs=0.03)
    assert max(y for _, y in model.footprint) == pytest.approx(0.4, abs=0.03)


def test_the_graph_names_the_nodes(bridge, line):
    channel = bridge.channel("/cmd_vel", TWIST)
    graph = ConnectionGraph()
    graph.set_published_topic("/cmd_vel", ["/joystick"])
    graph.set_subscribed_topic("/cmd_vel", ["/base", "/log"])
    wait(line, lambda: bridge.server.publish_connection_graph(graph) or line.graph.whole)
    wait(line, lambda: "/cmd_vel" in line.graph.topics)
    topic = line.graph.topics["/cmd_vel"]
    assert topic.publishers == ("/joystick",)
    assert sorted(topic.subscribers) == ["/base", "/log"]
    bridge.server.publish_connection_graph(ConnectionGraph())
    wait(line, lambda: not line.graph.topics["/cmd_vel"].publishers)
    assert line.graph.topics["/cmd_vel"].subscribers == ()
    channel.close()


def test_a_topic_without_a_channel_is_known_by_its_subscribers(bridge, line):
    graph = ConnectionGraph()
    graph.set_subscribed_topic("/cmd_vel", ["/base"])
    wait(line, lambda: bridge.server.publish_connection_graph(graph) or line.graph.whole)
    wait(line, lambda: "/cmd_vel" in line.graph.topics)
    topic = line.graph.topics["/cmd_vel"]
    assert (topic.subscribers, topic.schema_name, topic.encoding) == (("/base",), "", "")
    channel = bridge.channel("/cmd_vel", TWIST)
    wait(line, lambda: line.graph.topics["/cmd_vel"].schema_name)
    assert line.graph.topics["/cmd_vel"].subscribers == ("/base",)
    channel.close()


def test_the_newest_sentences_of_the_bridge_are_kept_until_it_takes_them_back(bridge, line):
    wait(line, lambda: line.state.up)
    bridge.server.publish_status("the camera is\x1b[2J hot", StatusLevel.Warning, "hot")
    wait(line, lambda: line.state.notes)
    assert line.state.notes == ("the camera is\\x1b[2J hot",)
    bridge.server.remove_status(["hot"])
    wait(line, lambda: not line.state.notes)
    for each in range(20):
        bridge.server.publish_status(f"note {each}", StatusLevel.Info)
    wait(line, lambda: "note 19" in line.state.notes)
    assert len(line.state.notes) == 8


def test_a_bridge_that_takes_no_commands_is_named(line):
    bridge = SdkBridge([each for each in ALL if each is not Capability.ClientPublish])
    line = line_to(ros_address(f"ws://127.0.0.1:{bridge.port}"))
    wait(line, lambda: line.state.up)
    assert line.state.notes == ()
    line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    assert "takes no commands" in line.state.notes[0]
    assert not line.publish("/cmd_vel", bytes(52))
    line.close()
    bridge.server.stop()


def test_another_session_begins_with_another_connection(bridge, line):
    found = []
    channel = bridge.channel("/text")
    line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    wait(line, lambda: bridge.subscribed and bridge.advertised)
    bridge.server.clear_session("another")
    wait(line, lambda: line.state.connections == 2)
    wait(line, lambda: bridge.subscribed and bridge.advertised)
    channel.log(TEXT)
    wait(line, lambda: found == [TEXT])
    assert line.publish("/cmd_vel", bytes(52))
    channel.close()


def test_a_restarted_bridge_gets_all_subscriptions_and_publishers(bridge, line):
    found = []
    line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    wait(line, lambda: bridge.advertised)
    bridge.server.stop()
    wait(line, lambda: not line.state.up)
    assert line.state.why
    assert line.graph.topics == {}
    assert line.encoding("/cmd_vel") == ""
    bridge.__init__(port=bridge.port)
    channel = bridge.channel("/text")
    wait(line, lambda: bridge.subscribed and bridge.advertised)
    assert line.state.why == ""
    channel.log(TEXT)
    wait(line, lambda: found == [TEXT])
    channel.close()


def test_a_new_connection_is_made_when_it_is_asked_for(line):
    wait(line, lambda: line.state.up)
    line.reconnect("the picture is old")
    assert (line.state.up, line.state.why) == (False, "the picture is old")
    wait(line, lambda: line.state.connections == 2)


def test_a_loop_wakes_when_messages_come(bridge, line):
    found = []
    loop = Loop()
    line.watch(loop, lambda: line.advance(time.monotonic()))
    line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    channel = bridge.channel("/text")
    wait(line, lambda: bridge.subscribed)
    channel.log(TEXT)
    until(lambda: found, 20.0, meanwhile=lambda: loop.listen(1.0))
    line.reconnect("to see that the file is left")
    wait(line, lambda: bridge.subscribed and line.state.up)
    channel.log(TEXT)
    until(lambda: len(found) == 2, 20.0, meanwhile=lambda: loop.listen(1.0))
    line.close()
    loop.close()
    channel.close()


def test_a_secured_bridge_is_met_when_its_certificate_is_trusted(monkeypatch):
    certificate = Path(__file__).with_name("robot_certificate.pem")
    pem = certificate.read_bytes()
    bridge = SdkBridge(tls_cert=pem, tls_key=pem)
    address, found = ros_address(f"wss://127.0.0.1:{bridge.port}"), []
    line = line_to(address)
    wait(line, lambda: line.state.why)
    assert "certificate is not trusted" in line.state.why
    assert "SSL_CERT_FILE" in line.state.why
    line.close()

    monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
    line = line_to(address)
    line.subscribe("/text", lambda message: found.append(bytes(message.payload)))
    line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    channel = bridge.channel("/text")
    wait(line, lambda: bridge.subscribed and bridge.advertised)
    large = bytes(300_000)  # more than a record of TLS
    channel.log(large)
    wait(line, lambda: found == [large])
    assert line.publish("/cmd_vel", bytes(52))
    wait(line, lambda: bridge.received)
    line.close()
    channel.close()
    bridge.server.stop()


@pytest.mark.parametrize("ahead_s", [-86400.0, 86400.0])
def test_the_age_does_not_depend_on_the_robots_clock(bridge, line, ahead_s):
    ages = []
    line.subscribe("/text", lambda message: ages.append(message.age))
    channel = bridge.channel("/text")
    wait(line, lambda: bridge.subscribed)
    for number, late_s in enumerate((0.0, 0.8)):
        channel.log(TEXT, log_time=int((time.time() + ahead_s - late_s) * 1e9))
        wait(line, lambda number=number: len(ages) > number)
    assert ages[0] < 1.0
    assert ages[1] == pytest.approx(0.8, abs=0.4)
    assert not math.isnan(ages[1])
    channel.close()
