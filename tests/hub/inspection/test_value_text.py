"""FIELD=VALUE on the command line, and values as people and programs read them."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError, RangeError
from hub.gcm import mapping, navigation, vision
from hub.gcm.autonomy import AUTONOMY_COMMAND
from hub.gcm.catalog import MESSAGES
from hub.gcm.geometry import Twist
from hub.gcm.ranges import RANGES
from hub.inspection.value_text import demand_within_ranges, lines, plain, value_from_text
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import codec
from hub.ipc.formats import grammar as formats
from hub.ipc.wire.definition_listing import from_listing, to_listing
from tests.hub.ipc.formats.trees import structs, values_of
from tests.hub.ipc.ros_shape import definition_of
from tests.support.cases import for_each


def test_fields_left_out_are_zero_for_every_message_of_the_vocabulary() -> None:
    for definition in MESSAGES:
        value = value_from_text(definition, [])
        payload = b"".join(definition.encode(value))
        back = definition.build(codec.compiled(definition.wire_format).decode(payload))
        assert plain(back) == plain(value)


def test_inner_fields_are_reached_with_dots() -> None:
    given = ["twist.linear.x=0.5", "twist.angular.z=-1"]
    command = value_from_text(navigation.VELOCITY_COMMAND, given)
    assert command.twist == Twist.planar(0.5, -1.0)


def test_enum_members_go_by_name_or_number() -> None:
    by_name = value_from_text(vision.IMAGE_REQUEST, ["kind=grey"])
    by_number = value_from_text(vision.IMAGE_REQUEST, ["kind=0"])
    assert by_name == by_number
    assert by_name.kind is vision.ImageKind.GREY


def test_arrays_are_json_lists() -> None:
    grown = value_from_text(mapping.MAP, ["data=[1, 2, 3]"]).data
    assert grown == [1, 2, 3]


def test_text_is_taken_as_it_is() -> None:
    assert value_from_text(navigation.STOP, ["reason=a=b c"]).reason == "a=b c"


@for_each(
    ("assignment", "said"),
    [
        ("twist.linear.x", "no FIELD=VALUE"),
        ("twist.linaer.x=1", "did you mean 'linear'"),
        ("twist.linear=1", "inner fields"),
        ("twist.linear.x.y=1", "no inner fields"),
        ("twist.linear.x=fast", "does not fit"),
    ],
)
def test_a_mistake_says_what_to_do(assignment: str, said: str) -> None:
    with pytest.raises(CodecError, match=said):
        value_from_text(navigation.VELOCITY_COMMAND, [assignment])


@for_each(
    ("assignment", "said"),
    [
        ("behaviour=explor", r"GCM_Autonomy_Command\.behaviour: .* GO, .*mean 'EXPLORE'"),
        ("behaviour=99", "one of HOLD, "),
        ("points=many", "points: 'many' does not fit there; give a JSON list"),
        ("points=1,2", "give a JSON list"),
        ("points=1", "give a JSON list"),
    ],
)
def test_a_value_that_does_not_fit_says_which_would(assignment: str, said: str) -> None:
    with pytest.raises(CodecError, match=said):
        value_from_text(AUTONOMY_COMMAND, [assignment])


def test_a_value_that_receivers_would_refuse_is_not_sent() -> None:
    fast = value_from_text(navigation.VELOCITY_COMMAND, ["twist.linear.x=1e9"])
    with pytest.raises(RangeError, match=r"twist\.linear\.x"):
        demand_within_ranges(navigation.VELOCITY_COMMAND, fast)
    demand_within_ranges(navigation.STOP, value_from_text(navigation.STOP, []))


def test_messages_without_a_dataclass_work_alike() -> None:
    unknown: MessageDefinition[object] = from_listing(to_listing(navigation.VELOCITY_COMMAND))
    value = value_from_text(unknown, ["twist.linear.x=0.5"])
    assert plain(value)["twist"]["linear"] == {"x": 0.5, "y": 0.0, "z": 0.0}


def test_every_value_is_json() -> None:
    state = value_from_text(navigation.ROBOT_STATE, ["battery_voltage=nan"])
    told = json.loads(json.dumps(plain(state)))
    assert told["battery_voltage"] == "nan"
    readings = value_from_text(RANGES, [])
    assert json.loads(json.dumps(plain(readings))) == {"scans": []}


def test_lines_are_one_a_field_and_indent_inner_ones() -> None:
    twist = Twist.planar(0.5, math.pi)
    assert list(lines(twist)) == [
        "linear:",
        "  x: 0.5",
        "  y: 0",
        "  z: 0",
        "angular:",
        "  x: 0",
        "  y: 0",
        "  z: 3.14159",
    ]


def test_lines_show_a_time_of_day_to_the_millisecond() -> None:
    state = value_from_text(navigation.ROBOT_STATE, ["stamp=1795255732.1234"])
    assert next(lines(state)) == "stamp: 1795255732.123"


def test_lines_show_no_control_characters() -> None:
    assert list(lines(navigation.Stop(reason="\x1b[2J"))) == ["reason: '\\x1b[2J'"]


def test_long_arrays_are_cut() -> None:
    image = value_from_text(vision.IMAGE, [])
    shown = [line for line in lines(image) if line.startswith("data")]
    assert shown == ["data: []"]
    assert np.all([len(line) < 500 for line in shown])


CHAIN = definition_of(formats.parse("{int,*!}"))
ROUTES = definition_of(formats.parse("{*{{int,int},*!},uint,<{*!,string}:2>,double}"))


def _chain(length: int) -> Any:
    first: Any = None
    for number in range(length, 0, -1):
        first = (number, first)
    return CHAIN.build(first)


def test_a_linked_list_is_a_list_of_its_nodes() -> None:
    one, two = ((1, 2), None), ((1, 2), ((3, 4), None))
    routes = ROUTES.build((two, 2, ((None, "x"), ((None, "z"), "y")), 0.5))
    assert plain(routes, ROUTES.record) == {
        "a0": [{"b0": {"c0": 1, "c1": 2}}, {"b0": {"c0": 3, "c1": 4}}],
        "a1": 2,
        "a2": [[{"b1": "x"}], [{"b1": "y"}, {"b1": "z"}]],
        "a3": 0.5,
    }
    assert plain(ROUTES.build((one, 0, (), 0.5)), ROUTES.record)["a0"] == [
        {"b0": {"c0": 1, "c1": 2}}
    ]
    assert plain(ROUTES.build((None, 0, (), 0.5)), ROUTES.record)["a0"] == []


def test_a_message_that_is_a_list_has_the_field_nodes_as_in_its_schema() -> None:
    assert plain(_chain(2), CHAIN.record) == {"nodes": [{"a0": 1}, {"a0": 2}]}
    assert list(lines(_chain(2), CHAIN.record)) == ['nodes: [{"a0": 1}, {"a0": 2}]']


@pytest.mark.parametrize("length", [1, 900, 2000, formats.MAX_NODES])
def test_a_list_as_long_as_any_can_be_sent_read_and_shown(length: int) -> None:
    payload = b"".join(CHAIN.encode(_chain(length)))
    back = CHAIN.decode(payload)
    assert b"".join(CHAIN.encode(back)) == payload
    told = json.loads(json.dumps(plain(back, CHAIN.record)))
    assert [node["a0"] for node in told["nodes"]] == list(range(1, length + 1))
    (line,) = lines(back, CHAIN.record)
    assert len(line) < 2000


def test_a_longer_list_or_one_in_a_circle_is_refused() -> None:
    first = _chain(formats.MAX_NODES)
    longer = type(first)(a0=0, a1=first)
    for work in (CHAIN.encode, lambda value: plain(value, CHAIN.record)):
        with pytest.raises(
            CodecError, match="longer than 10000 nodes, or one that runs in a circle"
        ):
            work(longer)


@given(st.data())
def test_every_value_of_every_format_is_json_and_lines(data: st.DataObject) -> None:
    definition = definition_of(data.draw(structs()))
    value = definition.build(data.draw(values_of(definition.tree)))
    text = json.dumps(plain(value, definition.record), allow_nan=False)
    assert "\n" not in text
    assert all(line.isprintable() for line in lines(value, definition.record))


@given(st.data())
def test_every_format_has_a_value_of_zeros(data: st.DataObject) -> None:
    definition = definition_of(data.draw(structs()))
    value = value_from_text(definition, [])
    assert b"".join(definition.encode(value))
