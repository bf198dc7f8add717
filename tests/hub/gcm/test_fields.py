"""Every field of every message declares what it may hold, and no value passes that is not so."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import typing
from random import Random
from typing import Any

import numpy as np
import pytest

from hub.errors import CodecError, RangeError
from hub.gcm import navigation, vision
from hub.gcm.body import RangeGroup, RangeKind
from hub.gcm.catalog import MESSAGES
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.geometry import TwistStamped
from hub.gcm.mapping import MAP
from hub.gcm.navigation import GOAL_COMMAND, ROBOT_STATE, STOP, VELOCITY_COMMAND, Stop
from hub.gcm.ranges import RANGES, RangeReadings, scan_of
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.ipc.formats import ranges, wire_types
from hub.plain_text import is_plain
from tests.hub.gcm.test_wire import value_of
from tests.support import extremes
from tests.support.cases import for_each
from tests.support.messages import camera_state, robot_state

EACH = int(os.environ.get("RUNE_EXTREMES", "30"))
by_definition = for_each("definition", MESSAGES)


def undeclared(tree: Any, kind: Any, where: str) -> list[str]:
    """Fields without a declaration; sizes of arrays are declared by the arrays."""
    found: list[str] = []
    for member, node in zip(wire_types.members(kind), tree.members, strict=True):
        hint, name = member.hint, f"{where}.{member.name}"
        if isinstance(node, formats.Struct):
            found += undeclared(node, ranges.bare(hint), name)
        elif isinstance(node, formats.VariableArray):
            if not any(isinstance(each, ranges.Most) for each in ranges.declared(hint)):
                found.append(name)
            if isinstance(node.element, formats.Struct):
                inner = typing.get_args(ranges.bare(hint))[0]
                found += undeclared(node.element, inner, name)
        elif isinstance(node, formats.Enum):
            if not extremes.is_enum(hint):
                found.append(name)
        elif hint is bool or extremes.is_enum(hint):
            continue  # the type has no other values
        elif not member.counts and not ranges.declared(hint):
            found.append(name)
    return found


@by_definition
def test_every_field_declares_its_range(definition: MessageDefinition[Any]) -> None:
    missing = undeclared(definition.tree, definition.type, definition.name)
    assert not missing, f"give each a type of hub/gcm/fields.py, or a Range of its own: {missing}"


def misfits(value: Any, hint: Any, where: str) -> list[str]:
    """What of a value is not as it is declared, looked at apart from the code that bounds it."""
    found = []
    for each in ranges.declared(hint):
        if isinstance(each, ranges.Range):
            with np.errstate(invalid="ignore"):  # of a NaN that signals
                numbers = value.tolist() if isinstance(value, np.ndarray) else [value]
            good = all(
                each.low <= number <= each.high
                or (each.nan and number != number)
                or (each.infinite and number == math.inf)
                for number in numbers
            )
            found += [] if good else [where]
        elif isinstance(each, ranges.Text):
            texts = value if isinstance(value, tuple) else (value,)
            good = all(len(one) <= each.most and is_plain(one, lines=each.lines) for one in texts)
            found += [] if good else [where]
        elif len(value) > each.count:
            found.append(where)
    if dataclasses.is_dataclass(value):
        for name, inner_hint in extremes.fields_of(type(value)):
            found += misfits(getattr(value, name), inner_hint, f"{where}.{name}")
    elif isinstance(value, tuple):
        entry = typing.get_args(ranges.bare(hint))[0]
        for item in value:
            found += misfits(item, entry, where)
    return found


@pytest.mark.timeout(1800 if EACH > 100 else 300)
@by_definition
def test_nothing_passes_that_is_not_as_declared(definition: MessageDefinition[Any]) -> None:
    passed = 0
    for payload in itertools.islice(extremes.payloads(definition, Random(1)), EACH):
        try:
            value = definition.decode(payload)
        except CodecError:
            assert definition is not STOP
            continue
        passed += 1
        assert misfits(value, definition.type, definition.name) == []
    assert passed >= EACH // 10


@by_definition
def test_flat_messages_are_bounded_like_all_others(definition: MessageDefinition[Any]) -> None:
    if definition.flat_letters is None:
        return
    values = definition.flat_values(value_of(definition))
    wild = [1e308 if isinstance(each, float) else each for each in values]
    try:
        value = definition.receive_flat(tuple(wild))
    except RangeError:
        return
    assert misfits(value, definition.type, definition.name) == []


def back(definition: MessageDefinition[Any], value: Any) -> tuple[Any, list[str]]:
    notes: list[str] = []
    return definition.decode(b"".join(definition.encode(value)), notes.append), notes


def test_what_an_ordinary_robot_says_is_not_changed() -> None:
    for definition, value in (
        (ROBOT_STATE, robot_state(x=3.0, battery_voltage=math.nan)),
        (vision.CAMERA_STATE, camera_state()),
        (CONTROL_STATE, ControlState(operator="Änne", why="was free")),
    ):
        _, notes = back(definition, value)
        assert notes == []


def test_a_number_that_may_be_unknown_becomes_unknown_and_that_is_told() -> None:
    value, notes = back(ROBOT_STATE, robot_state(battery_voltage=1e30))
    assert math.isnan(value.battery_voltage)
    assert len(notes) == 1
    assert "GCM_RobotState.battery_voltage" in notes[0]
    sonar = np.full(16, 3e38, np.float32)
    sonar[:3] = np.inf, np.nan, -1.0
    scan = scan_of(RangeGroup(name="sonar", kind=RangeKind.SONAR, farthest=5.0), sonar, 0.0)
    scan = dataclasses.replace(scan, ranges=sonar)
    readings, notes = back(RANGES, RangeReadings(scans=(scan,)))
    ranges = readings.scans[0].ranges
    assert np.isinf(ranges[0])
    assert np.isnan(ranges[1:]).all()
    assert not ranges.flags.writeable
    assert len(notes) == 1
    assert "GCM_Ranges" in notes[0]


@for_each("metres", [math.nan, math.inf, 1e7, -1e308])
def test_a_number_that_has_to_be_known_refuses_the_message(metres: float) -> None:
    with pytest.raises(RangeError, match=r"GCM_RobotState\.x is .*, not -1e\+06 to 1e\+06 m"):
        back(ROBOT_STATE, robot_state(x=metres))


@for_each("speed", [math.nan, math.inf, -math.inf, 1e308, 101.0])
def test_a_command_that_no_robot_can_follow_is_refused_whole(speed: float) -> None:
    with pytest.raises(RangeError):
        back(VELOCITY_COMMAND, TwistStamped.planar(0.1, speed))
    command = navigation.GoalCommand(linear_limit=speed)
    if math.isnan(speed):  # the robot's own limit
        back(GOAL_COMMAND, command)
        return
    with pytest.raises(RangeError):
        back(GOAL_COMMAND, command)


@for_each("payload", [b"", b"\0\1\0\0", b"\xff" * 40, b"\0\1\0\0\xff\xff\xff\xff", bytes(70_000)])
def test_a_stop_counts_whatever_it_holds(payload: bytes) -> None:
    assert isinstance(STOP.decode(payload), Stop)
    reason = "\x1b[2J" + "x" * 100_000
    stop, notes = back(STOP, Stop(reason=reason))
    assert stop.reason.startswith("\\x1b[2Jxxx")
    assert len(stop.reason) == 1000
    assert notes


@pytest.mark.parametrize("wrong", [{"left_s": math.nan}, {"held_s": 1e308}, {"held_s": math.nan}])
def test_control_of_no_known_time_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(RangeError, match="GCM_Control_State"):
        back(CONTROL_STATE, ControlState(asker=7, **wrong))


@for_each(
    "changes",
    [{"resolution": 1e-4}, {"resolution": math.nan}, {"origin_x": 1e300}, {"width_cells": 8193}],
)
def test_a_map_that_lies_nowhere_or_has_absurd_cells_is_refused(changes: dict[str, Any]) -> None:
    values = {"stamp": 0.0, "resolution": 0.05, "width_cells": 1, "height_cells": 1}
    rest = {"origin_x": 0.0, "origin_y": 0.0, "data": np.zeros(1, np.uint8)}
    with pytest.raises(RangeError, match="GCM_Common_Map"):
        back(MAP, MAP.type(**values | rest | changes))
