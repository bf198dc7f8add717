"""Texts and binary messages of bridges, also hostile ones."""

import contextlib
import json
import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import RosMessageError
from hub.robots.ros.foxglove import bridge_events as events
from hub.robots.ros.foxglove import wire
from hub.robots.ros.foxglove.ages import LineAges

NAMES = st.text(st.characters(categories=("L", "N")), min_size=1, max_size=20)
U32, U64 = st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1)
KEYS = st.sampled_from(
    ("channels", "id", "topic", "services", "parameters", "name", "value", "channelIds", "callId")
) | st.sampled_from(
    ("publishedTopics", "publisherIds", "statusIds", "message", "metadata", "capabilities")
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=20,
)
OPS = st.sampled_from(
    ("serverInfo", "advertise", "unadvertise", "advertiseServices", "unadvertiseServices")
) | st.sampled_from(
    ("status", "removeStatus", "parameterValues", "connectionGraphUpdate", "serviceCallFailure")
)


@given(op=OPS, values=st.dictionaries(KEYS, JSON, max_size=5))
def test_any_text_is_read_or_refused(op, values):
    refused: list[str] = []
    try:
        event = wire.read_text(json.dumps({**values, "op": op}).encode(), refused.append)
    except RosMessageError as fault:
        refused.append(str(fault))
    else:
        assert event is not None
    assert all(isinstance(reason, str) and reason.isprintable() for reason in refused)


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(data):
    with contextlib.suppress(RosMessageError):
        wire.read_binary(data)
    with contextlib.suppress(RosMessageError):
        wire.read_text(data, lambda _: None)


@given(subscription=U32, time_ns=U64, payload=st.binary(max_size=50))
def test_a_message_keeps_its_bytes(subscription, time_ns, payload):
    data = struct.pack("<BIQ", 1, subscription, time_ns) + payload
    event = wire.read_binary(data)
    assert isinstance(event, events.BridgeData)
    found = (event.subscription, event.time_ns, bytes(event.payload))
    assert found == (subscription, time_ns, payload)


@given(call=U32, encoding=NAMES, payload=st.binary(max_size=50))
def test_an_answer_is_laid_out_as_a_request(call, encoding, payload):
    request = wire.request(5, call, encoding, payload)
    event = wire.read_binary(b"\3" + request[1:])
    assert isinstance(event, events.BridgeAnswer)
    assert (event.call, bytes(event.payload)) == (call, payload)


@given(call=U32, reason=st.text(max_size=20), content=st.binary(max_size=50))
def test_a_file_comes_or_the_reason_why_not(call, reason, content):
    said = reason.encode()
    head = struct.pack("<BIBI", 4, call, 0, len(said)) + said
    event = wire.read_binary(head + content)
    assert (event.call, bytes(event.payload), event.why) == (call, content, "")
    event = wire.read_binary(struct.pack("<BIBI", 4, call, 1, len(said)) + said)
    assert (event.call, event.payload, bool(event.why)) == (call, None, True)
    cut = wire.read_binary(struct.pack("<BIBI", 4, call, 0, 1000) + said)
    assert cut.payload is None
    with pytest.raises(RosMessageError):
        wire.read_binary(head[:9])


@given(number=st.integers(0, 2**63 - 1), topic=NAMES, package=NAMES, kind=NAMES)
def test_a_channel_keeps_its_topic(number, topic, package, kind):
    channel = {"id": number, "topic": topic, "encoding": "cdr", "schemaName": f"{package}/{kind}"}
    event = wire.read_text(json.dumps({"op": "advertise", "channels": [channel]}).encode(), print)
    (found,) = event.channels.values()
    assert list(event.channels) == [number]
    assert (found.name, found.schema_name) == (topic, f"{package}/msg/{kind}")
    assert (found.schema, found.schema_encoding) == (b"", "")


@pytest.mark.parametrize(
    ("written", "encoding"), [("std_msgs/msg/String", "cdr"), ("std_msgs/String", "ros1")]
)
def test_a_publisher_names_the_type_as_its_ros_does(written, encoding):
    text = json.loads(wire.advertise(1, "/a", "std_msgs/msg/String", encoding))
    assert text["channels"][0]["schemaName"] == written


@given(
    ways=st.lists(st.floats(0.001, 0.9), min_size=1, max_size=30),
    difference_s=st.integers(-(10**6), 10**6),
)
def test_ages_do_not_depend_on_the_robots_clock(ways, difference_s):
    ages = LineAges()
    ages.answered(2.0 * min(ways), 100.0)
    found = []
    for now, way in enumerate([min(ways), *ways], 1000):
        sent_ns = 10**18 + round((now * 0.1 - way) * 1e9) + difference_s * 10**9
        found.append(ages.age(sent_ns, now * 0.1))
    assert found[1:] == pytest.approx(ways, abs=1e-6)


@pytest.mark.parametrize("step", [-3600.0, -5.0, 5.0, 3600.0])
def test_a_step_of_the_robots_clock_makes_no_message_old(step):
    ages = LineAges()
    found = [
        ages.age(int((10**6 + now * 0.1 + (0.0 if now < 100 else step)) * 1e9), now * 0.1)
        for now in range(500)
    ]
    assert found == pytest.approx([0.0] * 500, abs=1e-3)
    assert math.isnan(ages.age(0, 51.0))


def test_messages_that_waited_are_old_although_they_come_at_once():
    ages = LineAges()
    ages.age(10**18, 10.0)
    waited = [ages.age(10**18 + round(each * 1e9), 15.0) for each in (1.0, 2.0, 4.9, 5.0)]
    assert waited == pytest.approx([4.0, 3.0, 0.1, 0.0], abs=1e-3)
