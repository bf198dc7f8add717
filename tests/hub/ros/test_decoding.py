"""Messages of any ROS 2 type are read by the definition in their file, or refused in a sentence."""

from __future__ import annotations

import contextlib
import gc
import math
import random
import struct
import time
import weakref
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from hub.errors import RosMessageError
from hub.recording.topics import RecordedTopic
from hub.ros.decoding import RosDecoder
from hub.ros.known_types import known_texts
from hub.ros.schema import MOST_DEPTH, MOST_FIELDS
from hub.ros.values import RosValue

STORE = get_typestore(Stores.ROS2_HUMBLE)
"""Types and messages that others make."""
KNOWN = sorted(set(known_texts()) & set(STORE.fielddefs))
STORE_OF_ROS_1 = get_typestore(Stores.ROS1_NOETIC)
KNOWN_OF_ROS_1 = sorted(set(known_texts(1)) & set(STORE_OF_ROS_1.fielddefs))
PACKAGES = ("std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs", "tf2_msgs", "diagnostic_msgs")
SECTION = "=" * 80 + "\n"
HEAD = b"\0\1\0\0"


def topic(text: str, name: str = "a/msg/A", encoding: str = "ros2msg") -> RecordedTopic:
    return RecordedTopic("/a", name, encoding, text.encode())


def made(name: str, chance: random.Random, store: Any = STORE) -> Any:
    """A message of the type with random values."""
    values = [field(desc, chance, store) for _, desc in store.fielddefs[name][1]]
    return store.types[name](*values)


def field(desc: Any, chance: random.Random, store: Any) -> Any:
    kind, inner = desc
    if kind == Nodetype.NAME:
        return made(inner, chance, store)
    if kind == Nodetype.BASE:
        return number(inner[0], chance)
    element, most = inner
    count = most if kind == Nodetype.ARRAY else chance.randrange(4)
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        values = [number(element[1][0], chance) for _ in range(count)]
        kind = {"byte": "uint8", "char": "uint8", "octet": "uint8"}.get(*[element[1][0]] * 2)
        return np.array(values, kind)
    return [field(element, chance, store) for _ in range(count)]


def number(kind: str, chance: random.Random) -> Any:
    if kind == "string":
        return "".join(chance.choice("ab ü€") for _ in range(chance.randrange(6)))
    if kind == "bool":
        return chance.random() < 0.5
    if kind.startswith("float"):
        drawn = chance.choice([0.0, math.inf, chance.uniform(-1e6, 1e6)])
        return float(np.float32(drawn)) if kind == "float32" else drawn
    # Tools differ on the sign of a byte.
    info = np.iinfo({"byte": "int8", "char": "uint8"}.get(kind, kind))
    if kind == "byte":
        return chance.randint(0, 127)
    return chance.choice([int(info.min), int(info.max), chance.randint(info.min, info.max)])


def plain(value: Any, store: Any = STORE) -> Any:
    """A value of theirs or ours as lists."""
    if isinstance(value, RosValue):
        return [plain(each, store) for _, each in value.fields()]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(each, store) for each in value]
    if hasattr(value, "__msgtype__"):
        fields = store.fielddefs[value.__msgtype__][1]
        return [plain(getattr(value, name), store) for name, _ in fields]
    return value


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32), order=st.sampled_from(["little", "big"]))
def test_messages_of_others_are_read_as_they_wrote_them(seed: int, order: str) -> None:
    chance = random.Random(seed)
    for name in chance.sample(KNOWN, 12):
        message = made(name, chance)
        payload = bytes(STORE.serialize_cdr(message, name, little_endian=order == "little"))
        text = STORE.generate_msgdef(name, ros_version=2)[0]
        for schema in (text, ""):  # defined in the file, or known
            if not schema.strip() and not STORE.fielddefs[name][1]:
                continue
            read = RosDecoder.of(topic(schema, name)).decode(payload)
            assert plain(read) == plain(message), name


@pytest.mark.parametrize("schema_encoding", ["ros1msg", ""])
def test_types_of_ros_1_that_are_known_by_name_only_are_those_of_ros_1(
    schema_encoding: str,
) -> None:
    """A bridge without a package of messages names its types, and does not define them."""
    chance = random.Random(1)
    for name in KNOWN_OF_ROS_1:
        message = made(name, chance, STORE_OF_ROS_1)
        payload = bytes(STORE_OF_ROS_1.serialize_ros1(message, name))
        read = RosDecoder.of(RecordedTopic("/a", name, schema_encoding, b"", "ros1"))
        if payload:
            assert plain(read.decode(payload)) == plain(message, STORE_OF_ROS_1), name
        for wrong in (payload + b"\0", payload[:-1]) if payload else ():
            with pytest.raises(RosMessageError, match="bytes"):
                read.decode(wrong)
    assert len(KNOWN_OF_ROS_1) > 100


def test_a_type_that_differs_between_distributions_is_read_as_the_robot_has_it() -> None:
    later = get_typestore(Stores.ROS2_JAZZY)
    name = "sensor_msgs/msg/Range"
    for store in (later, STORE, later):
        message = made(name, random.Random(2), store)
        read = RosDecoder.of(topic("", name)).decode(bytes(store.serialize_cdr(message, name)))
        assert plain(read) == plain(message, store)
    name = "sensor_msgs/msg/BatteryState"  # before Noetic it had no temperatures
    message = made(name, random.Random(3), STORE_OF_ROS_1)
    message.cell_temperature = np.zeros(0, np.float32)
    payload = bytes(STORE_OF_ROS_1.serialize_ros1(message, name))
    after_header = 16 + len(message.header.frame_id.encode())
    cells = after_header + 31 + 4 + 4 * len(message.cell_voltage)
    old = payload[: after_header + 4] + payload[after_header + 8 : cells] + payload[cells + 4 :]
    battery = RosDecoder.of(RecordedTopic("/a", name, "ros1msg", b"", "ros1"))
    for each in (payload, old, payload):
        read = battery.decode(each)
        assert read.get("serial_number") == message.serial_number
        assert read.get("percentage") == message.percentage
        assert (read.field("temperature") is None) == (each is old)


def test_numbers_of_pictures_are_not_copied() -> None:
    payload = HEAD + struct.pack("<I", 1 << 20) + bytes(1 << 20)
    data = RosDecoder.of(topic("uint8[] data\n")).decode(payload).get("data")
    assert np.shares_memory(data, np.frombuffer(payload, np.uint8))


def test_fields_are_found_by_their_path() -> None:
    message = made("nav_msgs/msg/Odometry", random.Random(1))
    payload = bytes(STORE.serialize_cdr(message, "nav_msgs/msg/Odometry"))
    read = RosDecoder.of(topic("", "nav_msgs/Odometry")).decode(payload)
    assert read.get("pose.pose.position.x") == message.pose.pose.position.x
    assert read.get("header.frame_id") == message.header.frame_id
    for wrong in ("", "pose.x", "header.stamp.sec.more", "pose..pose"):
        with pytest.raises(RosMessageError, match=r"nav_msgs/msg/Odometry has no field"):
            read.get(wrong)


def test_definitions_may_have_comments_constants_defaults_and_bounds() -> None:
    text = (
        '# a "comment"\n\nint32 CLASS=5\nstring WORD="a # b"\r\nstring<=9 class "x # y"\n'
        "int8[<=4] few [1, 2]\nB[2] two   # B of the same package\n\n"
        f"{SECTION}MSG: a/B\nuint16 x 7\ntime when\n"
    )
    body = struct.pack("<I2sxxI2bHiIHxxiI", 2, b"k\0", 2, -1, -2, 3, 4, 5, 6, 7, 8)
    read = RosDecoder.of(topic(text)).decode(HEAD + body)
    assert plain(read) == ["k", [-1, -2], [[3, [4, 5]], [6, [7, 8]]]]


IDL = """
#include "std_msgs/msg/Header.idl"
module a { module msg {
  module A_Constants { const long CLASS = 5; };
  typedef double double__2[2];
  @verbatim (language="comment", text="brackets ) { in words")
  struct A {
    @unit("m") double x; // ahead
    double__2 pair; sequence<octet, 5> few; string<7> word;
    std_msgs::msg::Header header; unsigned long long count; boolean flags[3];
  };
}; };
"""


def test_definitions_in_idl_are_read() -> None:
    body = struct.pack(
        "<3dIB3xI2sxxiII1s3xQ3?", 1, 2, 3, 1, 9, 2, b"w\0", 4, 5, 1, b"\0", 6, 1, 0, 1
    )
    expected = [1.0, [2.0, 3.0], [9], "w", [[4, 5], ""], 6, [True, False, True]]
    assert plain(RosDecoder.of(topic(IDL, encoding="ros2idl")).decode(HEAD + body)) == expected
    whole = f"{SECTION}IDL: a/msg/A\n{IDL}{SECTION}MSG: b/msg/C\nint8 x\n"
    assert plain(RosDecoder.of(topic(whole, encoding="ros2idl")).decode(HEAD + body)) == expected


def nested(depth: int, twice: str = "") -> str:
    inner = (f"{SECTION}MSG: a/B{n}\nB{n + 1} b\n{twice.format(n + 1)}" for n in range(depth))
    return "B0 b\n" + "".join(inner) + f"{SECTION}MSG: a/B{depth}\nint32 x\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("A a\n", "contains a/msg/A within itself"),
        (f"B[] b\n{SECTION}MSG: a/B\nA[] a\n", "within itself"),
        (nested(300), "deeper than 16"),
        (nested(13, "B{} c\n"), "more than 2000 fields"),
        ("int32 x\n" * 2001, "more than 2000 fields"),
        ("uint8[4000000000] x\n", "4000000000 elements"),
        ("uint8[0] x\n", "0 elements"),
        ("other/Thing x\n", "lacks the definition of other/msg/Thing"),
        ("", "lacks the definition of a/msg/A"),
        ("wstring x\n", "wstring"),
        ('{"type": "object"}', "is no field"),
        (f"int8 x\n{SECTION}int8 y\n", "part without a name"),
        ("# " + "x" * (1 << 20), "longer than"),
        ("int8 \x00\n", "is no field"),
    ],
)
def test_definitions_that_cannot_be_are_refused(text: str, words: str) -> None:
    with pytest.raises(RosMessageError, match=words):
        RosDecoder.of(topic(text))


def test_the_deepest_definition_is_read() -> None:
    """Python reads no more than 20 loops within each other, and a decoder is Python."""
    inner = "".join(f"{SECTION}MSG: a/B{n}\nB{n + 1}[] b\n" for n in range(MOST_DEPTH - 2))
    text = f"B0[] b\n{inner}{SECTION}MSG: a/B{MOST_DEPTH - 2}\nint32 x\n"
    ones = struct.pack("<I", 1) * (MOST_DEPTH - 1)
    assert RosDecoder.of(topic(text)).decode(HEAD + ones + b"\7\0\0\0").name == "a/msg/A"


@pytest.mark.parametrize("field", ["string", "uint8[]", "B[]"])
def test_the_largest_definition_takes_a_bounded_time(field: str) -> None:
    rest = f"{SECTION}MSG: a/B\nint8 y\n"
    text = "".join(f"{field} x{n}\n" for n in range(MOST_FIELDS)) + rest
    begun = time.process_time()
    with pytest.raises(RosMessageError):
        RosDecoder.of(topic(text)).decode(HEAD + bytes(100))
    assert time.process_time() - begun < 5.0


def test_decoders_are_kept_within_a_bound() -> None:
    small = [RosDecoder.of(topic(f"int8 x{n}\n")) for n in range(100)]
    assert all(RosDecoder.of(topic(f"int8 x{n}\n")) is small[n] for n in range(100))
    large = [weakref.ref(RosDecoder.of(topic(f"int8 y{n}\n" * 900))) for n in range(40)]
    gc.collect()
    assert 0 < sum(each() is not None for each in large) <= 10_000 // 900


@pytest.mark.parametrize(
    "text", ["module a {", "struct", "x", IDL[:200], IDL + "}", "typedef a b[0];"]
)
def test_broken_idl_is_refused(text: str) -> None:
    with pytest.raises(RosMessageError):
        RosDecoder.of(topic(text, encoding="ros2idl"))


MANY = HEAD + struct.pack("<I", 0xFFFF_FFFF) + bytes(64)
MILLIONS = HEAD + struct.pack("<I", 8 << 20) + bytes(8 << 20)


@pytest.mark.parametrize(
    ("text", "payload"),
    [
        ("int32[] x\n", MANY),
        ("string x\n", MANY),
        ("string[] x\n", MANY),
        (f"B[] x\n{SECTION}MSG: a/B\n", MANY),
        (f"B[] x\n{SECTION}MSG: a/B\n", MILLIONS),
        (f"B[16000000] x\n{SECTION}MSG: a/B\nint8 y\n", MILLIONS),
        ("uint8[16000000] x\n", MANY),
        ("bool x\n", HEAD + b"\7"),
        ("string x\n", HEAD + b"\2\0\0\0\xff\0"),
        ("int8 x\n", b"\0\7\0\0\1"),
        ("int8 x\n", b""),
        ("int8 x\n", HEAD + bytes(5)),
    ],
)
def test_payloads_that_do_not_fit_are_refused(text: str, payload: bytes) -> None:
    with pytest.raises(RosMessageError, match="does not fit a/msg/A"):
        RosDecoder.of(topic(text)).decode(payload)


@settings(max_examples=200)
@given(
    text=st.text(max_size=300) | st.from_regex(r"(int8|A|string)(\[\d*\])? \w+\n(===\nMSG: a/A\n)?")
)
def test_any_text_is_a_definition_or_refused(text: str) -> None:
    for encoding in ("ros2msg", "ros2idl"):
        with contextlib.suppress(RosMessageError):
            RosDecoder.of(topic(text, encoding=encoding))


@settings(max_examples=100)
@given(data=st.data())
def test_any_bytes_are_a_message_or_refused(data: st.DataObject) -> None:
    name = data.draw(st.sampled_from([each for each in KNOWN if each.startswith(PACKAGES)]))
    body = data.draw(st.binary(max_size=200))
    decoder = RosDecoder.of(topic("", name))
    with contextlib.suppress(RosMessageError):
        assert decoder.decode(HEAD + body).name == name


def test_other_encodings_are_named() -> None:
    for encoding, schema in (("cbor", "jsonschema"), ("flatbuffer", "flatbuffer"), ("cdr", "x")):
        with pytest.raises(RosMessageError, match=f"are {encoding} .{schema}., and Rune reads cdr"):
            RosDecoder.of(RecordedTopic("/a", "x", schema, b"\xff", encoding))
    with pytest.raises(RosMessageError, match="is no text"):
        RosDecoder.of(RecordedTopic("/a", "x", "ros2msg", b"\xff"))


def test_known_types_are_those_of_ros() -> None:
    for store, encoding, names in ((STORE, "cdr", KNOWN), (STORE_OF_ROS_1, "ros1", KNOWN_OF_ROS_1)):
        for name in names:
            ours = RosDecoder.of(RecordedTopic("/a", name, "", b"", encoding)).type
            theirs = [each for each, _ in store.fielddefs[name][1]]
            assert [each.name for each in ours.fields] == theirs, name
    assert len(KNOWN) > 130
