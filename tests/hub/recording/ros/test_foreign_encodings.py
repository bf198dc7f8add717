"""Messages of foxglove and of ROS 1 are read as the libraries of their makers read them.

`tests/data/bags/make_foreign.py` made the files with these libraries.
"""

from __future__ import annotations

import base64
import contextlib
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.errors import RosMessageError
from hub.recording.chunks import LoggedMessage
from hub.recording.ros.bag import Bag
from hub.recording.ros.fields import field_rows
from hub.recording.topics import RecordedTopic
from hub.ros.decoding import RosDecoder
from hub.ros.schema import EMPTY
from hub.ros.values import RosValue

DATA = Path(__file__).parents[3] / "data" / "bags"
BY_OTHERS = json.loads((DATA / "read-by-others.json").read_text("utf-8"))
OTHER_NAMES = {"secs": "sec", "nsecs": "nanosec"}


def messages(name: str) -> dict[str, tuple[RecordedTopic, list[LoggedMessage]]]:
    with Bag.open(DATA / name) as bag:
        found: dict[str, tuple[RecordedTopic, list[LoggedMessage]]] = {}
        for each in bag.messages():
            topic = bag.channels[each.channel]
            found.setdefault(topic.name, (topic, []))[1].append(each)
        return found


def same(ours: Any, theirs: Any) -> bool:
    if isinstance(theirs, dict):
        names = {OTHER_NAMES.get(name, name): each for name, each in theirs.items()}
        values = dict(ours.fields()) if isinstance(ours, RosValue) else {}
        values.pop(EMPTY, None)
        return values.keys() == names.keys() and all(same(values[n], names[n]) for n in names)
    if isinstance(theirs, str) and isinstance(ours, np.ndarray):
        return ours.tobytes() == base64.b64decode(theirs)
    if isinstance(theirs, list):
        if theirs and isinstance(theirs[0], dict) and theirs[0].keys() == {"key", "value"}:
            ours = sorted(ours, key=lambda each: each.get("key"))  # a map has no order
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    return bool(ours == theirs) or (ours != ours and theirs != theirs)


@pytest.mark.parametrize("name", BY_OTHERS)
def test_messages_are_read_as_others_read_them(name: str) -> None:
    found = messages(name)
    assert found.keys() == BY_OTHERS[name].keys()
    for topic, expected in BY_OTHERS[name].items():
        described, logged = found[topic]
        decoder = RosDecoder.of(described)
        for each, theirs in zip(logged, expected, strict=False):
            assert same(decoder.decode(each.payload), theirs), topic


def test_messages_of_foxglove_become_those_of_ros_in_each_encoding() -> None:
    binary, text = messages("foxglove.mcap"), messages("foxglove-json.mcap")

    def as_ros(topic: tuple[RecordedTopic, list[LoggedMessage]]) -> list[tuple[str, str]]:
        rows = field_rows(RosDecoder.of(topic[0]).as_ros(topic[1][-1].payload))
        return [(each.path, each.text) for each in rows]

    for topic in ("/tf", "/pose", "/scan", "/camera/compressed", "/raw", "/points", "/map", "/way"):
        assert as_ros(binary[topic]) == as_ros(text[topic])
    scan = dict(as_ros(binary["/scan"]))
    assert (scan["angle_increment"], scan["range_max"]) == ("0.10472", "4")


DECODERS = {
    f"{name} {topic}": (RosDecoder.of(described), logged[-1].payload)
    for name in ("foxglove.mcap", "foxglove-json.mcap", "kinds.mcap", "ros1.mcap")
    for topic, (described, logged) in messages(name).items()
}


@settings(max_examples=300)
@given(data=st.data())
def test_any_bytes_are_a_message_or_refused(data: st.DataObject) -> None:
    decoder, payload = DECODERS[data.draw(st.sampled_from(sorted(DECODERS)))]
    broken = bytearray(payload[: data.draw(st.integers(0, len(payload)))])
    for _ in range(data.draw(st.integers(0, 4))):
        if broken:
            broken[data.draw(st.integers(0, len(broken) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(RosMessageError):
        field_rows(decoder.decode(bytes(broken)))
        with contextlib.suppress(TypeError, ValueError, OverflowError, IndexError):
            field_rows(decoder.as_ros(bytes(broken)))


@given(descriptors=st.binary(max_size=300))
def test_any_bytes_are_descriptors_or_refused(descriptors: bytes) -> None:
    with contextlib.suppress(RosMessageError):
        RosDecoder.of(RecordedTopic("/a", "a.B", "protobuf", descriptors, "protobuf"))


def part(number: int, content: bytes | int) -> bytes:
    """A field of protobuf."""
    if isinstance(content, int):
        return bytes([number << 3]) + varint(content)
    return bytes([number << 3 | 2]) + varint(len(content)) + content


def varint(number: int) -> bytes:
    out = b""
    while number > 127:
        out, number = out + bytes([number & 127 | 128]), number >> 7
    return out + bytes([number])


def message_type(name: str, *fields: tuple[str, str]) -> bytes:
    """A type with fields that are messages."""
    made = [
        part(1, label.encode()) + part(3, at) + part(4, 1) + part(5, 11) + part(6, kind.encode())
        for at, (label, kind) in enumerate(fields, start=1)
    ]
    return part(4, part(1, name.encode()) + b"".join(part(2, each) for each in made))


def test_types_of_types_of_types_take_no_time() -> None:
    levels = [message_type(f"T{n}", ("a", f".T{n + 1}"), ("b", f".T{n + 1}")) for n in range(30)]
    descriptors = part(1, b"".join([*levels, message_type("T30")]))
    topic = RecordedTopic("/a", "T0", "protobuf", descriptors, "protobuf")
    assert len(field_rows(RosDecoder.of(topic).decode(b""))) == 1000


def test_rings_of_types_end() -> None:
    descriptors = part(1, message_type("A", ("b", ".B")) + message_type("B", ("a", ".A")))
    topic = RecordedTopic("/a", "A", "protobuf", descriptors, "protobuf")
    decoder = RosDecoder.of(topic)
    assert [each.path for each in field_rows(decoder.decode(b""))] == ["b.a"]
    deep = b""
    for at in range(50):
        deep = part(1, deep)
        if at > 40:
            with pytest.raises(RosMessageError, match="deeper than 32"):
                decoder.decode(deep)


HOSTILE = {
    "ros1 text": ("ros1", "ros1msg", b"string a", struct.pack("<I", 1 << 31), "is missing"),
    "ros1 numbers": ("ros1", "ros1msg", b"float64[] a", struct.pack("<I", 1 << 31), "is missing"),
    "ros1 texts": ("ros1", "ros1msg", b"string[] a", struct.pack("<I", 1 << 31), "more than"),
    "ros1 nothing": (
        *("ros1", "ros1msg", b"std_msgs/Empty[] a", struct.pack("<I", 1 << 31), "more than"),
    ),
    "json depth": ("json", "jsonschema", b"", b"[" * 1_000_000, "no JSON"),
    "json cut": ("json", "", b"", b'{"a": ', "no JSON"),
    "json digits": ("json", "", b"", b"[" + b"9" * 5000 + b"]", ""),
    "json length": ("json", "", b"", b" " * (1 << 23) + b"1", "bytes of JSON"),
    "protobuf length": (
        *("protobuf", "protobuf", part(1, message_type("a", ("x", ".a"))), b"\x0a\xff\xff\xff\x7f"),
        "are announced",
    ),
    "protobuf values": (
        *("protobuf", "protobuf", part(1, message_type("a", ("x", ".a"))), b"\x10\x01" * 1_100_000),
        "more than",
    ),
}


@pytest.mark.parametrize("case", HOSTILE.values(), ids=HOSTILE)
def test_what_is_announced_is_not_believed(case: tuple[str, str, bytes, bytes, str]) -> None:
    encoding, schema_encoding, schema, payload, reason = case
    decoder = RosDecoder.of(RecordedTopic("/a", "a", schema_encoding, schema, encoding))
    if not reason:
        assert field_rows(decoder.decode(payload))
        return
    with pytest.raises(RosMessageError, match=reason):
        decoder.decode(payload)
