"""FIELD=VALUE on the command line, and values as people and programs read them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from hub.errors import CodecError
from hub.gcm import navigation, vision
from hub.gcm.catalog import MESSAGES
from hub.inspection.values import lines, plain, value_from_text
from hub.ipc.definition import MessageDefinition
from hub.ipc.description import from_listing, to_listing


def test_fields_left_out_are_zero_for_every_message_of_the_vocabulary() -> None:
    for definition in MESSAGES:
        value = value_from_text(definition, [])
        payload = b"".join(definition.encode(value))
        assert plain(definition.decode(payload)) == plain(value)


def test_inner_fields_are_reached_with_dots() -> None:
    twist = value_from_text(navigation.VELOCITY_COMMAND, ["linear.x=0.5", "angular.z=-1"])
    assert twist == navigation.Twist.planar(0.5, -1.0)


def test_enum_members_go_by_name_or_number() -> None:
    by_name = value_from_text(vision.IMAGE_REQUEST, ["kind=grey"])
    by_number = value_from_text(vision.IMAGE_REQUEST, ["kind=0"])
    assert by_name == by_number
    assert by_name.kind is vision.ImageKind.GREY


def test_arrays_are_json_lists() -> None:
    sonar = value_from_text(navigation.DRIVE_STATE, [f"sonar={[1.5] * 16}"]).sonar
    assert sonar == [1.5] * 16


def test_text_is_taken_as_it_is() -> None:
    assert value_from_text(navigation.STOP, ["reason=a=b c"]).reason == "a=b c"


@pytest.mark.parametrize(
    ("assignment", "said"),
    [
        ("linear.x", "no FIELD=VALUE"),
        ("linaer.x=1", "did you mean 'linear'"),
        ("linear=1", "inner fields"),
        ("linear.x.y=1", "no inner fields"),
        ("linear.x=fast", "does not fit"),
    ],
)
def test_a_mistake_says_what_to_do(assignment: str, said: str) -> None:
    with pytest.raises(CodecError, match=said):
        value_from_text(navigation.VELOCITY_COMMAND, [assignment])


def test_messages_without_a_dataclass_work_alike() -> None:
    unknown: MessageDefinition[object] = from_listing(to_listing(navigation.VELOCITY_COMMAND))
    value = value_from_text(unknown, ["linear.x=0.5"])
    assert plain(value)["linear"] == {"x": 0.5, "y": 0.0, "z": 0.0}


def test_every_value_is_json() -> None:
    state = value_from_text(navigation.DRIVE_STATE, ["battery_voltage=nan"])
    told = json.loads(json.dumps(plain(state)))
    assert told["battery_voltage"] == "nan"
    assert told["sonar"] == [0.0] * 16


def test_lines_are_one_a_field_and_indent_inner_ones() -> None:
    twist = navigation.Twist.planar(0.5, math.pi)
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


def test_lines_show_no_control_characters() -> None:
    assert list(lines(navigation.Stop(reason="\x1b[2J"))) == ["reason: '\\x1b[2J'"]


def test_long_arrays_are_cut() -> None:
    image = value_from_text(vision.IMAGE, [])
    shown = [line for line in lines(image) if line.startswith("data")]
    assert shown == ["data: []"]
    assert np.all([len(line) < 500 for line in shown])
