"""Schema texts, and our payloads against those of others who read and write ROS 2 messages."""

from __future__ import annotations

import array
import enum
import io
from collections.abc import Sequence
from dataclasses import dataclass, make_dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from hub.errors import MessageFormatError
from hub.gcm.catalog import MESSAGES
from hub.ipc import ros_schema
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import codec
from hub.ipc.formats import grammar as formats
from tests.hub.gcm.test_wire import value_of
from tests.hub.ipc.formats.trees import same, structs, values_of
from tests.hub.ipc.ros_shape import definition_of, ros_value
from tests.support.cases import for_each


def _store(definition: MessageDefinition[Any]) -> Typestore:
    store = get_typestore(Stores.EMPTY)
    text, name = ros_schema.ros2msg(definition), ros_schema.ros_type(definition)
    store.register(get_types_from_msg(text, name))
    return store


def _made(store: Typestore, name: str, fields: Sequence[Any]) -> Any:
    """The other library's object of these fields, made by what it read from the schema."""
    described = store.fielddefs[name][1]
    members = [
        _member(store, kind, value) for (_, kind), value in zip(described, fields, strict=True)
    ]
    return store.types[name](*members)


def _member(store: Typestore, described: Any, value: Any) -> Any:
    kind, detail = described
    if kind == Nodetype.BASE:
        return value
    if kind == Nodetype.NAME:
        return _made(store, detail, value)
    element = detail[0]
    if element[0] == Nodetype.NAME or element[1][0] == "string":
        return [_member(store, element, item) for item in value]
    return np.array(value, np.dtype(element[1][0]))


def _plain(value: Any) -> Any:
    """What another library read, every struct as the list of its fields."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (array.array, bytes)):
        return list(value)
    names = getattr(value, "__slots__", None) or vars(value)
    return [_plain(getattr(value, name)) for name in names if not name.startswith("_")]


@st.composite
def _random_messages(draw: st.DrawFn) -> tuple[MessageDefinition[Any], Any]:
    tree = draw(structs(fewest=1).filter(lambda node: not _has_empty_struct(node)))
    return definition_of(tree), draw(values_of(tree))


def _has_empty_struct(node: formats.Format) -> bool:
    if isinstance(node, formats.Struct):
        return not node.members or any(map(_has_empty_struct, node.members))
    inner = getattr(node, "element", getattr(node, "target", None))
    return inner is not None and _has_empty_struct(inner)


def _read(definition: MessageDefinition[Any], payload: bytes) -> Any:
    """The value in a payload, not bounded."""
    return definition.build(codec.compiled(definition.wire_format).decode(payload))


def _agree(definition: MessageDefinition[Any], value: Any) -> None:
    """Our bytes are theirs, and both read the other's as the same values."""
    assert isinstance(definition.tree, formats.Struct)
    store, name = _store(definition), ros_schema.ros_type(definition)
    fields = ros_value(definition.tree, value)
    theirs = _made(store, name, fields)
    payload = b"".join(definition.encode(definition.build(value)))
    assert bytes(store.serialize_cdr(theirs, name)) == payload
    assert same(_plain(store.deserialize_cdr(payload, name)), fields)
    big = bytes(store.serialize_cdr(theirs, name, little_endian=False))
    assert big[:4] == bytes(4)
    assert b"".join(definition.encode(_read(definition, big))) == payload


@for_each("definition", MESSAGES)
def test_message_of_the_vocabulary_has_the_bytes_that_ros_writers_make(
    definition: MessageDefinition[Any],
) -> None:
    _agree(definition, definition.record.values(value_of(definition)))


@given(_random_messages())
def test_any_message_has_the_bytes_that_ros_writers_make(
    message: tuple[MessageDefinition[Any], Any],
) -> None:
    _agree(*message)


def _recorded(definition: MessageDefinition[Any], payloads: list[bytes]) -> io.BytesIO:
    file = io.BytesIO()
    writer = Writer(file)
    writer.start(profile="ros2", library="test")
    text = ros_schema.ros2msg(definition).encode()
    kind = writer.register_schema(ros_schema.ros_type(definition), "ros2msg", text)
    channel = writer.register_channel("/message", "cdr", kind)
    for number, payload in enumerate(payloads):
        writer.add_message(channel, log_time=number, publish_time=number, data=payload)
    writer.finish()
    file.seek(0)
    return file


def _read_back(definition: MessageDefinition[Any], value: Any) -> None:
    assert isinstance(definition.tree, formats.Struct)
    payload = b"".join(definition.encode(definition.build(value)))
    file = _recorded(definition, [payload] * 2)
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    read = [_plain(decoded.decoded_message) for decoded in reader.iter_decoded_messages()]
    wanted = ros_value(definition.tree, value)
    assert same(read, [wanted, wanted])


@for_each("definition", MESSAGES)
def test_recording_of_payloads_as_they_are_is_read_by_ros_tools(
    definition: MessageDefinition[Any],
) -> None:
    _read_back(definition, definition.record.values(value_of(definition)))


@given(_random_messages())
def test_recording_of_any_message_is_read_by_ros_tools(
    message: tuple[MessageDefinition[Any], Any],
) -> None:
    _read_back(*message)


def _same_types(definition: MessageDefinition[Any]) -> None:
    from_idl = get_types_from_idl(ros_schema.omg_idl(definition))
    from_msg = get_types_from_msg(ros_schema.ros2msg(definition), ros_schema.ros_type(definition))
    assert from_idl == from_msg


@for_each("definition", MESSAGES)
def test_idl_describes_the_same_types_as_ros2msg(definition: MessageDefinition[Any]) -> None:
    _same_types(definition)


@given(_random_messages())
def test_idl_of_any_message_describes_the_same_types_as_ros2msg(
    message: tuple[MessageDefinition[Any], Any],
) -> None:
    _same_types(message[0])


class _Gait(enum.IntEnum):
    WALK = 0
    TROT = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class StepPoint:
    x: float
    sequence: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _Step:
    gait: _Gait
    point: StepPoint
    next: _Step | None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Walk:
    name: str
    steps: _Step | None
    home: StepPoint | None
    grid: np.ndarray
    count: int
    ways: tuple[_Step | None, ...]
    table: tuple[tuple[StepPoint, ...], ...]
    shadow: Walk | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Walk:
    z: bool


_WALK = MessageDefinition(
    name="GCM_Walk",
    format="{string,*{{enum:1},{double,byte},*!},*{double,byte},[[short:2]:3,2],uint,"
    "<*{{enum:1},{double,byte},*!}:5>,[[{double,byte}:2]:2],*{boolean}}",
    type=_Walk,
)
_RULE = "=" * 80

_WALK_TEXT = f"""string name
rune_msgs/Step[] steps
rune_msgs/StepPoint[<=1] home
int16[12] grid
uint32 count
rune_msgs/GCMWalkWays[] ways
rune_msgs/StepPoint[4] table
rune_msgs/Walk[<=1] shadow
{_RULE}
MSG: rune_msgs/Walk
bool z
{_RULE}
MSG: rune_msgs/GCMWalkWays
rune_msgs/Step[] items
{_RULE}
MSG: rune_msgs/Step
int32 gait
rune_msgs/StepPoint point
{_RULE}
MSG: rune_msgs/StepPoint
float64 x
int8 sequence
"""

_WALK_IDL = """module rune_msgs {
  module msg {
    struct StepPoint {
      double x;
      int8 sequence;
    };
    struct Step {
      int32 gait;
      rune_msgs::msg::StepPoint point;
    };
    struct GCMWalkWays {
      sequence<rune_msgs::msg::Step> items;
    };
    struct Walk {
      boolean z;
    };
    struct GCMWalk {
      string name;
      sequence<rune_msgs::msg::Step> steps;
      sequence<rune_msgs::msg::StepPoint, 1> home;
      int16 grid[12];
      uint32 count;
      sequence<rune_msgs::msg::GCMWalkWays> ways;
      rune_msgs::msg::StepPoint table[4];
      sequence<rune_msgs::msg::Walk, 1> shadow;
    };
  };
};
"""


def test_schema_text_names_fields_and_types_as_the_dataclasses_do() -> None:
    assert ros_schema.ros_type(_WALK) == "rune_msgs/msg/GCMWalk"
    assert ros_schema.ros2msg(_WALK) == _WALK_TEXT
    assert ros_schema.omg_idl(_WALK) == _WALK_IDL
    _same_types(_WALK)


def test_message_that_is_a_list_has_a_field_of_nodes() -> None:
    listed = MessageDefinition(name="Steps", format="{{enum:1},{double,byte},*!}", type=_Step)
    assert ros_schema.ros2msg(listed).startswith(f"rune_msgs/Step[] nodes\n{_RULE}\n")


def test_type_that_is_one_of_ros_has_its_name_and_package() -> None:
    twist = definition_of(formats.parse("{{double},{double}}"), "geometry_msgs/msg/Twist")
    assert ros_schema.ros_type(twist) == "geometry_msgs/msg/Twist"
    assert "MSG: rune_msgs/RandomMessageA0\n" in ros_schema.ros2msg(twist)


@for_each("definition", MESSAGES)
def test_standard_types_of_the_vocabulary_are_those_of_ros_field_for_field(
    definition: MessageDefinition[Any],
) -> None:
    text, name = ros_schema.ros2msg(definition), ros_schema.ros_type(definition)
    ours, theirs = get_types_from_msg(text, name), get_typestore(Stores.LATEST).fielddefs
    for kind, (_, fields) in ours.items():
        if not kind.startswith(f"{ros_schema.PACKAGE}/"):
            assert fields == theirs[kind][1], kind


def test_two_types_of_one_standard_name_have_to_be_equal() -> None:
    names = {"__slots__": (), "ros_type": "geometry_msgs/msg/Vector3"}
    velocity = make_dataclass("Velocity", [("x", float)], frozen=True, namespace=names)
    place = make_dataclass("Place", [("x", float)], frozen=True, namespace=names)
    other = make_dataclass("Other", [("y", float)], frozen=True, namespace=names)
    pair = make_dataclass("Pair", [("one", velocity), ("two", place)], frozen=True)
    equal: MessageDefinition[Any] = MessageDefinition(name="Pair", type=pair)
    assert ros_schema.ros2msg(equal).splitlines() == [
        "geometry_msgs/Vector3 one",
        "geometry_msgs/Vector3 two",
        _RULE,
        "MSG: geometry_msgs/Vector3",
        "float64 x",
    ]
    pair = make_dataclass("Pair", [("one", velocity), ("two", other)], frozen=True)
    with pytest.raises(MessageFormatError, match="and they differ"):
        ros_schema.ros2msg(MessageDefinition(name="Pair", type=pair))


def test_types_of_one_name_are_told_apart() -> None:
    first = make_dataclass("Inner", [("x", int)], frozen=True)
    second = make_dataclass("Inner", [("y", float)], frozen=True)
    kind = make_dataclass("Outer", [("one", first), ("two", second), ("three", first)], frozen=True)
    outer: MessageDefinition[Any]
    outer = MessageDefinition(name="Inner", format="{{int},{double},{int}}", type=kind)
    lines = ros_schema.ros2msg(outer).splitlines()
    assert lines[:3] == [
        "rune_msgs/Inner2 one",
        "rune_msgs/Inner3 two",
        "rune_msgs/Inner2 three",
    ]
    assert lines.count("MSG: rune_msgs/Inner2") == 1
    assert "MSG: rune_msgs/Inner" not in lines


@for_each(
    ("text", "ros_type", "reason"),
    [
        ("{}", "", "RandomMessage is an empty struct"),
        ("{int,{}}", "", "RandomMessageA1 is an empty struct"),
        ("{int,*{int,[{int,{}}:2]}}", "", "is an empty struct"),
        ("{int}", "Twist", "'Twist' is not written package/msg/Name"),
        ("{int}", "geometry_msgs/Twist", "is not written package/msg/Name"),
        ("{int}", "geometry_msgs/msg/twist", "is not written package/msg/Name"),
        ("{int}", "geometry_msgs/msg/Twist\nint32 x", "is not written package/msg/Name"),
    ],
)
def test_message_without_a_ros_type_is_refused_with_the_reason(
    text: str, ros_type: str, reason: str
) -> None:
    tree = formats.parse(text)
    assert isinstance(tree, formats.Struct)
    definition = definition_of(tree, ros_type)
    for function in (ros_schema.ros_type, ros_schema.ros2msg, ros_schema.omg_idl):
        with pytest.raises(MessageFormatError, match=reason):
            function(definition)


@for_each("name", ["X", "x_", "x__y", "_x", "xY", "ä"])
def test_field_name_that_ros_does_not_allow_is_refused(name: str) -> None:
    kind = make_dataclass("Kind", [(name, int)], frozen=True)
    definition: MessageDefinition[Any] = MessageDefinition(name="M", format="{int}", type=kind)
    with pytest.raises(MessageFormatError, match="is no name for a field there"):
        ros_schema.ros2msg(definition)
